"""The bundled tasks: the paper's two cases and a detour, planned, and held against independent judges."""

from __future__ import annotations

import itertools
import re
from typing import Any

import coal as coal_module
import numpy as np
import pytest
from planning_makers import CHECKS, ours, outcome, variant
from scipy.spatial.transform import Rotation

import hognose
from hognose.following import METHODS
from hognose.planning.motion import HORIZON

coal: Any = coal_module  # it comes without types
NAMES = ("obstacle-array", "pipe-tank", "detour")
names = pytest.mark.parametrize("name", NAMES)
cases = pytest.mark.parametrize("name", NAMES[:2])


@names
def test_every_check_is_made_and_passes(plans, name):
    plan = plans[name]
    assert ours(plan.checks) == CHECKS
    assert all(check.ok for check in plan.checks)
    assert plan.good
    for check in plan.checks:
        assert (check.value >= check.limit) if check.at_least else (check.value <= check.limit)
        assert check.sentence.startswith(f"{check.name}: ")


@names
def test_the_proven_clearance_exceeds_5_mm_and_not_what_the_steps_show(plans, name):
    plan = plans[name]
    seen = plan.clearance.min()
    for key in ("certified_along_path", "certified_interpolated", "certified_cables"):
        assert 0.005 < plan.check(key).value <= seen
        assert plan.check(key).value >= seen - 0.0005


@pytest.mark.parametrize(("name", "steps"), [("obstacle-array", 312), ("pipe-tank", 303)])
def test_the_motion_has_as_many_steps_as_the_paper_says(plans, name, steps):
    assert len(plans[name].time) == steps + 1


@names
def test_columns_have_one_row_a_step_and_one_cell_a_part(plans, name):
    plan = plans[name]
    rows, n, cables = len(plan.time), plan.robot.sections, plan.robot.cables
    assert (n, cables) == (12, 36)
    assert plan.feed.shape == (rows,)
    assert plan.joints.shape == (rows, n + 1, 3)
    assert plan.angles.shape == (rows, n, 2)
    assert plan.cable_lengths.shape == plan.motor_counts.shape == (rows, cables)
    assert plan.clearance.shape == (rows, n)
    assert plan.motor_counts.dtype == np.int64


@names
def test_feeds_are_a_step_apart_and_the_last_takes_the_rest(plans, name):
    plan, step = plans[name], plans[name].task.spec.motion.step
    gaps = np.diff(plan.feed)
    assert plan.feed[0] == 0.0
    np.testing.assert_allclose(gaps[:-1], step, rtol=0, atol=1e-15)
    assert 0 < gaps[-1] <= step * (1 + 1e-12)
    np.testing.assert_allclose(np.diff(plan.time), plan.task.spec.motion.period_s, rtol=1e-12)
    assert plan.time[0] == 0.0


@names
def test_at_feed_zero_the_arm_is_straight_with_its_tip_at_the_entrance(plans, name):
    plan = plans[name]
    assert np.abs(plan.angles[0]).max() <= 1e-15
    along = np.append(0.0, np.cumsum(plan.robot.link_lengths)) - plan.robot.length
    expected = plan.way_points[0] + along[:, None] * [0.0, 0.0, 1.0]
    np.testing.assert_allclose(plan.joints[0], expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(plan.body[0], expected, rtol=0, atol=1e-14)
    np.testing.assert_array_equal(plan.cable_lengths[0], plan.robot.straight_cable_lengths)
    np.testing.assert_array_equal(plan.motor_counts[0], plan.robot.motor_counts(plan.commanded_lengths[0]))
    assert (plan.motor_counts[0] < 0).all()  # pulled in until the pretension is reached


@names
def test_the_last_step_puts_the_tip_on_the_target(plans, name):
    plan = plans[name]
    for tip in (plan.joints[-1, -1], plan.body[-1, -1]):
        np.testing.assert_allclose(tip, plan.task.way_points[-1], rtol=0, atol=1e-6)


@names
def test_the_base_joint_stays_on_the_slider(plans, name):
    plan = plans[name]
    expected = plan.task.base.start + plan.feed[:, None] * [0.0, 0.0, 1.0]
    np.testing.assert_allclose(plan.joints[:, 0], expected, rtol=0, atol=1e-13)
    assert plan.feed[-1] <= plan.robot.length


def test_no_straight_line_passes_the_three_holes_of_the_obstacle_array(tasks):
    """On a line, the crossing of the middle board is the mean of the other two, weighted by distance; so it lies
    in the disk that is the weighted mean of their holes. The middle hole does not meet that disk."""
    boards = tasks["obstacle-array"].spec.obstacle
    assert [board.kind for board in boards] == ["board"] * 3
    assert all(board.normal == (0.0, 0.0, 1.0) and board.up == (0.0, 1.0, 0.0) for board in boards)
    heights = [board.center[2] for board in boards]
    assert all(board.center[:2] == (0.0, 0.0) and len(board.hole) == 1 for board in boards)
    holes = [np.array(board.hole[0].center) for board in boards]
    radii = [board.hole[0].diameter / 2 for board in boards]
    weight = (heights[1] - heights[0]) / (heights[2] - heights[0])
    assert 0 < weight < 1
    disk = (1 - weight) * holes[0] + weight * holes[2]
    reach = (1 - weight) * radii[0] + weight * radii[2]
    assert np.linalg.norm(holes[1] - disk) > reach + radii[1]


def test_the_detour_is_one(plans, tasks):
    plan = plans["detour"]
    assert len(plan.way_points) > len(tasks["detour"].way_points)
    np.testing.assert_array_equal(plan.way_points[[0, -1]], tasks["detour"].way_points)
    with pytest.raises(hognose.InfeasibleError, match="clearance at steps"):
        hognose.plan(variant(tasks["detour"], {"path.detour": False}))


@cases
def test_no_detour_is_made_where_none_is_needed(plans, tasks, name):
    np.testing.assert_array_equal(plans[name].way_points, tasks[name].way_points)


@names
def test_coal_finds_the_same_clearances(plans, name):
    """Smallest distance of each step's links, as capsules, to the triangles."""
    plan = plans[name]
    triangles = plan.scene.triangles
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(triangles), 3 * len(triangles))
    for a, b, c in triangles:
        model.addTriangle(a, b, c)
    model.endModel()
    links = [coal.Capsule(r, length) for r, length in zip(plan.robot.body_radii, plan.robot.link_lengths, strict=True)]
    request, still = coal.DistanceRequest(), coal.Transform3s.Identity()
    for step in range(0, len(plan.time), 2):
        starts, ends = plan.body[step, :-1], plan.body[step, 1:]
        found = []
        for link, start, end in zip(links, starts, ends, strict=True):
            turn = Rotation.align_vectors([end - start], [[0.0, 0.0, 1.0]])[0].as_matrix()
            pose, answer = coal.Transform3s(turn, (start + end) / 2), coal.DistanceResult()
            found.append(min(coal.distance(link, pose, model, still, request, answer), HORIZON))
        np.testing.assert_allclose(plan.clearance[step], found, rtol=0, atol=1e-6)


@pytest.mark.parametrize("method", [name for name, method in METHODS.items() if method.glides])
@cases
def test_every_following_method_plans_both_cases(plans, tasks, name, method):
    task = variant(tasks[name], {"motion.method": method})
    plan = hognose.plan(task)
    assert plan.good
    tolerance = plan.follower.tolerance
    chords = np.linalg.norm(np.diff(plan.joints, axis=1), axis=2)
    np.testing.assert_allclose(chords, np.broadcast_to(plan.robot.link_lengths, chords.shape), rtol=0, atol=tolerance)
    if plan.follower.keeps_to_path:
        np.testing.assert_array_equal(plan.feed, plans[name].feed)
    exact = hognose.follow(plan.follower.curve, plan.robot.link_lengths, plan.feed)
    assert np.linalg.norm(plan.joints - exact, axis=2).max() <= 8 * plan.robot.sections * max(tolerance, 1e-12)


KINDS = [*itertools.product(("spline", "bspline"), range(1, 6)), ("bezier", 3)]


@pytest.mark.parametrize(("kind", "order"), KINDS)
@cases
def test_every_kind_and_order_of_path_plans_or_says_why_not(tasks, name, kind, order):
    task = variant(tasks[name], {"path.kind": kind, "path.order": order})
    plan = outcome(lambda: hognose.plan(task))
    if isinstance(plan, hognose.Plan):
        assert plan.good
        assert np.linalg.norm(plan.joints[-1, -1] - task.way_points[-1]) <= 1e-6
        return
    assert len(str(plan)) > 40
    judged = getattr(plan, "plan", None)
    if judged is not None:
        assert not judged.good
        assert all(check.ok or check.sentence in str(plan) for check in judged.checks)


@pytest.mark.parametrize("order", [2, 3])
@cases
def test_smooth_splines_plan_both_cases(tasks, name, order):
    assert hognose.plan(variant(tasks[name], {"path.order": order})).good


def test_a_plan_is_the_same_every_time(plans, tasks):
    again = hognose.plan(variant(tasks["obstacle-array"]))
    for column in ("time", "feed", "joints", "angles", "cable_lengths", "motor_counts", "clearance", "way_points"):
        np.testing.assert_array_equal(getattr(again, column), getattr(plans["obstacle-array"], column))
    assert again.checks == plans["obstacle-array"].checks


def test_progress_is_told_stage_by_stage(tasks):
    stages: list[str] = []
    hognose.plan(variant(tasks["pipe-tank"]), stages.append)
    assert len(stages) == len(set(stages)) >= 4


@names
def test_the_summary_says_good_and_gives_the_figures(plans, name):
    plan = plans[name]
    text = plan.summary()
    assert f"GOOD: all {len(plan.checks)} checks passed" in text
    assert "NOT" not in text
    assert f"{len(plan.time) - 1} steps of 3.5 mm" in text
    seen, away = 1e3 * plan.clearance.min(), 1e3 * plan.body_deviation
    said = re.search(r"at the steps ([\d.]+) mm\nbody at most ([\d.]+) mm off the path, ([\d.]+) mm in root", text)
    assert said
    assert seen - 0.01 < float(said[1]) <= seen  # what is at least so much is rounded down, what is at most so much up
    assert away.max() <= float(said[2]) < away.max() + 0.01
    assert said[3] == f"{np.sqrt((away**2).mean()):.2f}"
