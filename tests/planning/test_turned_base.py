"""A task in another frame is the same task: nothing but the base says where the arm points."""

import numpy as np
import pytest
from planning_makers import moved, variant

import hognose
from hognose.errors import InputError
from hognose.robot.base import Slider
from hognose.steering import SteeredPath

#: What a few hundred roundings in another frame come to, m and rad.
ROUNDING = 1e-11


@pytest.mark.parametrize("name", ["obstacle-array", "pipe-tank"])
@pytest.mark.parametrize("seed", range(3))
def test_a_plan_in_another_frame_is_the_plan_moved(tasks, plans, name, seed):
    # The way-points the task's checks compare with stay those of the file, so they are not asked here.
    task, put = moved(variant(tasks[name], {"path.detour": False}), seed)
    plan, before = hognose.plan(task), plans[name]
    np.testing.assert_allclose(plan.feed, before.feed, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(plan.joints, put(before.joints), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(plan.body, put(before.body), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(plan.angles, before.angles, rtol=0, atol=1e-10)
    np.testing.assert_allclose(plan.cable_lengths, before.cable_lengths, rtol=0, atol=ROUNDING)
    np.testing.assert_array_equal(plan.motor_counts, before.motor_counts)
    np.testing.assert_allclose(plan.clearance, before.clearance, rtol=0, atol=1e-10)
    for now, then in zip(plan.checks, before.checks, strict=True):
        assert (now.key, now.ok, now.obstacle) == (then.key, then.ok, then.obstacle)
        assert now.value == pytest.approx(then.value, abs=1e-8)


def test_steering_in_another_frame_turns_the_same_way(tasks):
    turned, put = moved(tasks["pipe-tank"], 7)
    here, there = SteeredPath.of(tasks["pipe-tank"]), SteeredPath.of(turned)
    rotation = put(np.eye(3)) - put(np.zeros(3))
    for turn in ((1.0, 0.0), (0.0, -1.5), (-2.0, 1.0)):
        here.advance(0.02, turn)
        there.advance(0.02, turn)
        np.testing.assert_allclose(there.joints, put(here.joints), rtol=0, atol=1e-9)
        np.testing.assert_allclose(there.angles, here.angles, rtol=0, atol=1e-9)
        np.testing.assert_allclose(there.frame, rotation.T @ here.frame, rtol=0, atol=1e-9)


def test_a_route_is_found_in_another_frame():
    task, _ = moved(hognose.load_task("find-a-way"), 11)
    plan = hognose.plan(task)
    assert plan.good
    assert np.linalg.norm(plan.body[-1, -1] - task.way_points[-1]) < 1e-6


def test_a_base_somewhere_else_is_refused(tasks):
    task = tasks["pipe-tank"]
    base = Slider.before(task.way_points[0] + [0.0, 0.0, 0.01], task.robot)
    with pytest.raises(
        InputError, match=r"nose at \(0\.0, 0\.0, 10\.0\) mm, the entrance is at \(0\.0, 0\.0, 0\.0\) mm"
    ):
        SteeredPath(task.robot, task.scene, task.way_points[0], base=base)


def test_a_turned_base_cannot_be_said_in_a_task_file(tasks):
    task, _ = moved(tasks["pipe-tank"], 7)
    steered = SteeredPath.of(task)
    steered.advance(0.02)
    with pytest.raises(InputError, match="task files cannot say one that is turned"):
        steered.task("turned")
