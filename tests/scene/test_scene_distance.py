from typing import Any

import coal as coal_module
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_oracles import KINDS, brute_distance, contains, random_obstacle, surface_points
from scipy.spatial.transform import Rotation

from hognose.errors import InputError
from hognose.scene import Box, Scene, Sphere

coal: Any = coal_module  # it comes without types
seeds = st.integers(0, 2**32 - 1)


def random_segments(rng, count, extent=0.5):
    starts = rng.uniform(-extent, extent, (count, 3))
    length = 10 ** rng.uniform(-3, 0, (count, 1))
    ends = starts + length * rng.normal(size=(count, 3))
    ends[::7] = starts[::7]
    return starts, ends


def random_triangles(rng, count):
    """Triangles of all shapes: on a grid, so that they touch and align; flat, thin, and single points."""
    triangles = rng.uniform(-0.5, 0.5, (count, 3, 3))
    triangles[: count // 3] = np.round(triangles[: count // 3] * 4) / 4
    triangles[::5, 2] = triangles[::5, 0] + rng.uniform() * (triangles[::5, 1] - triangles[::5, 0])
    triangles[::7, 2] = triangles[::7, 1]
    triangles[::11] = triangles[::11, :1]
    thin = slice(3, None, 6)
    lean = 10 ** rng.uniform(-13, -2, (len(triangles[thin]), 1))
    triangles[thin, 2] = (triangles[thin, 0] + triangles[thin, 1]) / 2 + lean * rng.normal(size=lean.shape)
    return triangles


def check_against_brute_force(scene, starts, ends):
    found = scene.distance(starts, ends)
    exact = brute_distance(starts, ends, scene.triangles)
    np.testing.assert_allclose(found.value, exact.min(axis=1), atol=1e-9)
    np.testing.assert_allclose(exact[np.arange(len(starts)), found.triangle], found.value, atol=1e-9)
    # The witnesses are as far apart as they should be, one on the segment and one on the triangle.
    np.testing.assert_allclose(np.linalg.norm(found.on_segment - found.on_mesh, axis=1), found.value, atol=1e-9)
    for i, triangle in enumerate(found.triangle):
        corner = scene.triangles[triangle : triangle + 1]
        assert brute_distance(found.on_mesh[i : i + 1], found.on_mesh[i : i + 1], corner) < 1e-9
        onto = found.on_segment[i : i + 1]
        line = np.stack([starts[i], ends[i], ends[i]])[None]
        assert brute_distance(onto, onto, line) < 1e-9


@given(seed=seeds, count=st.integers(1, 40))
@settings(max_examples=60, deadline=None)
def test_random_and_degenerate_triangles_against_brute_force(seed, count):
    rng = np.random.default_rng(seed)
    scene = Scene.from_meshes(["soup"], [random_triangles(rng, count)])
    starts, ends = random_segments(rng, 20)
    starts[:6], ends[:6] = np.round(starts[:6] * 4) / 4, np.round(ends[:6] * 4) / 4
    # Some in the plane or along an edge of a triangle, some ending on a corner.
    a, b, c = scene.triangles[rng.integers(count, size=6)].transpose(1, 0, 2)
    along = rng.uniform(-1, 2, (6, 1))
    starts[6:12], ends[6:12] = a + along * (b - a), a + (along + 0.5) * (b - a)
    starts[12:15], ends[12:15] = (a + c)[:3], (b - c)[:3]
    ends[15:18] = c[:3]
    check_against_brute_force(scene, starts, ends)


@pytest.mark.parametrize("kind", KINDS)
@given(seed=seeds)
@settings(max_examples=6, deadline=None)
def test_each_kind_against_brute_force(kind, seed):
    rng = np.random.default_rng(seed)
    scene = Scene.from_obstacles([random_obstacle(kind, rng)], tolerance=2e-3)
    starts, ends = random_segments(rng, 8)
    check_against_brute_force(scene, starts, ends)


@pytest.mark.parametrize("kind", ["box", "board", "tank", "cylinder"])
@given(seed=seeds)
@settings(max_examples=10, deadline=None)
def test_nothing_slips_between_the_triangles_of_a_flat_face(kind, seed):
    rng = np.random.default_rng(seed)
    scene = Scene.from_obstacles([random_obstacle(kind, rng)], tolerance=5e-3)
    m = len(scene.triangles)
    corner = scene.triangles[rng.integers(m, size=24)]
    a, b, c = corner.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    # Seen over a point of an edge: standing upright, through it, leaning, along the face, nearly along it.
    over = a + rng.uniform(0, 1, (24, 1)) * (b - a)
    over[::6] = a[::6]
    up = 10 ** rng.uniform(-12, -1, (24, 1)) * normal
    lean = rng.uniform(-1, 1, (24, 1)) * (b - a) + rng.uniform(-1, 1, (24, 1)) * (c - a)
    tilt = 10 ** rng.uniform(-16, -2, (24, 1)) * normal
    which = rng.integers(5, size=24)[:, None]
    starts = np.select([which == 0, which == 1, which == 2], [over + up, over - up, over + up], over + up - lean)
    ends = np.select(
        [which == 0, which == 1, which == 2, which == 3],
        [over + up, over + up, over + 2 * up + lean, over + up + lean],
        over - tilt + lean,
    )
    check_against_brute_force(scene, starts, ends)


def test_a_roof_too_flat_to_have_a_ridge_is_found_from_high_above():
    ridge, slope = np.array([[-1.0, 0, 0], [1.0, 0, 0]]), 4e-10
    sides = [[ridge[0], ridge[1], (0, 1, -slope)], [ridge[1], ridge[0], (0, -1, -slope)]]
    scene = Scene.from_meshes(["roof"], [sides])
    start = np.array([[0.2, 0.0, 10.0]])
    np.testing.assert_allclose(scene.distance(start, start + np.array([0, 0, 5])).value, 10, rtol=1e-15)


@given(seed=seeds)
@settings(max_examples=25, deadline=None)
def test_agrees_with_coal(seed):
    rng = np.random.default_rng(seed)
    scene = Scene.from_obstacles([random_obstacle(kind, rng) for kind in KINDS], tolerance=1e-3)
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(scene.triangles), 3 * len(scene.triangles))
    for triangle in scene.triangles:
        model.addTriangle(*triangle)
    model.endModel()
    starts, ends = random_segments(rng, 12, extent=1.0)
    radius = 0.01
    ours = scene.distance(starts, ends).value - radius
    for start, end, clear in zip(starts, ends, ours, strict=True):
        axis = end - start
        length = float(np.linalg.norm(axis))
        if length == 0:
            continue
        turn = Rotation.align_vectors([axis / length], [[0, 0, 1]])[0].as_matrix()
        pose = coal.Transform3s(turn, (start + end) / 2)
        answer = coal.DistanceResult()
        request = coal.DistanceRequest()
        theirs = coal.distance(coal.Capsule(radius, length), pose, model, coal.Transform3s.Identity(), request, answer)
        if clear > 1e-4:
            assert theirs == pytest.approx(clear, abs=2e-6)
        elif clear < -1e-4:
            assert theirs <= 1e-6


@given(seed=seeds)
@settings(max_examples=15, deadline=None)
def test_moving_everything_rigidly_changes_no_distance(seed):
    rng = np.random.default_rng(seed)
    scene = Scene.from_obstacles([random_obstacle(kind, rng) for kind in KINDS])
    turn, shift = Rotation.from_rotvec(rng.uniform(-3, 3, 3)).as_matrix(), rng.uniform(-2, 2, 3)
    meshes = [scene.triangles[scene.owner == i] @ turn.T + shift for i in range(len(KINDS))]
    moved = Scene.from_meshes(scene.names, meshes)
    starts, ends = random_segments(rng, 50)
    here = scene.distance(starts, ends)
    there = moved.distance(starts @ turn.T + shift, ends @ turn.T + shift)
    np.testing.assert_allclose(there.value, here.value, atol=1e-12)
    np.testing.assert_array_equal(moved.inside(starts @ turn.T + shift), scene.inside(starts))


@pytest.mark.parametrize("kind", KINDS)
@given(seed=seeds)
@settings(max_examples=10, deadline=None)
def test_inside_agrees_with_the_analytic_solid(kind, seed):
    rng = np.random.default_rng(seed)
    item = random_obstacle(kind, rng)
    scene = Scene.from_obstacles([Sphere(center=(9, 9, 9), diameter=1), item])
    on_mesh, normal = surface_points(scene.triangles[scene.owner == 1], rng, 100)
    points = np.concatenate([on_mesh + 2e-3 * normal, on_mesh - 2e-3 * normal, rng.uniform(-1, 1, (200, 3))])
    within, near = contains(item, points, -1e-3), contains(item, points, 1e-3)
    clear_cut = within == near
    np.testing.assert_array_equal(scene.inside(points)[clear_cut], np.where(within, 1, -1)[clear_cut])


def test_missing_triangles_do_not_upset_inside():
    whole = Sphere(center=(0, 0, 0), diameter=1).triangles(1e-3)
    rng = np.random.default_rng(3)
    scene = Scene.from_meshes(["leaky"], [whole[rng.uniform(size=len(whole)) > 0.1]])
    points = rng.normal(size=(500, 3))
    points *= (rng.uniform(0, 0.4, 500) / np.linalg.norm(points, axis=1))[:, None]
    assert (scene.inside(points) == 0).all()
    assert (scene.inside(points + np.array([1.2, 0, 0])) == -1).all()


def test_distances_stop_at_the_upper_limit():
    scene = Scene.from_obstacles([Box(center=(0, 0, 0), size=(1, 1, 1))])
    found = scene.distance([[0.9, 0, 0], [2, 0, 0]], [[0.8, 0, 0], [3, 0, 0]], upper=0.5)
    np.testing.assert_allclose(found.value, [0.3, 0.5])
    assert found.triangle[0] >= 0
    assert found.triangle[1] == -1
    assert np.isnan(found.on_mesh[1]).all()
    np.testing.assert_allclose(found.on_mesh[0], [0.5, 0, 0], atol=1e-15)


def test_many_queries_are_the_same_on_several_threads():
    rng = np.random.default_rng(5)
    scene = Scene.from_obstacles([random_obstacle(kind, rng) for kind in KINDS])
    starts, ends = random_segments(rng, 4000)
    one, three = (scene.distance(starts, ends, threads=count) for count in (1, 3))
    np.testing.assert_array_equal(one.value, three.value)
    np.testing.assert_array_equal(one.on_mesh, three.on_mesh)


def test_witness_names_the_obstacle():
    scene = Scene.from_obstacles(
        [Sphere(center=(x, 0, 0), diameter=0.2, name=name) for x, name in ((0, None), (1, "ball"), (2, None))]
    )
    assert scene.names == ("sphere 1", "ball", "sphere 3")
    found = scene.witness((1, 1, 0), (1, 0.5, 0))
    assert found.obstacle == "ball"
    assert found.distance == pytest.approx(0.4, abs=2e-4)
    np.testing.assert_allclose(found.on_segment, (1, 0.5, 0))
    np.testing.assert_allclose(found.on_mesh, (1, 0.1, 0), atol=5e-3)


def test_an_empty_scene_is_nowhere_near():
    scene = Scene.from_obstacles([])
    found = scene.distance(np.zeros((2, 3)), np.ones((2, 3)))
    assert (found.value == np.inf).all()
    assert (found.triangle == -1).all()
    assert (scene.inside(np.zeros((2, 3))) == -1).all()
    assert (scene.clearance(np.zeros((4, 2, 3)), np.ones((4, 2, 3)), (0.1, 0.1), horizon=0.07).value == 0.07).all()
    assert scene.witness((0, 0, 0), (1, 1, 1)).obstacle is None


def test_a_deep_pile_of_equal_triangles_is_searched_too():
    one = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=float)
    spiral = one * 2.0 ** -np.arange(200)[:, None, None]
    scene = Scene.from_meshes(["pile", "spiral"], [np.stack([one] * 1000), spiral])
    np.testing.assert_allclose(scene.distance([[0.2, 0.2, 0.7]], [[0.2, 0.2, 0.5]]).value, 0.5)


@pytest.mark.parametrize(
    ("act", "complaint"),
    [
        (lambda s: s.distance([[0, 0]], [[0, 0]]), r"starts: expected .* \(q, 3\), got shape \(1, 2\)"),
        (lambda s: s.distance([[0, 0, 0]], [[0, 0, 0]] * 2), "the same"),
        (lambda s: s.distance([[0, 0, np.nan]], [[0, 0, 0]]), "not finite"),
        (lambda s: s.distance([["a", 0, 0]], [[0, 0, 0]]), "starts: .* got text"),
        (lambda s: s.distance([[0, 0, 0]], [[0, 0, 0]], upper=np.nan), "upper: expected .* got nan"),
        (lambda s: s.distance([[0, 0, 0]], [[0, 0, 0]], threads=0), "threads: expected .* got 0"),
        (lambda s: s.inside([0, 0, 0]), r"points: expected .* \(p, 3\), got shape \(3,\)"),
        (lambda s: s.clearance([[[0, 0, 0]]], [[[0, 0, 0]]], [1, 2]), "2 radii for 1 links"),
        (lambda s: s.clearance([[[0, 0, 0]]], [[[0, 0, 0]]], [-1]), "expected none below zero"),
        (lambda s: s.clearance([[[0, 0, 0]]], [[[0, 0, 0]]], [1], horizon=-1), "horizon: expected .* got -1"),
        (lambda s: s.clearance([[0, 0, 0]], [[0, 0, 0]], [1]), r"expected .* \(T, n, 3\)"),
        (lambda s: Scene.from_obstacles([], tolerance=0), "tolerance: expected .* got 0"),
        (lambda s: Scene.from_meshes(["a"], []), "1 names for 0 meshes"),
        (lambda s: Scene.from_meshes(["a"], [np.empty((0, 3, 3))]), 'mesh of "a" has no triangles'),
        (
            lambda s: Scene.from_obstacles([Sphere(center=(0, 0, 0), diameter=1, name="a")] * 2),
            '2 obstacles are called "a"',
        ),
    ],
)
def test_wrong_arguments_are_named(act, complaint):
    scene = Scene.from_obstacles([Box(center=(0, 0, 0), size=(1, 1, 1))])
    with pytest.raises(InputError, match=complaint):
        act(scene)
