"""Joints beside the path: what the method gives up, what it keeps, and how close to the best it comes."""

import numpy as np
import pytest
from following_oracles import SLIDER, random_path
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

import hognose
from hognose.following import body_deviation
from hognose.following.balanced import balanced_curve
from hognose.path import Path
from hognose.planning.planner import insertion
from hognose.robot.kinematics import angles_of

LENGTHS = np.full(12, 0.091)
seeds = st.integers(0, 2**32 - 1)


def nearest_by_search(path, points):
    """Distance of each point to the path, by a dense march and a bounded search round its best sample."""
    arcs = np.arange(0, path.length, 2e-4)
    samples = path.point(arcs)
    found = []
    for point in points:
        best = arcs[np.argmin(np.linalg.norm(samples - point, axis=1))]
        low, high = max(best - 4e-4, 0.0), min(best + 4e-4, path.length)
        result = minimize_scalar(
            lambda s, p=point: float(np.linalg.norm(path.point(s) - p)), bounds=(low, high), method="bounded"
        )
        found.append(result.fun)
    return np.array(found)


@pytest.mark.parametrize("name", ["obstacle-array", "pipe-tank", "detour"])
def test_the_body_stays_closer_to_the_paths_of_the_bundled_tasks(name):
    task = hognose.load_task(name)
    exact = hognose.plan(task)
    method = hognose.follower(exact.path, task.robot.link_lengths, "balanced")
    feeds = insertion(task, method.curve).feed
    joints = method.run(feeds)
    assert body_deviation(exact.path, joints).max() <= 0.55 * exact.body_deviation.max()
    links = np.linalg.norm(np.diff(joints, axis=1), axis=2)
    np.testing.assert_allclose(links, np.broadcast_to(task.robot.link_lengths, links.shape), rtol=0, atol=1e-12)
    np.testing.assert_allclose(joints[-1, -1], task.way_points[-1], rtol=0, atol=1e-11)
    angles = task.robot.angles(joints)
    bend, before = np.abs(angles).max(), np.abs(exact.angles).max()
    assert before < bend < 1.1 * before
    jerk = np.abs(np.diff(angles[:-1], 2, axis=0)).max()
    assert jerk < 2 * np.abs(np.diff(exact.angles[:-1], 2, axis=0)).max()


@settings(deadline=None, max_examples=10)
@given(seeds, st.sampled_from([3, 5]))
def test_on_gentle_paths_it_halves_the_deviation_and_follows_its_curve_exactly(seed, order):
    path = random_path(seed, "gentle", order)
    follower = hognose.follower(path, LENGTHS, "balanced")
    feeds = np.linspace(0.0, min(1.0, path.length - 1.3), 150)
    joints = follower.run(feeds)
    assert follower.curve.distance_to(joints).max() < 1e-11
    links = np.linalg.norm(np.diff(joints, axis=1), axis=2)
    np.testing.assert_allclose(links, np.broadcast_to(LENGTHS, links.shape), rtol=0, atol=1e-12)
    # The base is on the slider, at the feed.
    np.testing.assert_allclose(joints[:, 0], path.point(feeds), rtol=0, atol=1e-13)
    exact = hognose.follow(path, LENGTHS, feeds)
    ratio = body_deviation(path, joints).max() / body_deviation(path, exact).max()
    assert 0.49 < ratio < 0.85, ratio


def test_it_takes_what_the_bend_limits_leave_of_the_offset():
    """Where exact following bends almost as far as the joints can, balanced must not bend further."""
    taken = []
    for seed in range(24):
        path = random_path(seed)
        feeds = np.arange(0.0, min(1.0, path.length - 1.3), 0.0035)
        plain = hognose.follow(path, LENGTHS, feeds)
        whole_path = np.arange(0.0, min(1.1, path.length - 1.2), 0.002)
        limit = 1.02 * np.abs(angles_of(hognose.follow(path, LENGTHS, whole_path))).max()
        joints = hognose.follow(path, LENGTHS, feeds, "balanced", bend_limits=limit)
        assert np.abs(angles_of(joints)).max() <= limit
        taken.append(body_deviation(path, joints).max() / body_deviation(path, plain).max())
    # Less than with free joints, but mostly something.
    assert 0.5 < np.median(taken) < 0.95
    assert max(taken) < 1.001


def test_a_path_of_too_many_links_is_refused():
    path = Path.through([[0, 0, 0], [0, 1, 100], [0, 0, 200]], 3)
    with pytest.raises(hognose.InputError, match=r"2 mm on a path of 200.* at most 25,000 links"):
        hognose.follower(path, [0.002, 0.002], "balanced")


@pytest.mark.parametrize("radius", [0.3, 0.6])
def test_on_an_arc_joints_and_mid_links_share_the_sagitta_equally(radius):
    """Far from the ends the best offset is known: half the sagitta L²/(8R), outwards."""
    turn = np.linspace(0, 1.5 * np.pi, 60)
    path = Path.through(np.column_stack([radius * np.cos(turn), radius * np.sin(turn), 0 * turn]), 5)
    curve = balanced_curve(path, 0.05)
    arcs = np.linspace(0.3, 0.7, 50) * path.length
    radii = np.linalg.norm(curve.point(curve.arc_length(arcs))[:, :2], axis=1)
    sagitta = radius - np.sqrt(radius**2 - 0.025**2)
    np.testing.assert_allclose(radii - radius, sagitta / 2, rtol=0.04)


def test_the_curve_is_smooth_and_leaves_the_ends_alone():
    path = random_path(5, "gentle", 5)
    curve = balanced_curve(path, 0.091)
    before, after = (curve.frame(curve.break_arcs[1:-1] + shift) for shift in (-1e-9, 1e-9))
    np.testing.assert_allclose(before, after, rtol=0, atol=2e-6)
    for arc in (0.0, 0.5, 1.0):  # on the run
        np.testing.assert_allclose(curve.point(arc), path.point(arc), rtol=0, atol=1e-14)
    np.testing.assert_allclose(curve.point(curve.length), path.point(path.length), rtol=0, atol=1e-14)
    np.testing.assert_allclose(curve.tangent(curve.length), path.tangent(path.length), rtol=0, atol=1e-12)


def test_a_straight_path_is_its_own_curve():
    path = Path.through([[0, 0, 0], [0, 0, 0.4], [0, 0, 1.7]], 3, SLIDER).with_run(0.3)
    joints = hognose.follow(path, LENGTHS, [0.0, 0.2], "balanced")
    np.testing.assert_allclose(joints[..., :2], 0, atol=1e-15)
    np.testing.assert_allclose(np.diff(joints[..., 2]), 0.091, rtol=0, atol=1e-12)


@pytest.mark.parametrize("kind", ["gentle", "wild"])
def test_body_deviation_is_the_distance_of_points_along_the_links(kind):
    path = random_path(3, kind)
    feeds = np.array([0.2, 0.6, 0.9])
    joints = hognose.follow(path, np.full(5, 0.091), feeds) + np.array([0.001, 0, 0])
    found = body_deviation(path, joints, samples=8)
    for row, expected in zip(joints, found, strict=True):
        for link in range(5):
            part = np.arange(9)[:, None] / 8
            along = row[link] + part * (row[link + 1] - row[link])
            assert nearest_by_search(path, along).max() == pytest.approx(expected[link], abs=1e-9)


@pytest.mark.parametrize("length", [0.02, 1 / 3, 0.37, 1.0, 2.0])
@pytest.mark.parametrize("order", [1, 3])
@pytest.mark.parametrize("shift", [-1e-16, 0.0, 1e-16])
def test_on_a_straight_path_its_curve_is_the_path(length, order, shift):
    """Straight to its end a path leaves nothing, or a rounding error more or less, to be balanced."""
    tilted = np.array([0.0, 0.6, 0.8]) * (1.0 + shift)
    path = Path.through([np.zeros(3), length * tilted], order=order, start_direction=None if order == 1 else tilted)
    for straight in (path, path.with_run(1.1)):
        s = np.linspace(0.0, straight.length, 101)
        curve = balanced_curve(straight, 0.091)
        np.testing.assert_allclose(curve.point(s), straight.point(s), rtol=0, atol=1e-14)
