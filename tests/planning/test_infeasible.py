"""What cannot be planned is refused, with what is wrong, how much and where, and with the plan to look at."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from planning_makers import failed, variant

import hognose
from hognose.planning import Plan, Task


def refusal(task: Task) -> hognose.InfeasibleError:
    with pytest.raises(hognose.InfeasibleError) as caught:
        hognose.plan(task)
    return caught.value


def judged_plan(error: hognose.InfeasibleError) -> Plan:
    assert isinstance(error.plan, Plan)
    assert not error.plan.good
    wanting = [check for check in error.plan.checks if check.failed]
    assert wanting
    assert all(check.sentence in str(error) for check in wanting)
    assert all(check.sentence not in str(error) for check in error.plan.checks if check.ok)
    return error.plan


def obstacles(task: Task, *more: dict[str, Any]) -> list[dict[str, Any]]:
    return [*(item.model_dump(mode="json") for item in task.spec.obstacle), *more]


LIMITS: dict[str, tuple[dict[str, Any], str]] = {
    "bend_limits": (
        {"section.0.bend_limit_deg": 8.0},
        r"bend limits: 15\.14\d deg exceeds 8 deg at step \d+, section \d+ \(alpha\)",
    ),
    "joint_speed": (
        {"limits.joint_speed_deg_s": 1.0},
        r"joint speed: [\d.]+ deg/s exceeds 1 deg/s at step \d+, section",
    ),
    "slider_travel": ({"feed.max": 1.0}, r"slider travel: 1089\.\d mm exceeds 1000 mm at step 312"),
}


@pytest.mark.parametrize("key", list(LIMITS))
def test_a_robot_that_cannot_is_told_by_which_check_and_where(tasks, key):
    change, sentence = LIMITS[key]
    error = refusal(variant(tasks["obstacle-array"], robot=change))
    assert failed(judged_plan(error).checks) == {key}
    assert re.search(sentence, str(error))
    assert "obstacle array: no good motion" in str(error)


@pytest.mark.parametrize(("limits", "axis"), [([8.0, 28.0], "alpha"), ([28.0, 3.0], "beta")])
def test_bends_may_be_limited_one_axis_at_a_time(tasks, limits, axis):
    error = refusal(variant(tasks["obstacle-array"], robot={"section.0.bend_limit_deg": limits}))
    assert judged_plan(error).check("bend_limits").detail == axis
    assert f"({axis})" in str(error)


@pytest.mark.parametrize("beyond", [0.2, 1.0, 50.0])
def test_a_target_beyond_the_arm_says_by_how_much(tasks, beyond):
    task = variant(tasks["obstacle-array"], {"path.way_points.2.2": 0.999 + beyond, "obstacle": []})
    error = refusal(task)
    assert "the target is too far" in str(error)
    path = float(re.search(r"it is ([\d.]+) mm long", str(error))[1])  # pyright: ignore[reportOptionalSubscript]
    assert path == pytest.approx(1e3 * (task.path_through(task.way_points).length - task.robot.length), abs=0.06)
    assert re.search(r"the arm 1092\.0+ mm", str(error))


def test_the_arm_reaches_exactly_as_far_as_it_is_long(tasks):
    straight = {"path.way_points": [[0, 0, 0], [0, 0, 1.092]], "obstacle": []}
    plan = hognose.plan(variant(tasks["obstacle-array"], straight))
    assert plan.feed[-1] == pytest.approx(1.092, abs=1e-12)
    assert np.abs(plan.angles).max() < 1e-12
    too_far = {"path.way_points": [[0, 0, 0], [0, 0, 1.0921]], "obstacle": []}
    assert "too far" in str(refusal(variant(tasks["obstacle-array"], too_far)))


def test_a_way_point_too_close_to_an_obstacle_names_both(tasks):
    task = variant(tasks["obstacle-array"], {"path.way_points.1": [0.09, 0.04, 0.38]})
    error = refusal(task)
    assert "way-point 2 at (90.0, 40.0, 380.0) mm is 20.0 mm from" in str(error)
    assert "'board 2'" in str(error)
    assert "half the body with its margin needs 27.5 mm and does not fit" in str(error)


def test_without_detours_the_same_way_point_gives_a_plan_that_fails(tasks):
    spec = {"path.way_points.1": [0.09, 0.04, 0.38], "path.detour": False}
    plan = judged_plan(refusal(variant(tasks["obstacle-array"], spec)))
    assert "clearance_at_steps" in failed(plan.checks)
    assert plan.clearance.min() < 0.005


def test_a_wall_without_a_hole_cannot_be_gone_round(tasks):
    wall = {"kind": "box", "name": "shut door", "center": [0.0, 0.0, 0.5], "size": [6.0, 6.0, 0.01]}
    task = variant(tasks["detour"], {"obstacle": obstacles(tasks["detour"], wall)})
    error = refusal(task)
    assert "shut door" in str(error)


def test_a_margin_that_fits_no_hole_is_refused(tasks):
    error = refusal(variant(tasks["obstacle-array"], {"margin": 0.03}))
    assert re.search(
        r"way-point [12] at .* is (49\.9|50\.0) mm from 'board [12]'; half the body with its margin needs 52.5 mm",
        str(error),
    )
    plan = judged_plan(refusal(variant(tasks["obstacle-array"], {"margin": 0.03, "path.detour": False})))
    assert {"clearance_at_steps", "certified_along_path"} <= failed(plan.checks)
    assert plan.check("clearance_at_steps").limit == pytest.approx(0.03)


def test_a_touching_plan_says_how_deep_and_what(tasks, boards):
    """A ball where the last joint ends up, with detours off: the arm goes through it."""
    ball = {"kind": "sphere", "name": "ball", "center": boards.joints[-1, -2].tolist(), "diameter": 0.03}
    spec = {"obstacle": obstacles(tasks["obstacle-array"], ball), "path.detour": False}
    error = refusal(variant(tasks["obstacle-array"], spec))
    plan = judged_plan(error)
    # The last joint is in the middle: as deep as the ball's and the body's radius.
    assert plan.clearance.min() == pytest.approx(-plan.robot.body_radii[0] - 0.015, abs=2e-4)
    assert "inside ball, deepest at" in str(error)


BURIED = {
    "the entrance": ("path.way_points.0", [0.2, 0.0, 0.0]),
    "way-point 2": ("path.way_points.1", [0.25, 0.04, 0.38]),
    "the target": ("path.way_points.2", [-0.11, 0.06, 0.8]),
}


@pytest.mark.parametrize("detour", [True, False])
@pytest.mark.parametrize("which", list(BURIED))
def test_a_way_point_inside_an_obstacle_is_wrong_input(tasks, which, detour):
    key, place = BURIED[which]
    with pytest.raises(hognose.InputError, match=f"{which} at .* lies inside the obstacle 'board") as caught:
        hognose.plan(variant(tasks["obstacle-array"], {key: place, "path.detour": detour}))
    assert ", ".join(f"{1e3 * c:g}" for c in place) in str(caught.value)


def test_an_arm_that_starts_inside_a_solid_is_no_good(tasks):
    """The solid is far thicker than the horizon, so no surface is near; a shell would look clear."""
    block = {"kind": "box", "name": "block", "center": [0.0, 0.0, -0.6], "size": [2.0, 2.0, 0.9]}
    for robot in (None, {"base_length": 0.0}):
        task = variant(tasks["obstacle-array"], {"obstacle": obstacles(tasks["obstacle-array"], block)}, robot)
        with pytest.raises(hognose.HognoseError, match="block"):
            hognose.plan(task)


@pytest.mark.parametrize("detour", [True, False])
def test_an_arm_that_starts_inside_a_solid_but_for_its_first_link_is_no_good(tasks, detour):
    shell = {"kind": "box", "name": "block", "center": [0.0, 0.0, -0.55], "size": [4.0, 4.0, 0.9]}
    spec = {"obstacle": [shell], "path.detour": detour}
    plan = judged_plan(refusal(variant(tasks["obstacle-array"], spec)))
    assert plan.clearance.min() < 0


def test_entrance_and_target_at_the_same_place_is_wrong_input(tasks):
    with pytest.raises(ValueError, match="points 1 and 2 are the same"):
        variant(tasks["obstacle-array"], {"path.way_points": [[0, 0, 0], [0, 0, 0]]})


def test_a_step_that_makes_too_many_set_points_is_wrong_input(tasks):
    with pytest.raises(hognose.InputError, match=r"motion\.step: 1e-06 mm makes 1\.09e\+09 steps"):
        hognose.plan(variant(tasks["obstacle-array"], {"motion.step": 1e-9}))


def test_two_obstacles_of_one_name_are_wrong_input(tasks):
    with pytest.raises(hognose.InputError, match="board 1"):
        hognose.plan(variant(tasks["obstacle-array"], {"obstacle.1.name": "board 1"}))


def test_a_target_behind_the_entrance_is_refused(tasks):
    with pytest.raises(hognose.HognoseError):
        hognose.plan(variant(tasks["obstacle-array"], {"path.way_points": [[0, 0, 0], [0, 0, -0.5]], "obstacle": []}))


def test_a_space_without_obstacles_is_planned(tasks):
    plan = hognose.plan(variant(tasks["obstacle-array"], {"obstacle": []}))
    assert plan.good
    assert (plan.clearance == plan.horizon).all()
    assert "≥ 50.00 mm" in plan.summary()


@pytest.mark.parametrize("z", [0.03, 0.35])
def test_a_body_wider_than_the_hole_is_said_to_be_that(tasks, z):
    """With detours on, which lead nowhere, near the entrance beside the slider's run and farther in."""
    hole = [{"center": [0.0, 0.0], "diameter": 0.05}]
    wall = {"kind": "board", "name": "wall", "center": [0, 0, z], "size": [1, 1], "thickness": 0.01, "hole": hole}
    error = refusal(
        variant(tasks["obstacle-array"], {"obstacle": [wall], "path.way_points": [[0, 0, 0], [0.05, 0.02, 0.7]]})
    )
    found = re.match(
        r".*the body does not fit: at \((-?[\d.]+), (-?[\d.]+), ([\d.]+)\) mm, beside 'wall', the way is ([\d.]+) "
        r"mm wide; the body, margin included, needs 55 mm\. No detour leads round it",
        str(error),
        re.DOTALL,
    )
    assert found is not None, error
    assert np.hypot(float(found[1]), float(found[2])) < 0.5
    assert float(found[3]) == pytest.approx(1e3 * z, abs=9)
    assert float(found[4]) == pytest.approx(50, abs=0.5)


def test_a_wall_without_a_hole_is_no_gap(tasks):
    wall = {"kind": "board", "name": "wall", "center": [0, 0, 0.35], "size": [1, 1], "thickness": 0.01}
    changed = {"obstacle": [wall], "path.way_points": [[0, 0, 0], [0.05, 0.02, 0.7]]}
    error = refusal(variant(tasks["obstacle-array"], changed))
    assert "does not fit" not in str(error)
    assert "'wall'" in str(error)


BASES = [
    {},
    {"kind": "slider", "direction": [0.3, -0.4, 0.8]},
    {"kind": "cart", "position": [0.1, 0.2, -1.4]},
    {"kind": "arm", "direction": [1.0, 0.0, 0.0]},
    {"kind": "drum", "radius": 0.24, "nozzle": 0.1},
]


@pytest.mark.parametrize("base", BASES, ids=lambda base: base.get("kind", "none"))
def test_a_polyline_is_planned_where_it_is_straight_and_refused_where_it_has_a_corner(tasks, base):
    def polyline(*along_and_aside: tuple[float, float]) -> Task:
        empty = variant(tasks["pipe-tank"], {"base": base, "obstacle": [], "path.order": 1})
        along, aside = empty.base.direction, np.cross(empty.base.direction, [0.6, 0.8, 0.0])
        begin = empty.base.start + empty.base.direction * empty.robot.length if "position" in base else np.zeros(3)
        points = [begin + (z * along if z else 0.0) + x * aside for z, x in along_and_aside]
        return variant(empty, {"path.way_points": np.array(points).tolist()})

    plan = hognose.plan(polyline((0.0, 0.0), (0.35, 0.0)))
    assert plan.good
    assert plan.check("certified_along_path").value > plan.horizon - 2.5e-4
    assert hognose.plan(polyline((0.0, 0.0), (0.1, 0.0), (0.21, 0.0), (0.35, 0.0))).good
    plan = judged_plan(refusal(polyline((0.0, 0.0), (0.2, 0.0), (0.3, 0.02))))
    assert "joints may jump" in plan.check("certified_along_path").detail


@pytest.mark.parametrize(("error_deg", "advised"), [(0.0, False), (2.0, True)])
def test_what_to_try_is_said_where_only_tolerances_are_in_the_way(tasks, error_deg, advised):
    sphere = {"kind": "sphere", "center": [0.1, 0.06, 0.3], "diameter": 0.06}
    way_points = [[0.0, 0.0, 0.0], [0.03, 0.03, 0.43], [-0.06, -0.05, 1.0]]
    changes = {"obstacle": [sphere], "path.way_points": way_points, "tolerance.calibration_deg": error_deg}
    task = variant(tasks["obstacle-array"], changes)
    if not advised:
        assert hognose.plan(task).good
        return
    error = refusal(task)
    plan = judged_plan(error)
    assert plan.clearance.min() >= task.margin
    last = str(error).splitlines()[-1]
    assert re.match(r"  without tolerances [\d.]+ mm would be left at the steps: tolerances take more", last)
    assert "Calibrate or register more closely" in last
