"""The bundled tasks of other arms than the paper's, planned, and held against independent judges."""

import numpy as np
import pytest

import hognose
from hognose.planning import run_checks
from hognose.robot.base import outline

TASKS = {
    "test-box": "zju-24cable",
    "pipe-jungle": "casia-coiled",
    "engine-stage": "on-wing-taper",
    "feeder-slot": "safire-18dof",
    "baffled-tank": "metabot-3arc",
}


@pytest.fixture(scope="module")
def plans():
    return {name: hognose.plan(hognose.load_task(name)) for name in TASKS}


@pytest.mark.parametrize("name", TASKS)
def test_the_task_of_an_arm_is_planned_and_proven(plans, name):
    plan = plans[name]
    assert plan.robot.name == TASKS[name]
    assert plan.good
    assert len(plan.feed) <= 201
    found = {check.key: check for check in plan.checks}
    proven = found["certified_interpolated"]
    assert plan.task.margin <= proven.value <= plan.clearance.min() + 1e-12
    if name == "baffled-tank":  # the only one of these arms that says its cables and how stiff it is
        assert all(found[key].ok for key in ("peak_tension", "slack", "buckling"))
    else:
        assert found["peak_tension"].ok is None
        assert "no table [cables]" in found["peak_tension"].detail
    np.testing.assert_allclose(plan.joints[-1, -1], plan.task.way_points[-1], rtol=0, atol=1e-6)


@pytest.mark.parametrize("name", TASKS)
def test_between_the_steps_nothing_comes_closer_than_is_proven(plans, name):
    """The body at angles and feeds between those of the steps, against the distance of the scene."""
    plan, rng = plans[name], np.random.default_rng(1)
    robot, base, scene = plan.robot, plan.task.base, plan.scene
    steps, part = rng.integers(0, len(plan.feed) - 1, 30), rng.uniform(0, 1, (30, 1, 1))
    angles = (1 - part) * plan.angles[steps] + part * plan.angles[steps + 1]
    feeds = (1 - part[:, 0]) * plan.feed[steps, None] + part[:, 0] * plan.feed[steps + 1, None]
    joints = base.placed(robot.joint_positions(angles, base.along(feeds)), feeds)
    line = outline(base, robot, joints, feeds)
    starts, ends = line[:, :-1].reshape(-1, 3), line[:, 1:].reshape(-1, 3)
    away = scene.distance(starts, ends).value.reshape(len(line), -1) - robot.outline.radii
    away = away[:, robot.outline.radii > 0]
    assert away.min() >= plan.task.margin
    assert away.min() < plan.clearance.min() + 0.02  # it came near at all


def test_each_plan_is_read_back_and_checked_as_good(plans, tmp_path):
    for name in ("test-box", "baffled-tank"):
        plans[name].save(tmp_path / "plan.parquet")
        loaded = hognose.Plan.load(tmp_path / "plan.parquet")
        assert [check.ok for check in run_checks(loaded)] == [check.ok for check in plans[name].checks]
        assert loaded.good


def test_the_coiled_arm_stays_within_its_published_limits_off_the_drum(plans):
    """What bends more lies on the drum; joint 1, which has one axis and one side, only unbends."""
    plan, limit = plans["pipe-jungle"], 0.34888
    arcs = plan.feed[:, None] + 0.2 * np.arange(12)  # of each joint along the path, at most: links are chords
    off = arcs > plan.task.base.farthest + 0.2
    assert off.any()
    assert np.abs(plan.angles)[off].max() <= limit
    assert np.abs(plan.angles[:, 0, 1]).max() < 1e-9
    assert (plan.angles[:, 0, 0] >= 0).all()
    assert (plan.angles[:, 0, 0] <= limit).all()


def test_the_arm_in_the_test_box_goes_through_the_shelf(plans):
    """Where its body crosses the shelf it is within the published rectangle of the hole, 154 by 207 mm."""
    line = plans["test-box"].centre_line[-1]
    crossing = np.flatnonzero((line[:-1, 1] < 0.1535) & (line[1:, 1] >= 0.1535))
    assert len(crossing) == 1
    low, high = line[crossing[0]], line[crossing[0] + 1]
    at = low + (0.1535 - low[1]) / (high[1] - low[1]) * (high - low)
    assert abs(at[0]) + 0.045 < 0.077
    assert abs(at[2] - 0.360) + 0.045 < 0.1035


def test_the_flat_arm_is_in_a_slot_that_the_round_body_around_it_does_not_fit(plans):
    plan = plans["feeder-slot"]
    robot, scene = plan.robot, plan.scene
    joints = plan.joints[-1]
    axis = scene.distance(joints[:-1], joints[1:]).value.min()
    assert axis < 0.0231  # half of 46 mm
    assert axis < robot.body_radii.min()
    assert plan.clearance.min() >= axis - 0.0125 - robot.outline.loss[0, 0] - 1e-9
