"""What plans say of tensions and buckling, and when they fail by them."""

import dataclasses
import re

import numpy as np
import pytest
from planning_makers import altered, failed, outcome, retasked, variant
from pydantic import ValidationError

import hognose
from hognose.mechanics import Mechanics
from hognose.planning import Plan, TaskSpec
from hognose.planning.checks import run_checks
from hognose.planning.columns import cells_of
from hognose.robot import Robot

MECHANICS = ("peak_tension", "slack", "buckling")


@pytest.fixture(scope="module")
def plan():
    return hognose.plan(hognose.load_task("obstacle-array"))


def held(plan):
    """How cables hold the arm; mechanics are known."""
    assert plan.held is not None
    return plan.held


def number(words, text):
    """The first number behind some words."""
    found = re.search(rf"{words}([0-9.]+)", text)
    assert found is not None, text
    return float(found[1])


def test_columns_are_those_of_the_mechanics(plan):
    cells, arm = cells_of(plan), Mechanics.of(plan.robot)
    expected = arm.hold(plan.angles, (0.0, -9.80665, 0.0))
    for k in range(36):
        np.testing.assert_array_equal(cells[f"tension_{k + 1:02d}_N"], expected.tensions[:, k])
        commanded = plan.cable_lengths[:, k] - expected.tensions[:, k] / expected.spring_constants[:, k]
        np.testing.assert_allclose(cells[f"commanded_cable_{k + 1:02d}_m"], commanded, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(cells["buckling_load_factor"], expected.load_factor)


def test_motor_counts_are_those_of_the_commanded_lengths(plan):
    np.testing.assert_array_equal(plan.motor_counts, plan.robot.motor_counts(plan.commanded_lengths))
    assert (plan.commanded_lengths < plan.cable_lengths).all()
    stretch = plan.cable_lengths - plan.commanded_lengths
    np.testing.assert_allclose(stretch * plan.held.spring_constants, plan.held.tensions, rtol=1e-9)


def test_verdicts_are_the_worst_of_all_steps(plan):
    slack, tension, buckling = (plan.check(key) for key in ("slack", "peak_tension", "buckling"))
    assert slack.value == plan.held.tensions.min() == plan.held.tensions[slack.step, slack.cable - 1]
    assert tension.value == plan.held.tensions.max() == plan.held.tensions[tension.step, tension.cable - 1]
    assert buckling.value == pytest.approx(plan.held.load_factor.min(), rel=1e-9)
    assert buckling.value == pytest.approx(4.04, abs=0.01)
    assert buckling.section is not None
    assert buckling.cable is not None


def test_a_plan_file_keeps_and_proves_its_tensions(plan, tmp_path):
    plan.save(tmp_path / "plan.parquet")
    again = Plan.load(tmp_path / "plan.parquet")
    assert again.good
    np.testing.assert_array_equal(again.motor_counts, plan.motor_counts)
    np.testing.assert_array_equal(held(again).tensions, plan.held.tensions)


def without_cables(plan):
    robot = Robot.from_spec(plan.robot.spec.model_copy(update={"cables": None, "assumed": ()}))
    return hognose.plan(hognose.Task(plan.task.spec, robot))


def test_a_robot_without_springs_plans_as_before_and_says_that_mechanics_were_not_judged(plan):
    bare = without_cables(plan)
    assert bare.held is None
    assert bare.good
    not_judged = [check for check in bare.checks if not check.judged]
    assert [check.key for check in not_judged] == ["peak_tension"]
    assert "mechanics are not known: the robot file has no table [cables]" in not_judged[0].detail
    np.testing.assert_array_equal(bare.motor_counts, plan.robot.motor_counts(plan.cable_lengths))
    np.testing.assert_array_equal(bare.commanded_lengths, plan.cable_lengths)
    assert not [name for name in cells_of(bare) if name.startswith(("tension", "commanded", "buckling"))]
    for name in ("feed", "joints", "angles", "cable_lengths", "clearance"):
        np.testing.assert_array_equal(getattr(bare, name), getattr(plan, name))


def test_gravity_is_a_vector_in_the_frame_of_the_task(plan):
    weightless = retasked(plan, {"gravity_m_s2": [0.0, 0.0, 0.0]})
    np.testing.assert_allclose(held(weightless).tensions[0], 40.0, rtol=1e-12)
    aside = retasked(plan, {"gravity_m_s2": [9.80665, 0.0, 0.0]})
    expected = Mechanics.of(plan.robot).hold(plan.angles, (9.80665, 0.0, 0.0))
    np.testing.assert_array_equal(held(aside).tensions, expected.tensions)


def test_gravity_is_turned_into_the_axes_of_an_arm_that_enters_elsewhere():
    """A vessel entered along x, with gravity along -z: the arm's own z axis is the direction of its base."""
    task = hognose.load_task("slanted-vessel")
    at = np.zeros((1, 1))
    found = task.gravity(at)
    np.testing.assert_allclose(task.base.turned(found, at)[0], task.spec.gravity_m_s2, atol=1e-12)
    assert np.linalg.norm(found) == pytest.approx(9.80665)
    assert found[0, 2] == pytest.approx(np.dot(task.base.direction, task.spec.gravity_m_s2), abs=1e-12)


@pytest.mark.parametrize("gravity", [[0.0, -9806.65, 0.0], [0.0, 1e-3, 0.0], [0.0, -9.8], ["down", 0.0, 0.0]])
def test_gravity_in_another_unit_is_refused(plan, gravity):
    with pytest.raises(ValidationError, match="gravity_m_s2"):
        altered(plan.task.spec, {"gravity_m_s2": gravity})


def test_the_default_of_gravity_is_downwards_along_y(plan):
    spec = plan.task.spec.model_dump(by_alias=True)
    del spec["gravity_m_s2"]
    assert TaskSpec.model_validate(spec).gravity_m_s2 == (0.0, -9.80665, 0.0)


def judged(plan, **robot):
    """The same motion of a robot with other values, and its verdicts by key."""
    other = retasked(plan, robot={key.replace("__", "."): value for key, value in robot.items()})
    other = dataclasses.replace(other, motor_counts=other.robot.motor_counts(other.commanded_lengths))
    return other, {check.key: check for check in run_checks(other)}


def test_too_much_pretension_buckles_and_what_is_advised_does_not(plan):
    soft = {"cables__axial_stiffness_N": 50e3}
    _, checks = judged(plan, **soft, cables__pretension_N=100.0)
    assert failed(checks.values()) == {"buckling"}
    found = checks["buckling"]
    assert found.value < 1
    assert found.step is not None
    assert f"section {found.section} buckles: pretension 100 N is above" in found.detail
    allowed, stiff = number("is above ", found.detail), number("EA ≥ ", found.detail)
    assert judged(plan, **soft, cables__pretension_N=allowed - 1)[1]["buckling"].ok
    assert judged(plan, **soft, cables__pretension_N=allowed + 2)[1]["buckling"].failed
    assert judged(plan, cables__axial_stiffness_N=1e3 * stiff, cables__pretension_N=100.0)[1]["buckling"].ok
    assert judged(plan, cables__axial_stiffness_N=0.98e3 * stiff, cables__pretension_N=100.0)[1]["buckling"].failed


def test_an_arm_that_stands_with_too_little_safety_is_told_so(plan):
    _, checks = judged(plan, cables__load_factor_min=5.0)
    assert failed(checks.values()) == {"buckling"}
    assert "is too close to buckling: pretension 40 N is above" in checks["buckling"].sentence


def test_an_arm_that_its_weight_alone_bends_too_much_is_not_told_to_lower_the_pretension(plan):
    _, checks = judged(plan, cables__axial_stiffness_N=13e3, cables__pretension_N=10.0)
    assert "under the weight: take EA ≥" in checks["buckling"].detail
    _, checks = judged(plan, cables__axial_stiffness_N=8e3, cables__pretension_N=10.0)
    assert "even with all cables at tension_min_N, 10 N: take EA ≥" in checks["buckling"].detail


def test_a_load_that_no_tensions_hold_fails_with_the_section_and_what_would(plan):
    _, checks = judged(plan, tool_mass=1.5)
    found = checks["peak_tension"]
    assert found.failed
    assert f"no tensions hold section {found.section}: raise tension_max_N to" in found.detail
    needed = number("tension_max_N to ", found.detail)
    assert needed == pytest.approx(found.value, rel=0.01)
    assert found.step is not None
    arm = dataclasses.replace(Mechanics.of(plan.robot), tool_mass=1.5)
    gravity = plan.task.gravity(plan.at)
    assert dataclasses.replace(arm, tension_max=needed).hold(plan.angles, gravity).is_held.all()
    assert not dataclasses.replace(arm, tension_max=0.98 * needed).hold(plan.angles, gravity).is_held.all()


def test_a_cable_without_tension_is_slack(plan):
    other, checks = judged(plan, cables__tension_min_N=0.0, cables__pretension_N=5.0)
    assert failed(checks.values()) == {"slack"}
    found = checks["slack"]
    assert found.cable is not None
    assert held(other).tensions[found.step, found.cable - 1] == found.value == 0.0
    assert "raise tension_min_N to 5 N" in found.sentence


def test_cables_are_judged_as_motors_move_them(plan):
    """Stretch is pulled in besides; nothing of it where mechanics are not known."""
    bare = without_cables(plan)
    for made, lengths in ((plan, plan.commanded_lengths), (bare, plan.cable_lengths)):
        out = lengths - plan.robot.straight_cable_lengths
        assert abs(made.check("cable_travel").value) == np.abs(out).max()
        speed = np.abs(np.diff(lengths, axis=0)) / np.diff(plan.time)[:, None]
        assert made.check("cable_speed").value == speed.max()
    assert plan.check("cable_travel").value != bare.check("cable_travel").value


@pytest.mark.parametrize("limits", [{"cable_speed": 0.0015}, {"cable_acceleration": 0.002}])
def test_the_fastest_profile_keeps_the_limits_of_what_motors_do(plan, limits):
    """Also where cables stretch so much that lengths and commands differ."""
    soft = {"cables.axial_stiffness_N": 21e3, "cables.pretension_N": 15.0}
    keys = {f"limits.{key}": value for key, value in limits.items()}
    made = hognose.plan(variant(plan.task, {"motion.profile": "fastest"}, soft | keys))
    step = float(made.time[1])
    speed = np.diff(made.commanded_lengths, axis=0) / step
    assert np.abs(speed).max() <= limits.get("cable_speed", np.inf)
    assert np.abs(np.diff(np.pad(speed, ((1, 1), (0, 0))), axis=0)).max() / step <= limits.get("cable_acceleration", 1)
    assert np.abs(made.cable_lengths - made.commanded_lengths).max() > 5e-4


def test_planning_refuses_what_buckles(plan):
    task = variant(plan.task, robot={"cables.axial_stiffness_N": 25e3, "cables.pretension_N": 80.0})
    error = outcome(lambda: hognose.plan(task))
    assert isinstance(error, hognose.InfeasibleError)
    assert "buckles: pretension 80 N is above" in str(error)
    assert error.plan is not None


def test_a_plan_with_other_tensions_is_not_believed(plan):
    wrong = dataclasses.replace(plan, motor_counts=plan.robot.motor_counts(plan.cable_lengths))
    assert failed(run_checks(wrong)) == {"motor_counts_agree_with_cables"}


def test_figures_cannot_be_written_to(plan):
    for name in ("tensions", "cable_lengths", "load_factor"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(plan.held, name)[0] = 0.0
