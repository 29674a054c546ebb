"""The checks: what was tampered with is noticed, and every check can fail."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planning_makers import CHECKS, failed, ours, outcome, retasked, variant, with_cell

import hognose
from hognose.planning import Plan, run_checks
from hognose.planning.certificate.bound import TIGHTEST, Certificate
from hognose.planning.checks.check import from_json, to_json
from hognose.planning.checks.shared import Shared
from hognose.planning.penetration import clearance_of
from hognose.robot import Robot
from hognose.robot.base import joints_on
from hognose.scene import Box, Scene

#: Column, smallest change that counts, and the checks one of which must notice it.
TAMPERED: dict[str, tuple[float, set[str]]] = {
    "angles": (2e-6, {"cables_agree_with_angles", "tip_error", "clearance_agrees_with_angles"}),
    "feed": (2e-6, {"tip_error", "starts_straight", "feed_on_path"}),
    "cable_lengths": (2e-9, {"cables_agree_with_angles"}),
    "motor_counts": (1, {"motor_counts_agree_with_cables"}),
    "clearance": (2e-9, {"clearance_agrees_with_angles"}),
    "joints": (2e-8, {"joints_agree_with_following"}),
}


@pytest.mark.parametrize("column", list(TAMPERED))
@given(data=st.data())
@settings(max_examples=8, deadline=None)
def test_no_cell_can_be_changed_unnoticed(boards: Plan, column: str, data: st.DataObject):
    smallest, noticing = TAMPERED[column]
    shape = getattr(boards, column).shape
    cell = tuple(data.draw(st.integers(0, length - 1)) for length in shape)
    if column == "motor_counts":
        change = data.draw(st.integers(1, 1000))
    else:
        change = smallest * 10 ** data.draw(st.floats(0, 3))
    change *= data.draw(st.sampled_from([-1, 1]))
    assert failed(run_checks(with_cell(boards, column, cell, change))) & noticing


@given(data=st.data())
@settings(max_examples=8, deadline=None)
def test_no_way_point_can_be_moved_unnoticed(boards: Plan, data: st.DataObject):
    point, axis = data.draw(st.integers(0, 2)), data.draw(st.integers(0, 2))
    tampered = with_cell(boards, "way_points", (point, axis), data.draw(st.sampled_from([-1e-6, 1e-6, 1e-3])))
    # A path that became too short for the last feed cannot be followed any more.
    assert failed(run_checks(tampered)) & {"joints_on_path", "feed_on_path"}


def test_the_stored_verdict_is_not_believed(boards):
    liar = dataclasses.replace(with_cell(boards, "clearance", (200, 3), 0.001), checks=boards.checks)
    assert liar.good
    assert failed(run_checks(liar)) == {"clearance_agrees_with_angles"}


def test_checking_a_good_plan_again_gives_the_same_verdict(plans):
    for plan in plans.values():
        again = run_checks(dataclasses.replace(plan, checks=()))
        assert again == plan.checks


def test_a_plan_without_checks_is_not_good(boards):
    unchecked = dataclasses.replace(boards, checks=())
    assert not unchecked.good
    assert "NOT CHECKED" in unchecked.summary()


def _rows(plan: Plan, rows: Any) -> Plan:
    columns = ("time", "feed", "joints", "angles", "cable_lengths", "motor_counts", "clearance")
    return dataclasses.replace(plan, **{name: getattr(plan, name)[rows] for name in columns})


def _joint_along(plan: Plan) -> Plan:
    """A joint that slid on along the path: its links have the wrong length, but it is on the path."""
    step, joint = 200, 6
    along = plan.joints[step, joint + 1] - plan.joints[step, joint - 1]
    moved = plan.joints.copy()
    moved[step, joint] += 1e-10 * along / np.linalg.norm(along)
    return dataclasses.replace(plan, joints=moved)


def _joint_across(plan: Plan) -> Plan:
    """A joint that left the path at a right angle to both of its links, whose lengths therefore stay."""
    step, joint = 200, 6
    here = plan.joints[step]
    across = np.cross(here[joint] - here[joint - 1], here[joint + 1] - here[joint])
    moved = plan.joints.copy()
    moved[step, joint] += 5e-10 * across / np.linalg.norm(across)
    return dataclasses.replace(plan, joints=moved)


def _followed_a_little_further(plan: Plan) -> Plan:
    """The joints of one step where they belong at another feed."""
    moved = plan.joints.copy()
    moved[200] = hognose.follow(plan.path, plan.robot.link_lengths, [plan.feed[200] + 1e-8])[0]
    return dataclasses.replace(plan, joints=moved)


def _angle_with_its_columns(plan: Plan, cell: tuple[int, ...] = (200, 5, 0), change: float = 1e-5) -> Plan:
    """A forger who changes an angle and works out everything that follows from it."""
    moved = with_cell(plan, "angles", cell, change)
    cables = plan.robot.cable_lengths(moved.angles)
    body = moved.body
    found = plan.scene.clearance(body[:, :-1], body[:, 1:], plan.robot.body_radii, plan.horizon).value
    counts = plan.robot.motor_counts(moved.commanded_lengths)
    return dataclasses.replace(moved, cable_lengths=cables, motor_counts=counts, clearance=found)


def _behind_the_start(plan: Plan) -> Plan:
    """A post beside the mount, far behind the first joint."""
    post = {"kind": "sphere", "name": "post", "center": [0.026, 0.0, -1.3], "diameter": 0.004}
    obstacles = [item.model_dump(mode="json") for item in plan.task.spec.obstacle]
    return retasked(plan, {"obstacle": [*obstacles, post]}, {"base_length": 0.3})


def _looped(plan: Plan) -> Plan:
    """Nearly a whole round, whose end comes back upon its beginning."""
    around = np.radians(np.linspace(0.0, 318.0, 14))
    sideways, ahead = 0.15 * (1 - np.cos(around)) / math.sqrt(2), 0.15 * np.sin(around)
    way_points = np.column_stack([sideways, sideways, ahead]).tolist()
    changes = {"path.way_points": way_points, "path.detour": False, "motion.period_s": 1.0, "obstacle": []}
    error = outcome(lambda: hognose.plan(variant(plan.task, changes, {"section.0.bend_limit_deg": 40.0})))
    assert isinstance(error, hognose.InfeasibleError)
    assert isinstance(error.plan, Plan)
    return error.plan


def _margin_between(plan: Plan, higher: str, lower: str) -> Plan:
    values = [plan.check(which).value for which in (higher, lower)]
    assert values[0] > values[1]
    return retasked(plan, {"margin": sum(values) / 2})


def _with_coarse_drives(plan: Plan) -> Plan:
    """Motors that turn half-way round from count to count, and little margin."""
    coarse = retasked(plan, {"margin": 0.0005}, {"section.0.transmission.counts_per_turn": 2})
    return dataclasses.replace(coarse, motor_counts=coarse.robot.motor_counts(coarse.commanded_lengths))


def limited(**changes: Any) -> Callable[[Plan], Plan]:
    """The plan judged by a robot with other limits; `__` stands for the dot."""
    return lambda plan: retasked(plan, robot={key.replace("__", "."): value for key, value in changes.items()})


BREAKERS: dict[str, Callable[[Plan], Plan]] = {
    "bend_limits": limited(section__0__bend_limit_deg=15.0),
    "link_lengths": _joint_along,
    "joints_on_path": _joint_across,
    "joints_agree_with_following": _followed_a_little_further,
    "tip_error": _angle_with_its_columns,
    "tip_on_target": lambda plan: _rows(plan, slice(0, -1)),
    "path_through_way_points": lambda plan: retasked(plan, {"path.way_points.1.0": 0.12 + 1e-7}),
    "starts_straight": lambda plan: _angle_with_its_columns(plan, (0, 11, 0), 1.8e-8),
    "set_points_a_step_apart": lambda plan: retasked(plan, {"motion.step": 0.0035 + 1e-11}),
    "set_points_a_period_apart": lambda plan: retasked(plan, {"motion.period_s": 0.15 + 1e-11}),
    "joint_speed": limited(limits__joint_speed_deg_s=3.4),
    "joint_acceleration": limited(limits__joint_acceleration_deg_s2=16.0),
    "feed_speed": limited(feed__speed=0.0233),
    "slider_travel": limited(feed__max=1.088),
    "cables_agree_with_angles": lambda plan: with_cell(plan, "cable_lengths", (9, 4), 2e-9),
    "cable_travel": limited(limits__cable_travel=[-0.012, 0.09]),
    "cable_speed": limited(limits__cable_speed=0.0013),
    "motor_counts_agree_with_cables": lambda plan: with_cell(plan, "motor_counts", (9, 4), 1),
    "motor_counts": limited(limits__motor_counts=[-29000, 2**31 - 1]),
    "rounding_to_counts": _with_coarse_drives,
    "clearance_agrees_with_angles": lambda plan: with_cell(plan, "clearance", (9, 4), -2e-9),
    "clearance_of_mount": _behind_the_start,
    "own_body": _looped,
}


@pytest.mark.parametrize("key", list(BREAKERS))
def test_this_check_alone_can_fail(boards: Plan, key: str):
    broken = BREAKERS[key](boards)
    checks = run_checks(broken)
    assert ours(checks) == CHECKS
    assert failed(checks) == {key}
    judged = dataclasses.replace(broken, checks=checks)
    assert not judged.good
    assert f"NOT GOOD: 1 of {len(checks)} checks failed" in judged.summary()
    assert judged.check(key).sentence in judged.summary()


def test_the_certificates_can_fail_where_the_steps_do_not(plans):
    plan = plans["obstacle-array"]
    values = {check.key: check.value for check in plan.checks if check.at_least}
    proven = [key for key in values if key.startswith("certified")]
    between = values["clearance_at_steps"] - TIGHTEST / 2  # kept by less than is ever proven
    assert failed(run_checks(retasked(plan, {"margin": between}))) == set(proven)
    above = values["clearance_at_steps"] + 1e-6
    assert failed(run_checks(retasked(plan, {"margin": above}))) == {*proven, "clearance_at_steps"}


@pytest.mark.parametrize(
    ("proof", "key"),
    [
        ("along_path", "certified_along_path"),
        ("interpolated", "certified_interpolated"),
        ("cables_interpolated", "certified_cables"),
    ],
)
def test_either_certificate_can_fail_alone(plans, monkeypatch, proof, key):
    plan = plans["obstacle-array"]
    monkeypatch.setattr(Shared, proof, Certificate(plan.task.margin - 1e-6, 3, 4, 5))
    judged = run_checks(plan)
    assert failed(judged) == {key}
    found = next(check for check in judged if check.key == key)
    assert (found.step, found.section, found.link) == (3, 5, 5)


def test_a_motion_of_which_nothing_is_proven_is_no_good(boards, monkeypatch):
    monkeypatch.setattr("hognose.planning.checks.shared.gliding_motion", lambda *_: None)
    checks = run_checks(boards)
    assert failed(checks) == {"certified_along_path"}
    assert "nothing is proven" in next(check.detail for check in checks if not check.ok)


def test_a_link_deep_inside_a_solid_is_not_clear(boards):
    """No surface is within the horizon. What begins inside is as deep as its deepest point, and the radius."""
    block = Scene.from_obstacles([Box(center=(0.0, 0.0, 0.0), size=(9.0, 9.0, 9.0))])
    found = clearance_of(block, boards.body[:2], boards.robot.body_radii, 0.05)
    deepest = np.minimum(np.abs(boards.body[0, :-1, 2]), np.abs(boards.body[0, 1:, 2]))
    np.testing.assert_allclose(found[0], -(4.5 - deepest) - boards.robot.body_radii, rtol=0, atol=1e-9)


def test_every_check_but_the_three_clearances_is_broken_alone_above():
    assert set(CHECKS) - set(BREAKERS) == {key for key in CHECKS if key.startswith(("clearance_at", "certified"))}


def test_the_worst_place_is_named(boards):
    moved = with_cell(boards, "joints", (123, 7, 1), 1e-4)
    by_key = {check.key: check for check in run_checks(moved)}
    assert (by_key["link_lengths"].step, by_key["link_lengths"].section) in {(123, 7), (123, 8)}
    assert by_key["joints_on_path"].step == 123
    bends = np.abs(boards.angles)
    check = boards.check("bend_limits")
    assert check.value == bends[check.step, check.section - 1].max()
    assert check.value == pytest.approx(bends.max(), rel=1e-8)
    closest = boards.check("clearance_at_steps")
    assert closest.value == boards.clearance[closest.step, closest.section - 1]
    assert closest.value == pytest.approx(boards.clearance.min(), rel=1e-8)
    assert closest.link == closest.section
    assert closest.obstacle == "board 3"
    assert "board 3" in closest.detail


def test_speeds_are_those_of_finite_differences(boards):
    speed = np.abs(np.diff(boards.angles, axis=0)).max() / 0.15
    assert boards.check("joint_speed").value == pytest.approx(speed, rel=1e-9)
    acceleration = np.abs(np.diff(boards.angles, 2, axis=0)).max() / 0.15**2
    assert boards.check("joint_acceleration").value == pytest.approx(acceleration, rel=1e-9)
    cables = np.abs(np.diff(boards.commanded_lengths, axis=0)).max() / 0.15
    assert boards.check("cable_speed").value == pytest.approx(cables, rel=1e-9)
    assert boards.check("feed_speed").value == pytest.approx(0.0035 / 0.15, rel=1e-9)
    counts = np.rint((boards.commanded_lengths - boards.cable_lengths[0]) / boards.robot.travel_per_count)
    np.testing.assert_array_equal(boards.motor_counts, counts.astype(int))
    assert boards.check("motor_counts").value == np.abs(boards.motor_counts).max()


def test_a_needle_the_steps_jump_over_is_caught_by_the_certificates_only(boards):
    """A needle touches the arm half a step before a set-point, where the arm sweeps sideways."""
    # A step as long as a link puts every joint where another was, and cuts the corners in between.
    spec = {"motion.step": 0.091, "motion.period_s": 6.0, "margin": 0.0}
    coarse = hognose.plan(retasked(boards, spec).task)
    obstacles = [item.model_dump(mode="json") for item in coarse.task.spec.obstacle]
    judged = retasked(coarse, {"obstacle": [*obstacles, _needle_between_steps(coarse)]})
    found = judged.scene.clearance(judged.body[:, :-1], judged.body[:, 1:], judged.robot.body_radii).value
    checks = run_checks(dataclasses.replace(judged, clearance=found))
    proven = {key for key in CHECKS if key.startswith("certified")}
    assert "certified_along_path" in failed(checks) <= proven
    with pytest.raises(hognose.InfeasibleError, match="certified clearance, along the path: -"):
        hognose.plan(judged.task)


def _needle_between_steps(plan: Plan) -> dict[str, Any]:
    """A ball of 0.2 mm that the links miss at all steps and sink into half-way between two of them."""
    middle = hognose.follow(plan.path, plan.robot.link_lengths, 0.5 * (plan.feed[1:] + plan.feed[:-1]))
    radius = plan.robot.body_radii[0]
    turns = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    around = np.column_stack([np.cos(turns), np.sin(turns), 0 * turns]) * (radius - 0.0005)
    along = np.linspace(0.1, 0.9, 9)[:, None]
    centers = (middle[:, :-1, None] * (1 - along) + middle[:, 1:, None] * along).reshape(-1, 1, 3)
    candidates = (centers + around).reshape(-1, 3)
    free = (plan.scene.inside(candidates) < 0) & (_nearest(candidates, middle) < radius - 0.0003)
    at_steps = np.where(free, _nearest(candidates, plan.body), 0.0)
    best = int(np.argmax(at_steps))
    assert at_steps[best] > radius + 0.0003
    return {"kind": "sphere", "name": "needle", "center": candidates[best].tolist(), "diameter": 0.0002}


def _nearest(points: np.ndarray, body: np.ndarray) -> np.ndarray:
    """Distance of each point to the closest link axis of any step."""
    best = np.full(len(points), np.inf)
    for start, end in zip(body[:, :-1].reshape(-1, 3), body[:, 1:].reshape(-1, 3), strict=True):
        axis = end - start
        t = np.clip((points - start) @ axis / (axis @ axis), 0, 1)
        best = np.minimum(best, np.linalg.norm(points - start - t[:, None] * axis, axis=1))
    return best


@pytest.mark.parametrize("method", ["fabrik", "balanced"])
def test_a_plan_is_judged_the_same_however_often(tasks, method):
    """Methods that start from their last posture must not start from that of the check before."""
    task = variant(tasks["obstacle-array"], {"motion.method": method, "motion.step": 0.0035})
    made = outcome(lambda: hognose.plan(task))
    plan = made.plan if isinstance(made, hognose.InfeasibleError) else made
    assert isinstance(plan, Plan)
    # Less than half a link of motion, so that nothing but a new start makes them forget.
    last = {
        name: getattr(plan, name)[-8:]
        for name in ("time", "feed", "joints", "angles", "cable_lengths", "motor_counts", "clearance")
    }
    part = dataclasses.replace(plan, **last)
    once, again = run_checks(part), run_checks(part)
    assert [check.ok for check in once] == [check.ok for check in again]
    np.testing.assert_array_equal([check.value for check in once], [check.value for check in again])


@pytest.mark.parametrize("kind", ["bezier", "bspline"])
def test_a_control_polygon_must_hold_the_task_s_points_in_order(tasks, kind):
    spec = {
        "obstacle": [],
        "path.kind": kind,
        "path.way_points": [[0, 0, 0], [0.03, 0.0, 0.3], [0.0, 0.04, 0.6], [0, 0, 0.9]],
    }
    plan = hognose.plan(variant(tasks["obstacle-array"], spec))
    assert plan.check("way_points_of_task").ok
    for order in ([0, 2, 1, 3], [0, 1, 3], [0, 1, 2]):
        other = dataclasses.replace(plan, way_points=plan.way_points[order])
        assert "way_points_of_task" in failed(run_checks(other)) or failed(run_checks(other)) == {"feed_on_path"}


@pytest.mark.parametrize("wild", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("column", ["time", "clearance"])
def test_what_is_no_number_passes_no_comparison(boards, column, wild):
    cells = {"time": (7,), "clearance": (7, 3)}
    assert failed(run_checks(with_cell(boards, column, cells[column], wild)))


@pytest.mark.parametrize("count", [-(2**63), 2**63 - 1])
def test_a_count_is_compared_as_a_whole_number(boards, count):
    """In 64 bits the difference to the smallest one has no absolute value."""
    counts = boards.motor_counts.copy()
    counts[200, 7] = count
    check = dataclasses.replace(boards, motor_counts=counts).verified().check("motor_counts_agree_with_cables")
    assert not check.ok
    assert check.value == float(abs(count - int(boards.motor_counts[200, 7])))
    assert (check.step, check.cable) == (200, 8)
    assert "cable 8" in check.sentence


COLUMNS = ("time", "feed", "joints", "angles", "cable_lengths", "motor_counts", "clearance")


@pytest.mark.parametrize("name", [*COLUMNS, "base_pose"])
def test_an_array_without_a_row_for_every_step_is_named(boards, name):
    whole = np.zeros((len(boards.time), 7)) if name == "base_pose" else getattr(boards, name)
    wrong = [whole[:-1], whole[..., None]] + ([whole[:, :-1]] if whole.ndim > 1 else [])
    for array in wrong:
        with pytest.raises(hognose.InputError, match="row for each step" if name == "time" else name):
            dataclasses.replace(boards, **{name: array}).verified()


def test_a_plan_without_steps_is_wrong_input(boards):
    with pytest.raises(hognose.InputError, match="a plan without steps cannot be judged"):
        dataclasses.replace(boards, **{name: getattr(boards, name)[:0] for name in COLUMNS}).verified()


def test_a_body_that_touches_itself_is_named_by_both_links(boards):
    check = _looped(boards).check("own_body")
    assert check.failed
    assert (check.link, check.step) == (2, 235)
    assert "links 2 and 12 at (13.6, 13.6, -100.4) mm" in check.sentence


def test_rounding_to_counts_is_taken_off_and_named(boards):
    """Coarse drives move every link at the steps; the certificate of cables has all of that taken off."""
    coarse = _with_coarse_drives(boards)
    checks = {check.key: check for check in run_checks(coarse)}
    rounding, proven = checks["rounding_to_counts"], checks["certified_cables"]
    assert coarse.held is not None
    lengths = coarse.robot.lengths_of_counts(coarse.motor_counts) + coarse.held.stretch
    angles = coarse.robot.angles_from_cables(lengths, coarse.angles)
    body = joints_on(coarse.task.base, coarse.robot, angles, coarse.at)
    moved = np.linalg.norm(body - coarse.body, axis=2)
    assert rounding.value == pytest.approx(moved.max(), rel=1e-9)
    links = np.maximum(moved[:, :-1], moved[:, 1:])
    assert rounding.link is not None
    assert links[rounding.step, rounding.link - 1] == pytest.approx(moved.max(), rel=1e-9)
    assert 0 < proven.value <= (coarse.clearance - links).min() < coarse.clearance.min() - 1e-4
    no_margin = {check.key: check for check in run_checks(retasked(coarse, {"margin": 0.0}))}["rounding_to_counts"]
    assert no_margin.ok
    assert not no_margin.has_figures
    assert f"{1e3 * moved.max():.2f}"[:-1] in no_margin.detail


def test_cables_of_sections_that_are_not_known_are_not_judged(boards, monkeypatch):
    for module in ("actuation", "clearance"):
        monkeypatch.setattr(f"hognose.planning.checks.{module}.judges_cables", lambda robot: False)
    found = {check.key: check for check in run_checks(boards)}
    assert {key for key, check in found.items() if not check.judged} == {"rounding_to_counts", "certified_cables"}
    assert all(check.judged or "not known" in check.detail for check in found.values())


def test_cables_that_do_not_determine_joints_are_said_where(boards, monkeypatch):
    def lost(robot, lengths, near):
        found = near.copy()
        found[7:, 3:] = np.nan
        return found

    monkeypatch.setattr(Robot, "angles_from_cables", lost)
    checks = run_checks(boards)
    assert failed(checks) == {"rounding_to_counts", "certified_cables"}
    found = {check.key: check for check in checks}
    assert (found["rounding_to_counts"].step, found["rounding_to_counts"].section) == (7, 4)
    assert "do not determine" in found["rounding_to_counts"].detail
    assert "nothing is proven" in found["certified_cables"].detail


def test_what_was_not_measured_is_said_to_be_at_least_so_much(plans):
    near = plans["pipe-tank"]
    far = hognose.plan(variant(near.task, {"obstacle": []}))
    within = "≥ 11.25 mm and thus at least 0 mm (nowhere do two links come closer, beside joints excepted)"
    assert far.check("own_body").sentence == f"clearance within the body: {within}"
    assert far.check("clearance_at_steps").comparison == "≥ 50 ≥ 5 mm"
    assert far.check("clearance_at_steps").figures[0] == "≥ 50 mm"
    bounds = {check.key for check in far.checks if check.is_bound}
    assert {"clearance_at_steps", "clearance_of_mount", "own_body"} <= bounds
    assert bounds <= {check.key for check in far.checks if check.at_least}
    assert not near.check("clearance_at_steps").is_bound
    not_proven = dataclasses.replace(far.check("clearance_at_steps"), limit=0.06, ok=False)
    assert not_proven.sentence.startswith("clearance at steps: ≥ 50 mm not proven to be at least 60 mm at step 0")


def test_verdicts_of_files_that_know_no_bounds_are_read(boards):
    said = [to_json(check) for check in boards.checks]
    assert from_json(said) == boards.checks
    assert any(check.is_bound for check in boards.checks)
    for each in said:
        del each["is_bound"]
    assert from_json(said) == tuple(dataclasses.replace(check, is_bound=False) for check in boards.checks)
