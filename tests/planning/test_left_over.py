"""What is left of the sag although motors make up for it: against the arm at rest, and in plans."""

import dataclasses

import numpy as np
import pytest
from planning_makers import outcome, variant
from pydantic import ValidationError

import hognose
from hognose.mechanics import Mechanics
from hognose.planning.checks.shared import Shared
from hognose.planning.link_budgets import tolerances
from hognose.planning.near_places import Near, gradients
from hognose.planning.tolerance.allowance import Allowance
from hognose.planning.tolerance.left_over import ways_of
from hognose.robot import Robot

DOWN = np.array([0.0, -9.80665, 0.0])
#: Tolerances of the arm alone.
SHARES = {"tolerance.axial_stiffness_percent": 10.0, "tolerance.mass_percent": 5.0}


@pytest.fixture(scope="module")
def task():
    return hognose.load_task("obstacle-array")


@pytest.fixture(scope="module")
def plan(task):
    return hognose.plan(task)


def allowance_of(plan):
    found = Shared(plan).allowance
    assert found is not None
    return found


def test_it_is_how_far_the_arm_comes_to_rest_from_where_it_is_planned(plan):
    """Motors command what the robot file says; the arm itself is softer, or heavier."""
    rows = slice(None, None, 40)
    angles, nominal = plan.angles[rows], Mechanics.of(plan.robot)
    budget = allowance_of(hognose.plan(variant(plan.task, SHARES))).budget
    left = budget.left_over(plan.task.base, angles, plan.at[rows], plan.body[rows])
    commanded = nominal.hold(angles, DOWN).commanded_lengths
    off = 0.01
    softer = dataclasses.replace(nominal, axial_stiffness=nominal.axial_stiffness / (1 + off))
    heavier = dataclasses.replace(nominal, links=nominal.links * [1.0, 1 + off, 1.0])
    for arm, key, share in ((softer, "axial_stiffness_percent", 0.1 / (1 - 0.2)), (heavier, "mass_percent", 0.05)):
        rest = arm.settle(angles, commanded, DOWN)
        assert rest.is_stable.all()
        moved = plan.robot.joint_positions(rest.angles) - plan.robot.joint_positions(angles)
        expected = np.linalg.norm(moved, axis=2) / off
        np.testing.assert_allclose(left[key] / share, expected, rtol=0.04, atol=1e-5)


@pytest.mark.parametrize("percent", [1.0, 5.0, 15.0])
def test_ea_that_is_too_small_by_twice_its_deviation_moves_the_arm_by_no_more_than_is_taken(plan, percent):
    rows = slice(None, None, 80)
    angles, nominal, share = plan.angles[rows], Mechanics.of(plan.robot), percent / 100
    budget = variant(plan.task, {"tolerance.axial_stiffness_percent": percent}).budget
    assert budget is not None
    left = budget.left_over(plan.task.base, angles, plan.at[rows], plan.body[rows])["axial_stiffness_percent"]
    softer = dataclasses.replace(nominal, axial_stiffness=nominal.axial_stiffness * (1 - 2 * share))
    rest = softer.settle(angles, nominal.hold(angles, DOWN).commanded_lengths, DOWN)
    moved = plan.robot.joint_positions(rest.angles) - plan.robot.joint_positions(angles)
    np.testing.assert_allclose(np.linalg.norm(moved, axis=2), 2 * left, rtol=1e-3, atol=1e-6)


def test_it_is_added_to_each_link_and_most_at_the_tip(plan):
    tolerant = hognose.plan(variant(plan.task, SHARES))
    assert tolerant.good
    found = allowance_of(tolerant).at_steps(tolerant.centre_line)
    assert (np.diff(found[0]) > 0).all()
    assert found.max() == pytest.approx(2 * np.hypot(0.125, 0.05) * 4.78e-3, rel=0.02)  # 0.478 mm at 10 %
    before, after = plan.check("clearance_at_steps"), tolerant.check("clearance_at_steps")
    assert before.value - found.max() <= after.value < before.value
    np.testing.assert_array_equal(tolerant.angles, plan.angles)


def test_its_parts_are_shown_with_what_is_given(task):
    assumed = {"tolerance.assumed": ["mass_percent"], "tolerance.sag": 0.0005}
    found = tolerances(hognose.plan(variant(task, SHARES | assumed, {"cables.friction": 0.1})), 100)
    assert found.headings[1:-3] == ("sag 0.5 mm", "EA 10 %", "masses 5 % (assumed)", "friction 0.1 (assumed)")
    tip = found.links[-1]
    assert tip.taken == pytest.approx(0.0005 + np.hypot.reduce([*tip.parts.values()][1:]), abs=1e-12)
    assert "EA 10 % is" in found.headline
    assert found.taken_for_exact == ""


def test_what_is_not_given_is_named_with_what_it_would_take(task):
    found = tolerances(hognose.plan(variant(task, {"tolerance.cad": 0.0005})), 100)
    given = tolerances(hognose.plan(variant(task, {"tolerance.mass_percent": 1.0})), 100)
    assert f"each per cent (1σ) of either would take {1e3 * given.links[-1].taken:.2f} mm" in found.taken_for_exact
    assert found.taken_for_exact in found.sentences


def test_friction_counts_among_tolerances_but_is_none_itself(task, plan):
    rough = {"cables.friction": 0.1}
    assert variant(task, robot=rough).budget is None
    made = hognose.plan(variant(task, {"tolerance.cad": 1e-9}, rough))
    found = allowance_of(made).left_over["friction"]
    assert 2 * found[:, -1].max() == pytest.approx(6.7e-4, rel=0.1)  # 0.577 mm at 0.1, were it known which way
    np.testing.assert_array_equal(made.angles, plan.angles)


def test_ways_of_cables_are_known_where_they_go_on_the_same_way():
    lengths = np.array([[0.0, 0.0, 0.0], [1.0, -1.0, 0.0], [2.0, -2.0, 0.0], [1.0, -3.0, 0.0]])
    np.testing.assert_array_equal(ways_of(lengths), [[1, -1, 0], [1, -1, 0], [0, -1, 0], [-1, -1, 0]])
    assert not ways_of(lengths[:1]).any()


def test_between_coarse_steps_no_more_is_needed_than_is_taken(plan):
    budget = allowance_of(hognose.plan(variant(plan.task, SHARES))).budget
    base, rows = plan.task.base, slice(100, None, 30)
    angles, at = plan.angles[rows], plan.at[rows]
    taken = Allowance.of(budget, base, angles, at, plan.body[rows]).zeros_between
    for step, most in enumerate(taken):
        share = np.linspace(0.0, 1.0, 17)[:, None, None]
        dense = angles[step] + share * (angles[step + 1] - angles[step])
        where = at[step] + share[:, 0] * (at[step + 1] - at[step])
        joints = plan.robot.joint_positions(dense)
        parts = list(Allowance.of(budget, base, dense, where, joints).left_over.values())
        assert (np.linalg.norm(parts, axis=0).max(axis=0) <= most).all()


def test_drawn_arms_are_off_by_no_more_than_the_spread(task):
    tolerant = hognose.plan(variant(task, SHARES, {"cables.friction": 0.1}))
    allowance, steps = allowance_of(tolerant), np.array([5, 150, 312])
    links = np.full(3, 11)
    away = np.array([[0.0, 1.0, 0.0]] * 3)
    near = Near(steps, links, links, tolerant.body[steps, -1], away, np.zeros(3))
    found = np.linalg.norm(gradients(tolerant, allowance.budget, near), axis=1)
    spread = 0.5 * allowance.at_steps(tolerant.centre_line)[steps, -1]
    assert (found <= spread + 1e-12).all()
    assert (found > 0.5 * spread).all()  # it hangs downwards


def test_an_arm_without_known_mechanics_is_told_to_give_a_bound(task):
    bare = Robot.from_spec(task.robot.spec.model_copy(update={"cables": None, "assumed": ()}))
    for key in ("axial_stiffness_percent", "mass_percent"):
        spec = variant(task, {f"tolerance.{key}": 1.0}).spec
        error = outcome(lambda spec=spec: hognose.plan(hognose.Task(spec, bare)))
        assert isinstance(error, hognose.InputError)
        assert str(error).startswith(f"tolerance.{key}: what is left of the sag of sjtu-25dof cannot be worked out")
        assert str(error).endswith("Or give a bound of it, `sag`")


@pytest.mark.parametrize("spec", ["task", "robot"])
def test_more_than_15_percent_of_ea_is_refused(task, spec):
    changed = {"tolerance.axial_stiffness_percent": 16.0}
    with pytest.raises(ValidationError, match=r"with EA off by 16 % \(1σ\), cables go slack within 2σ; expected 15 %"):
        variant(task, **{"spec" if spec == "task" else "robot": changed})


def test_a_robot_that_gives_none_is_the_same_robot(task):
    zero = variant(task, robot={"tolerance.mass_percent": 0.0}).robot
    assert zero.fingerprint == task.robot.fingerprint
    own = variant(task, robot={"tolerance.mass_percent": 3.0})
    assert own.robot.fingerprint != task.robot.fingerprint
    assert own.budget is not None
    assert own.budget.given == ("mass_percent",)
