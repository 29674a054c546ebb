"""Steering where a carrier takes the base along: beyond the arm's length, as far as workspace and mount allow."""

import dataclasses

import numpy as np
import pytest

import hognose
from hognose.errors import InputError
from hognose.planning import Task
from hognose.planning.tolerance.budget import Budget
from hognose.planning.tolerance.spec import ToleranceSpec
from hognose.robot.base import SAME_PLACE
from hognose.robot.carrier import Carrier
from hognose.scene import Box, Scene
from hognose.steering import SteeredPath

ARM = hognose.load_robot("sjtu-25dof")
EMPTY = Scene.from_obstacles([])


def carried(scene=EMPTY, workspace=None, robot=ARM, **more):
    base = Carrier.before(np.zeros(3), robot, np.eye(3), None if workspace is None else np.array(workspace))
    return SteeredPath(robot, scene, base=base, **more)


def along(steered, distance, turn=None):
    """Advance in small moves; what held the last one."""
    for _ in range(round(distance / 0.005)):
        move = steered.advance(0.005, turn)
        if move.held_by is not None:
            return move.held_by
    return None


def on_carrier(**changes):
    """The bundled task with a carrier that is said to be different."""
    task = hognose.load_task("carrier")
    return Task(task.spec.model_copy(update={"base": task.spec.base.model_copy(update=changes)}), task.robot)


def test_a_carried_arm_is_steered_beyond_its_length_and_planned():
    steered = carried()
    assert along(steered, 0.8, (2.0, 0.0)) is None
    assert along(steered, 1.0, (-1.0, 0.5)) is None
    assert steered.feed > ARM.length
    assert np.abs(steered.angles).max() <= ARM.bend_limits.max()
    made = steered.task("far")
    assert made.plan.good
    np.testing.assert_allclose(made.plan.joints[-1], steered.joints, rtol=0, atol=1e-3)
    back = steered.retreat(3.0)
    assert back.advanced == pytest.approx(-1.8, abs=1e-9)
    assert np.array_equal(steered.joints, carried().joints)


def test_the_workspace_holds_the_first_joint():
    box = [[-0.2, -0.2, -1.2], [0.2, 0.2, 0.1]]
    steered = carried(workspace=box)
    held = along(steered, 1.5, (0.1, 0.0))
    assert held is not None
    assert held.reason == "workspace"
    assert "outside base.workspace, at (" in held.sentence
    assert steered.joints[0, 2] == pytest.approx(0.1, abs=2e-6)
    assert steered.joints[0, 2] <= 0.1 + SAME_PLACE
    steered.retreat(0.01)
    said = steered.task("held", obstacles=[]).spec.base.workspace
    assert said is not None
    assert np.array_equal([said.low, said.high], box)


def test_the_mount_holds_where_it_swings_aside_of_the_path():
    """In a bend the mount sticks out straight behind the first link, where no link has passed."""
    thick = dataclasses.replace(ARM, spec=ARM.spec.model_copy(update={"base_length": 0.4}))
    scene = Scene.from_obstacles([Box(center=(-0.25, 0.0, -0.02), size=(0.4, 0.4, 0.2))])
    steered = carried(scene, robot=thick)
    held = along(steered, 2.0, (2.5, 0.0))
    assert held is not None
    assert held.reason == "clearance"
    assert held.sentence.startswith("the mount, or what it sweeps, is ")
    assert held.section is None
    starts, ends, radii = steered._base.behind(steered._at)
    assert scene.clearance(starts[None], ends[None], radii).value.min() >= 0.005


def test_what_tolerances_take_of_the_mount_is_kept_and_said():
    thick = dataclasses.replace(ARM, spec=ARM.spec.model_copy(update={"base_length": 0.4}))
    scene = Scene.from_obstacles([Box(center=(-0.25, 0.0, -0.02), size=(0.4, 0.4, 0.2))])
    said = {"cad": 0.002, "registration_deg": 0.05, "registration_at": (3.0, 0.0, 0.0)}
    budget = Budget.of(ToleranceSpec.model_validate(said), thick, np.zeros(3))
    assert budget is not None
    steered = carried(scene, robot=thick, tolerances=np.zeros(12), budget=budget)
    held = along(steered, 2.0, (2.5, 0.0))
    assert held is not None
    behind = steered._base.behind(steered._at)
    taken = budget.of_mount(steered._base, *behind)
    assert (scene.clearance(behind[0][None], behind[1][None], behind[2]).value >= 0.005 + taken).all()
    least = 0.002 + 2.0 * np.radians(0.05) * np.linalg.norm(np.subtract(behind[:2], (3.0, 0.0, 0.0)), axis=2).max()
    assert held.limit == pytest.approx(1e3 * (0.005 + least), abs=0.05)
    assert f"the margin is 5.00 mm, and tolerances take up to {held.limit - 5.0:.2f} mm" in held.sentence
    assert held.value < held.limit + 0.1


def test_the_mount_at_the_start_keeps_what_tolerances_take_of_it():
    said = {"registration_deg": 0.5, "registration_at": (5.0, 0.0, -1.0)}
    budget = Budget.of(ToleranceSpec.model_validate(said), ARM, np.zeros(3))
    beside = Scene.from_obstacles([Box(center=(0.0, 0.15, -1.2), size=(0.02, 0.1, 0.02))])
    carried(beside, tolerances=np.zeros(12))
    with pytest.raises(InputError, match=r"start: the mount of the straight arm .* expected at least 92\.\d+ mm"):
        carried(beside, tolerances=np.zeros(12), budget=budget)


def test_the_stiffest_section_limits_turns_anywhere_on_a_carrier():
    """All sections come along anywhere; a slider's first ones never come in deep."""
    spec = ARM.spec.model_dump(by_alias=True)
    group = spec["section"][0]
    spec["section"] = [{**group, "count": 4, "bend_limit_deg": 10.0}, {**group, "count": 8}]
    robot = hognose.Robot.from_spec(type(ARM.spec).model_validate(spec))
    steered, slid = carried(robot=robot), SteeredPath(robot, EMPTY)
    stiff = steered.sharpest
    for each in (steered, slid):
        assert along(each, 0.9) is None
    assert steered.sharpest == stiff
    assert slid.sharpest > 2 * stiff


def test_a_carrier_that_has_no_speed_is_not_held_to_the_sliders():
    assert carried(period_s=0.1).advance(0.03).held_by is None
    held = SteeredPath(ARM, EMPTY, period_s=0.1).advance(0.03).held_by
    assert held is not None
    assert held.reason == "feed speed"


def test_a_carrier_is_held_to_its_own_speed():
    held = SteeredPath.of(on_carrier(speed=0.02), period_s=0.1).advance(0.003).held_by
    assert held is not None
    assert (held.reason, held.limit) == ("feed speed", 20.0)


def test_a_carrier_is_held_to_how_fast_it_turns():
    task = on_carrier(turn_speed_deg_s=3.0)
    task = Task(task.spec.model_copy(update={"obstacle": ()}), task.robot)
    free, held = SteeredPath.of(task), SteeredPath.of(task, period_s=0.1)
    assert along(free, 0.3, (2.0, 0.0)) is None
    assert along(held, 0.3, (2.0, 0.0)) is None
    assert along(free, 1.0) is None
    found = along(held, 1.0)
    assert found is not None
    assert (found.reason, found.limit) == ("carrier turn speed", pytest.approx(3.0))
    assert found.value > 3.0
    before = held.R_task_base[:, 2]
    held.advance(0.005)
    turned = np.degrees(np.arccos(held.R_task_base[:, 2] @ before)) / 0.1
    assert turned == pytest.approx(3.0, abs=0.02)


@pytest.mark.parametrize(("key", "limit"), [("acceleration", 0.1), ("turn_acceleration_deg_s2", 1.0)])
def test_what_was_steered_is_planned_as_slowly_as_its_carrier_accelerates(key, limit):
    task = on_carrier(**{key: limit})
    task = Task(task.spec.model_copy(update={"obstacle": ()}), task.robot)
    steered = SteeredPath.of(task)
    assert along(steered, 0.3, (2.0, 0.0)) is None  # and straight on, until the first link comes into the bend
    assert along(steered, 1.0) is None
    made = steered.task("slow")
    assert made.plan.good
    assert made.plan.check(f"carrier_{key.removesuffix('_deg_s2')}").failed is False
    assert made.spec.motion.period_s > task.spec.motion.period_s


def test_a_start_outside_the_workspace_is_refused():
    box = hognose.load_task("carrier").spec.base.workspace
    assert box is not None
    with pytest.raises(InputError, match=r"base\.workspace: at feed 0"):
        SteeredPath.of(on_carrier(workspace=box.model_copy(update={"low": (-0.3, -0.3, -1.0)})))
