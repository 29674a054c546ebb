import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from path_oracles import SLIDER

from hognose.errors import InfeasibleError
from hognose.path import Path
from hognose.path.detour import _inside, lead_round
from hognose.scene import Board, Box, Cylinder, Hole, Scene, Sphere

RADIUS, STEP = 0.0275, 0.0035
STRAIGHT = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.6], [0.0, 0.0, 1.2]])
seeds = st.integers(0, 2**32 - 1)
some = settings(deadline=None, max_examples=6)


def draw(points):
    return Path.through(points, 3)


def draw_with_run(points):
    return Path.through(points, 3, SLIDER).with_run(0.5)


def led(drawn, way_points, scene, radius, step, start=0.0):
    """A detour for a body that is as thick everywhere."""
    return lead_round(drawn, way_points, scene, np.array([radius]), np.array([1.0]), step, start)


def signed_distance(scene, points):
    """Distance of points to the obstacles; below zero inside them."""
    return scene.distance(points, points).value * np.where(scene.inside(points) >= 0, -1, 1)


def assert_came_clear(scene, given_points, found, start=0.0, radius=RADIUS):
    way_points, path = found
    dense = path.point(np.linspace(start, path.length, 20_000))
    assert signed_distance(scene, dense).min() >= radius - 1e-9
    # The given way-points are kept as they are and in their order; the path passes through all there are.
    rest = iter(map(tuple, way_points))
    assert all(point in rest for point in map(tuple, given_points))
    np.testing.assert_allclose(path.distance_to(way_points), 0, rtol=0, atol=1e-9)


def assert_says_where(error, scene):
    text = str(error)
    assert any(repr(name) in text for name in scene.names)
    assert " mm" in text
    assert "way-point" in text


def random_scene(rng):
    """One to three spheres, cylinders and boards in the way of the straight line, clear of its way-points."""
    obstacles = []
    for height in rng.choice([0.3, 0.9], int(rng.integers(1, 3)), replace=False):
        x, y = rng.uniform(-0.05, 0.05, 2).tolist()
        z = float(height + rng.uniform(-0.05, 0.05))
        kind = rng.integers(3)
        if kind == 0:
            obstacles.append(Sphere(center=(x, y, z), diameter=rng.uniform(0.03, 0.15)))
        elif kind == 1:
            turn = rng.uniform(0, np.pi)
            dx, dy = 0.3 * np.cos(turn), 0.3 * np.sin(turn)
            obstacles.append(
                Cylinder(start=(x - dx, y - dy, z), end=(x + dx, y + dy, z), diameter=rng.uniform(0.03, 0.1))
            )
        else:
            hole = Hole(center=rng.uniform(-0.06, 0.06, 2), diameter=rng.uniform(0.14, 0.2))
            obstacles.append(Board(center=(0, 0, height), size=(1.0, 1.0), thickness=0.01, hole=(hole,)))
    return Scene.from_obstacles(obstacles)


@some
@given(seeds, st.booleans())
def test_the_path_comes_clear_of_what_stands_in_the_way_or_says_what_does(seed, run):
    scene = random_scene(np.random.default_rng(seed))
    drawn, start = (draw_with_run, 0.5) if run else (draw, 0.0)
    try:
        found = led(drawn, STRAIGHT, scene, RADIUS, STEP, start)
    except InfeasibleError as error:
        assert_says_where(error, scene)
    else:
        assert_came_clear(scene, STRAIGHT, found, start)


@some
@given(seeds)
def test_a_single_ball_is_always_led_round(seed):
    rng = np.random.default_rng(seed)
    ball = Sphere(center=(*rng.uniform(-0.06, 0.06, 2), rng.uniform(0.28, 0.32)), diameter=rng.uniform(0.02, 0.2))
    scene = Scene.from_obstacles([ball])
    assert_came_clear(scene, STRAIGHT, led(draw, STRAIGHT, scene, RADIUS, STEP))


@pytest.mark.parametrize("offset", [0.0, 1e-9, 0.01, 0.05])
@pytest.mark.parametrize("diameter", [0.02, 0.06, 0.1])
def test_a_single_bar_across_is_always_led_round(offset, diameter):
    bar = Cylinder(start=(-0.4, offset, 0.3), end=(0.4, offset, 0.3), diameter=diameter)
    scene = Scene.from_obstacles([bar])
    assert_came_clear(scene, STRAIGHT, led(draw, STRAIGHT, scene, RADIUS, STEP))


@pytest.mark.parametrize("shift", [0.0, 0.02, 0.04, 0.06])
def test_a_hole_beside_the_path_is_found(shift):
    hole = Hole(center=(0.0, shift), diameter=0.16)
    scene = Scene.from_obstacles([Board(center=(0, 0, 0.3), size=(0.8, 0.8), thickness=0.01, hole=(hole,))])
    found = led(draw, STRAIGHT, scene, RADIUS, STEP)
    assert_came_clear(scene, STRAIGHT, found)
    crossing = found[1].point(np.linspace(0, found[1].length, 5000))
    through = crossing[np.argmin(np.abs(crossing[:, 2] - 0.3))]
    assert np.hypot(through[0], through[1] - shift) < 0.08 - RADIUS + 1e-3


@pytest.mark.parametrize("obstacles", [[], [Sphere(center=(0.2, 0, 0.3), diameter=0.1)]])
def test_way_points_of_a_clear_path_come_back_bit_for_bit(obstacles):
    given_points = STRAIGHT + 0.1
    way_points, path = led(draw, given_points, Scene.from_obstacles(obstacles), RADIUS, STEP)
    np.testing.assert_array_equal(way_points, given_points)
    plain = draw(given_points)
    np.testing.assert_array_equal(path.coefficients, plain.coefficients)
    np.testing.assert_array_equal(path.breaks, plain.breaks)


def test_what_stands_beside_the_sliders_run_is_not_looked_at():
    scene = Scene.from_obstacles([Sphere(center=(0, 0, -0.3), diameter=0.1)])
    way_points, _ = led(draw_with_run, STRAIGHT, scene, RADIUS, STEP, start=0.5)
    np.testing.assert_array_equal(way_points, STRAIGHT)


@pytest.mark.parametrize("depth", [1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2])
def test_a_path_that_only_grazes_is_led_round_too(depth):
    """However little is hit, be it with a single point of the path."""
    scene = Scene.from_obstacles([Sphere(center=(0.06, 0, 0.3), diameter=0.04)])
    gap = float(signed_distance(scene, np.array([[0, 0, 0.3]]))[0])
    line = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.6]])
    radius = gap - 0.001 + depth  # the path is tested at points 2 mm apart, with a body 1 mm thicker
    found = led(draw, line, scene, radius, STEP)
    assert_came_clear(scene, line, found, radius=radius)
    assert len(found[0]) > 2


def test_a_solid_wall_is_named_with_the_place_and_the_depth():
    wall = Box(name="bulkhead", center=(0, 0, 0.3), size=(20, 20, 0.05))
    scene = Scene.from_obstacles([wall])
    with pytest.raises(InfeasibleError, match="does not come clear of 'bulkhead' after 40 detours") as caught:
        led(draw, STRAIGHT, scene, RADIUS, STEP)
    assert_says_where(caught.value, scene)
    assert "the body, margin included, is" in str(caught.value)


@pytest.mark.parametrize(("height", "gap"), [(0.7, "20.0"), (0.63, "-50.0")])
def test_a_way_point_without_room_is_named_with_what_is_too_close(height, gap):
    scene = Scene.from_obstacles([Box(name="shelf", center=(0, 0, height), size=(1, 1, 0.16))])
    with pytest.raises(InfeasibleError) as caught:
        led(draw, STRAIGHT, scene, RADIUS, STEP)
    for words in ("way-point 2 at (0.0, 0.0, 600.0) mm", f"is {gap} mm from 'shelf'", "needs 27.5 mm"):
        assert words in str(caught.value)


@some
@given(seeds)
def test_crowded_scenes_end_with_an_answer_or_a_sentence(seed):
    rng = np.random.default_rng(seed)
    balls = [
        Sphere(center=(*rng.uniform(-0.15, 0.15, 2), height), diameter=rng.uniform(0.02, 0.1))
        for height in rng.uniform(0.15, 1.05, 12)
    ]
    scene = Scene.from_obstacles(balls)
    try:
        found = led(draw, STRAIGHT, scene, 0.015, STEP)
    except InfeasibleError as error:
        assert_says_where(error, scene)
    else:
        assert_came_clear(scene, STRAIGHT, found, radius=0.015)


def test_a_hole_only_needs_room_for_the_links_that_come_there():
    """A tapered arm: the thin last link alone reaches the narrow hole."""
    hole = Hole(center=(0.0, 0.0), diameter=0.07)
    scene = Scene.from_obstacles([Board(center=(0, 0, 1.0), size=(4.0, 4.0), thickness=0.01, hole=(hole,))])
    lengths, thin_tip, thick_tip = np.array([0.8, 0.4]), np.array([0.05, 0.03]), np.array([0.05, 0.05])
    way_points, _ = lead_round(draw, STRAIGHT, scene, thin_tip, lengths, STEP)
    np.testing.assert_array_equal(way_points, STRAIGHT)
    with pytest.raises(InfeasibleError):
        lead_round(draw, STRAIGHT, scene, thick_tip, lengths, STEP)
    with pytest.raises(InfeasibleError):  # here the thick link comes as far as the hole
        lead_round(draw, STRAIGHT, scene, thin_tip, np.array([1.1, 0.1]), STEP)


@given(seeds)
@some
def test_which_samples_are_in_solids_needs_few_questions(seed):
    random = np.random.default_rng(seed)
    obstacles = [
        Sphere(center=tuple(random.uniform(-0.3, 0.3, 3)), diameter=random.uniform(0.002, 0.3)) for _ in range(4)
    ]
    scene = Scene.from_obstacles(obstacles)
    path = Path.through(random.uniform(-0.3, 0.3, (5, 3)), 3)
    arcs = np.linspace(0, path.length, int(path.length / 0.002) + 2)
    points = path.point(arcs)
    found = scene.distance(points, points).value
    np.testing.assert_array_equal(_inside(scene, points, found, arcs[1]), scene.inside(points) >= 0)
