"""The parts of the search, each against an independent computation."""

import dataclasses

import numpy as np
import pytest
from planning_makers import moved
from route_makers import searched

import hognose
from hognose.path.constructors import sensitivity
from hognose.robot import Robot, RobotSpec
from hognose.robot.base import Slider, axes_of
from hognose.route.fit.motion import frames, insertion, last_feed
from hognose.route.fit.objective import Objective, judge
from hognose.route.search.cheapest_ways import along, cost_to_go
from hognose.route.search.clearance_grid import room_between
from hognose.route.search.distance_field import distances
from hognose.route.search.elastic_band import relaxed
from hognose.route.search.passages import Wish, passage, price

WINDING = np.array([[0, 0, 0], [0.03, 0.01, 0.2], [0.12, 0.04, 0.4], [0.05, 0.05, 0.6], [-0.08, 0.06, 0.95]])


@pytest.mark.parametrize("order", [2, 3, 5])
def test_a_spline_is_its_sensitivity_times_its_way_points(order):
    """Across the start direction the pieces are linear in the way-points, and zero at the entrance."""
    path = hognose.Path.through(WINDING, order, (0, 0, 1))
    breaks, rates = sensitivity(WINDING, order)
    assert np.array_equal(breaks, path.breaks)
    across = np.einsum("skm,mc->skc", rates, WINDING[1:, :2])
    assert np.abs(across - path.coefficients[..., :2]).max() < 1e-9 * np.abs(path.coefficients).max()


def test_the_last_feed_puts_the_tip_on_the_target():
    robot = hognose.load_robot("sjtu-25dof")
    path = hognose.Path.through(WINDING, 3, (0, 0, 1)).with_run(robot.length)
    base = Slider.before(np.zeros(3), robot)
    motion = insertion(path, robot, base)
    assert motion is not None
    assert motion.feeds[-1] == pytest.approx(last_feed(path, robot), rel=1e-11)
    assert np.abs(motion.joints[-1, -1] - WINDING[-1]).max() < 1e-9
    assert np.abs(motion.joints - hognose.follow(path, robot.link_lengths, motion.feeds)).max() < 1e-12
    assert (
        np.abs(frames(motion.angles, axes_of(base, motion.at))[:, -1] - robot.tip_pose(motion.angles)[:, :3, :3]).max()
        < 1e-12
    )


def test_the_last_link_takes_the_places_of_all():
    """The smallest clearance of the leading link over an insertion is that of all links beyond the entrance."""
    task = searched("pipe-tank")
    path = task.path_through(WINDING)
    feeds = np.arange(0, last_feed(path, task.robot), 0.0005)
    joints = hognose.follow(path, task.robot.link_lengths, feeds)
    every = task.scene.clearance(joints[:, :-1], joints[:, 1:], task.robot.body_radii, np.inf).value
    beyond = joints[:, :-1, 2] >= 0
    assert np.abs(every[:, -1].min() - every[beyond].min()) < 1e-4


def test_the_field_is_the_distance_to_the_obstacles():
    task = searched("pipe-tank")
    far = 0.12
    grid = room_between(task.scene, task.way_points[0], task.way_points[1:], task.robot.length, 0.01, far)
    within = grid.distance >= 0
    places = grid.places()[within][::37]
    off = grid.distance[within][::37] - task.scene.distance(places, places, upper=far).value
    assert off.min() > -1e-12
    assert off.max() < 1e-3
    assert np.array_equal(grid.places()[tuple(grid.nodes(np.zeros((1, 3)))[0])], np.zeros(3))


def test_a_passage_bends_no_more_than_asked_and_keeps_its_distance():
    task = searched("obstacle-array")
    stops = task.way_points
    grid = room_between(task.scene, stops[0], stops[1:], task.robot.length, 0.01, 0.12)
    wish = Wish(need=0.0275, wide=0.06, sharpest=5.2, longest=1.11, move=0.045)
    cost = price(grid, wish)
    left = cost_to_go(grid, cost, stops[1])
    curve = passage(grid, cost, left, stops[0], np.array([0.0, 0.0, 1.0]), stops[1], wish, 1.3)
    assert curve is not None
    assert np.array_equal(curve[[0, -1]], stops)
    assert task.scene.distance(curve, curve).value.min() > wish.need - grid.cell
    chords = np.diff(curve, axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    assert lengths.sum() < wish.longest
    turns = np.arccos(np.clip((chords[1:] * chords[:-1]).sum(axis=1) / lengths[1:] / lengths[:-1], -1, 1))
    assert turns[:-1].max() <= wish.sharpest * wish.move * 1.001
    assert left[tuple(grid.nodes(stops[:1])[0])] >= np.linalg.norm(stops[1]) - 2 * grid.cell


def test_long_thin_triangles_and_walls_far_larger_than_the_grid_reach_all_their_nodes():
    """Against the distance to each triangle, by brute force."""
    random = np.random.default_rng(0)
    thin = np.array([[-3.0, 0.1, 0.2], [4.0, 0.12, 0.1], [4.0, 0.125, 0.1]])
    wall = np.array([[-900.0, -800.0, 0.31], [1000.0, -500.0, 0.3], [0.0, 1200.0, 0.29]])
    scene = hognose.scene.Scene.from_meshes(["thin", "wall"], [thin[None], wall[None]])
    shape, cell, origin, far = (24, 20, 22), 0.02, np.array([-0.2, -0.15, -0.1]), 0.09
    out = np.empty(shape)
    distances(scene.triangles, scene.growth[scene.owner], origin, cell, far, out)
    nodes = random.integers(0, shape, (4000, 3))
    places = origin + cell * nodes
    exact = scene.distance(places, places, upper=far).value
    off = out[tuple(nodes.T)] - exact
    assert (exact < far).mean() > 0.2
    assert off.min() > -1e-9
    assert off.max() < 0.02 * cell


def test_the_cost_to_go_is_the_same_as_far_as_it_is_known():
    task = searched("pipe-tank")
    start, target = np.zeros(3), np.array([0.05, 0.0, 0.3])
    grid = room_between(task.scene, start, target[None], task.robot.length, 0.02, 0.1)
    cost = price(grid, Wish(0.0275, 0.06, 5.2, 1.11, 0.045))
    every, some = cost_to_go(grid, cost, target), cost_to_go(grid, cost, target, start)
    known = np.isfinite(some)
    at = tuple(grid.nodes(start[None])[0])
    assert some[at] == every[at]
    assert known.sum() < np.isfinite(every).sum()
    assert np.array_equal(known[every <= 1.5 * every[at]], np.ones((every <= 1.5 * every[at]).sum(), bool))
    assert np.array_equal(some[every <= 1.5 * every[at]], every[every <= 1.5 * every[at]])


def test_between_the_nodes_the_field_is_linear():
    task = searched("pipe-tank")
    grid = room_between(task.scene, task.way_points[0], task.way_points[1:], task.robot.length, 0.03, 0.1)
    grid.distance[...] = grid.places() @ [1.0, -2.0, 0.5]
    points = np.random.default_rng(0).uniform(grid.places()[0, 0, 0], grid.places()[-1, -1, -1], (50, 3))
    assert grid.at(points) == pytest.approx(points @ [1.0, -2.0, 0.5])


def test_a_relaxed_way_is_smooth_and_passes():
    task = searched("pipe-tank")
    start, target = task.way_points
    grid = room_between(task.scene, start, target[None], task.robot.length, 0.01, 0.12)
    wish = Wish(0.0275, 0.06, 5.2, 1.11, 0.045)
    left = cost_to_go(grid, price(grid, wish), target)
    way = along(grid, left, start, target)
    band = relaxed(grid, way, np.array([0.0, 0.0, 1.0]), wish)
    assert band is not None
    assert np.array_equal(band[[0, -1]], [start, target])
    assert task.scene.distance(band, band).value.min() > 0.8 * wish.need
    chords = np.diff(band, axis=0)
    assert np.linalg.norm(chords, axis=1).sum() < np.linalg.norm(np.diff(way, axis=0), axis=1).sum()
    chords /= np.linalg.norm(chords, axis=1)[:, None]
    assert np.degrees(np.arccos(np.clip((chords[1:] * chords[:-1]).sum(axis=1), -1, 1))).max() < 15  # over the grid: 45
    sharp = relaxed(grid, way, np.array([0.0, 0.0, 1.0]), Wish(0.0275, 0.06, 0.2, 1.11, 0.045))
    assert sharp is None


@pytest.mark.parametrize("turned", [False, True])
def test_residuals_change_as_their_derivatives_say(turned):
    """Along the way a step takes, to first order and less what sliding along the path does; in any frame."""
    task = searched("pipe-tank")
    way_points = np.array([[0, 0, 0], [0.02, 0.05, 0.2], [0.05, 0.11, 0.4], [0.0, 0.05, 0.65], [-0.06, -0.05, 1.0085]])
    if turned:
        task, put = moved(task, 3)
        way_points = put(way_points)
    path = task.path_through(way_points)
    guide = path.point(np.linspace(task.robot.length, path.length, 200))
    objective = Objective(
        task.robot, task.base, task.scene, task.path_through, 3, 0.05, 0.005, guide, np.array([True, True, True, False])
    )
    judged = judge(objective, way_points)
    assert judged is not None
    residuals, rows = judged.residuals(0.05, 2.0)
    assert len(residuals) > 50
    assert residuals @ residuals == pytest.approx(judged.merit(0.05, 2.0))
    slope = 2 * rows.T @ residuals
    step = 1e-5 * (slope / np.linalg.norm(slope)).reshape(3, 3)
    both = [judge(objective, way_points + np.pad(sign * step, ((1, 1), (0, 0)))) for sign in (1, -1)]
    merits = [one.merit(0.05, 2.0) for one in both if one is not None]
    assert merits[0] - merits[1] == pytest.approx(2 * slope @ step.ravel(), rel=0.3)


@pytest.mark.parametrize("share", [1.02, 0.98])
def test_a_way_is_feasible_only_if_the_joints_bend_so_far(share):
    task = searched("pipe-tank")
    way_points = np.array([[0, 0, 0], [0.02, 0.05, 0.2], [0.05, 0.11, 0.4], [0.0, 0.05, 0.65], [-0.06, -0.05, 1.0085]])
    guide, free = way_points, np.array([True, True, True, False])
    objective = Objective(task.robot, task.base, task.scene, task.path_through, 3, 0.01, 0.005, guide, free)
    judged = judge(objective, way_points)
    assert judged is not None
    most = np.degrees(np.abs(judged.motion.angles).max())
    data = task.robot.spec.model_dump(by_alias=True)
    data["section"] = [section | {"bend_limit_deg": share * most} for section in data["section"]]
    other = judge(dataclasses.replace(objective, robot=Robot.from_spec(RobotSpec.model_validate(data))), way_points)
    assert other is not None
    assert other.overruns["bend"] == pytest.approx(1 / share)
    assert other.feasible == (share > 1)
    assert (other.score < judged.score) == (share < 1)
