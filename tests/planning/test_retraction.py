"""Out again: the same motion backwards, judged by the same checks."""

import dataclasses

import numpy as np
import pytest
from planning_makers import failed

import hognose
from hognose.planning import Task, retraction, run_checks


@pytest.mark.parametrize("name", ["obstacle-array", "pipe-tank"])
def test_a_round_trip_ends_in_the_straight_pose_exactly(plans, name):
    plan = plans[name]
    back = retraction(plan)
    assert back.good
    assert back.retracts
    assert not plan.retracts
    assert {c.key for c in back.checks} ^ {c.key for c in plan.checks} == {"starts_straight", "ends_straight"}
    for column in ("feed", "angles", "joints", "cable_lengths", "motor_counts", "clearance"):
        assert np.array_equal(getattr(back, column)[0], getattr(plan, column)[-1])
        assert np.array_equal(getattr(back, column)[-1], getattr(plan, column)[0])
    assert back.feed[-1] == 0
    np.testing.assert_array_equal(back.motor_counts[-1], back.robot.motor_counts(back.commanded_lengths[-1]))
    again = retraction(back)
    assert np.array_equal(again.angles, plan.angles)
    certified = [[c.value for c in p.checks if c.key.startswith("certified")] for p in (plan, back)]
    assert certified[0] == pytest.approx(certified[1], abs=0.0003)


def test_a_retraction_is_saved_and_checked_like_any_plan(plans, tmp_path):
    retraction(plans["pipe-tank"]).save(tmp_path / "out.parquet")
    loaded = hognose.Plan.load(tmp_path / "out.parquet")
    assert all(check.ok for check in run_checks(loaded))
    assert "feed 1058.6 to 0.0 mm" in loaded.summary()


def test_a_retraction_is_read_as_one_and_its_set_points_are_a_step_apart_too(boards, tmp_path):
    back = retraction(boards)
    back.save(tmp_path / "out.parquet")
    read = hognose.Plan.load(tmp_path / "out.parquet")
    assert read.good
    assert read.retracts
    assert read.checks == back.checks
    rows = np.r_[0:100, 101 : len(back.time)]
    columns = ("feed", "joints", "angles", "cable_lengths", "motor_counts", "clearance")
    fewer = {name: getattr(back, name)[rows] for name in columns}
    checks = dataclasses.replace(back, time=back.time[:-1], **fewer).verified().checks
    assert "set_points_a_step_apart" in failed(checks)
    assert "set_points_a_period_apart" not in failed(checks)


def test_set_points_of_another_profile_are_not_of_a_follower_that_may_remember(plans):
    task = plans["pipe-tank"].task
    motion = task.spec.motion.model_copy(update={"retraction_profile": "fastest"})
    spec = task.spec.model_copy(update={"motion": motion})
    plan = dataclasses.replace(plans["pipe-tank"], task=Task(spec, task.robot))
    vars(plan)["follower"] = None
    assert retraction(plan).good
