import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_oracles import KINDS, brute_distance, random_obstacle

from hognose.scene import Board, Hole, Scene

seeds = st.integers(0, 2**32 - 1)


def smooth_motion(rng, steps, links, pace):
    """Links that wander through the scene, about `pace` m a step, and now and then jump."""
    t = np.arange(steps)[:, None, None]
    waves = rng.normal(size=(3, links, 3)) / 3
    phase = rng.uniform(0, 2 * np.pi, (3, links, 3))
    rate = pace * rng.uniform(0.5, 2, (3, links, 3))
    starts = (waves[:, None] * np.sin(rate[:, None] * t + phase[:, None])).sum(axis=0)
    starts[steps // 2 :, : links // 2] += rng.normal(size=3)
    along = rng.normal(size=(links, 3)) + 0.3 * np.sin(pace * t)
    return starts, starts + 0.091 * along / np.linalg.norm(along, axis=-1, keepdims=True)


@given(
    seed=seeds,
    horizon=st.sampled_from([0.0, 0.01, 0.05, 0.3, np.inf]),
    pace=st.sampled_from([1e-4, 3e-3, 0.02, 0.2]),
    kinds=st.lists(st.sampled_from(KINDS), min_size=1, max_size=5),
)
@settings(max_examples=60, deadline=None)
def test_warm_batch_equals_cold_queries_cut_at_the_horizon(seed, horizon, pace, kinds):
    rng = np.random.default_rng(seed)
    scene = Scene.from_obstacles([random_obstacle(kind, rng) for kind in kinds], tolerance=1e-3)
    starts, ends = smooth_motion(rng, 80, 5, pace)
    radii = rng.uniform(0, 0.05, 5)
    found = scene.clearance(starts, ends, radii, horizon)
    cold = scene.distance(starts.reshape(-1, 3), ends.reshape(-1, 3)).value.reshape(80, 5) - radii

    np.testing.assert_allclose(found.value, np.minimum(cold, horizon), atol=1e-12)
    assert np.array_equal(found.triangle == -1, found.value == horizon)
    assert (found.value >= -radii).all()
    steps, links = np.nonzero(found.triangle >= 0)
    for step, link in list(zip(steps, links, strict=True))[:: max(1, len(steps) // 10)]:
        only = scene.triangles[found.triangle[step, link]][None]
        distance = brute_distance(starts[step, link][None], ends[step, link][None], only)
        np.testing.assert_allclose(distance - radii[link], found.value[step, link], atol=1e-9)


@given(seed=seeds, horizon=st.sampled_from([0.01, 0.05, np.inf]), pace=st.sampled_from([1e-4, 3e-3, 0.05]))
@settings(max_examples=30, deadline=None)
def test_the_clearance_of_a_part_is_the_smallest_of_its_links(seed, horizon, pace):
    rng = np.random.default_rng(seed)
    scene = Scene.from_obstacles([random_obstacle(kind, rng) for kind in rng.choice(KINDS, 3)], tolerance=1e-3)
    starts, ends = smooth_motion(rng, 60, 9, pace)
    radii, first = rng.uniform(0, 0.05, 9), np.array([0, 1, 5])
    found = scene.clearance(starts, ends, radii, horizon, first=first)
    each = scene.clearance(starts, ends, radii, horizon)
    np.testing.assert_allclose(found.value, np.minimum.reduceat(each.value, first, axis=1), atol=1e-15)
    assert np.array_equal(found.triangle == -1, found.value == horizon)


@given(seed=seeds, fixed=st.sampled_from(["start", "end", "middle"]), turn=st.sampled_from([0.01, 0.1, 0.5]))
@settings(max_examples=60)
def test_links_that_turn_about_a_fixed_place_are_not_taken_for_resting(seed, fixed, turn):
    """One end goes round while the other stays: what was seen of the link before holds for the end that moved less."""
    rng = np.random.default_rng(seed)
    scene = Scene.from_obstacles([random_obstacle(kind, rng) for kind in rng.choice(KINDS, 3)], tolerance=1e-3)
    steps, links = 60, 4
    axis, along = np.linalg.qr(rng.normal(size=(links, 3, 3)))[0][:, :, :2].transpose(2, 0, 1)
    angle = turn * np.arange(steps)[:, None, None]
    arms = np.cos(angle) * along + np.sin(angle) * np.cross(axis, along)
    arms = rng.uniform(0.02, 0.6, (links, 1)) * arms
    pivot = np.broadcast_to(rng.uniform(-0.4, 0.4, (links, 3)), arms.shape)
    starts, ends = {
        "start": (pivot, pivot + arms),
        "end": (pivot + arms, pivot),
        "middle": (pivot - arms, pivot + arms),
    }[fixed]
    horizon, radii = rng.choice([0.0, 0.01, 0.05]), rng.uniform(0, 0.02, links)
    found = scene.clearance(starts, ends, radii, horizon)
    cold = scene.distance(starts.reshape(-1, 3), ends.reshape(-1, 3)).value.reshape(steps, links) - radii
    np.testing.assert_allclose(found.value, np.minimum(cold, horizon), rtol=0, atol=1e-12)


@pytest.mark.parametrize(("steps", "links"), [(1000, 2), (3, 700), (313, 12)])
def test_threads_change_nothing(steps, links):
    rng = np.random.default_rng(steps)
    scene = Scene.from_obstacles([random_obstacle(kind, rng) for kind in KINDS])
    starts, ends = smooth_motion(rng, steps, links, 3e-3)
    radii = np.full(links, 0.0225)
    one, five = (scene.clearance(starts, ends, radii, threads=count) for count in (1, 5))
    np.testing.assert_allclose(one.value, five.value, atol=1e-14)


def test_a_link_through_the_middle_of_a_hole_clears_it_by_the_difference_of_the_radii():
    board = Board(center=(0, 0, 0.3), size=(0.6, 0.6), thickness=0.01, hole=(Hole(center=(0, 0), diameter=0.1),))
    scene = Scene.from_obstacles([board])
    tips = np.linspace(0.1, 0.6, 101)
    ends = np.zeros((101, 1, 3))
    ends[:, 0, 2] = tips
    found = scene.clearance(ends - [0, 0, 0.091], ends, [0.0225])
    through = (tips > 0.295) & (tips < 0.396)
    # The hole is inscribed: at most the tolerance narrower, never wider.
    assert (found.value[through, 0] <= 0.0275).all()
    assert (found.value[through, 0] >= 0.0275 - 1e-4).all()
    value, step, link = found.smallest()
    assert through[step]
    assert link == 0
    assert scene.obstacle_of(int(found.triangle[step, 0])) == "board 1"
    assert value == found.value.min()


def test_a_link_that_cuts_a_board_is_negative_down_to_minus_its_radius():
    scene = Scene.from_obstacles([Board(center=(0, 0, 0), size=(1, 1), thickness=0.01)])
    starts = np.array([[[0.1, 0.2, -0.05]], [[0.1, 0.2, 0.015]]])
    found = scene.clearance(starts, starts + np.array([0, 0, 0.09]), [0.02])
    np.testing.assert_allclose(found.value[:, 0], [-0.02, -0.01], atol=1e-15)


def test_no_steps_and_no_links_are_allowed():
    scene = Scene.from_obstacles([Board(center=(0, 0, 0), size=(1, 1), thickness=0.01)])
    assert scene.clearance(np.empty((0, 3, 3)), np.empty((0, 3, 3)), [0.1] * 3).value.shape == (0, 3)
    assert scene.clearance(np.empty((4, 0, 3)), np.empty((4, 0, 3)), []).value.shape == (4, 0)
