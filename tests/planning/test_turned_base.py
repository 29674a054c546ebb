"""A task in another frame is the same task: nothing but the base says where the arm points."""

import numpy as np
import pytest
from planning_makers import moved, variant

import hognose
from hognose.errors import InputError
from hognose.robot.base import Slider, axes_of
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
    assert plan.held is not None
    np.testing.assert_allclose(plan.held.tensions, before.held.tensions, rtol=0, atol=1e-8)
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


def test_what_is_steered_on_a_turned_base_becomes_a_task_on_that_base(tasks):
    task, _ = moved(variant(tasks["pipe-tank"], {"obstacle": []}), 7)
    steered = SteeredPath.of(task)
    steered.advance(0.02)
    steered.advance(0.1, (1.0, 0.5))
    made = steered.task("turned")
    assert made.spec.base.kind == "slider"
    at = np.zeros((1, 1))
    np.testing.assert_allclose(axes_of(made.task.base, at), axes_of(task.base, at), rtol=0, atol=1e-12)
    np.testing.assert_allclose(made.plan.joints[-1], steered.joints, rtol=0, atol=0.001)
    assert hognose.plan(made.task).good


@pytest.mark.parametrize(
    "base",
    [
        {"kind": "slider", "direction": [0.0, 0.3, 1.0]},
        {"kind": "cart", "direction": [0.0, 0.2, 1.0], "position": [0.1, 0.0, -1.4]},
        {"kind": "arm", "rotation_deg": [20.0, 30.0, 40.0], "speed": 0.1},
    ],
)
def test_steering_keeps_the_base_that_the_task_file_says(tasks, base):
    task = variant(tasks["pipe-tank"], {"obstacle": [], "base": base})
    steered = SteeredPath.of(task)
    start = steered.joints
    steered.advance(0.1, (1.0, 0.3))
    made = steered.task("by hand")
    assert made.spec.base == task.spec.base
    np.testing.assert_allclose(made.plan.joints[0], start, rtol=0, atol=1e-11)


def test_an_arm_on_a_drum_is_not_steered(tasks):
    task = variant(tasks["pipe-tank"], {"base": {"kind": "drum", "radius": 0.25}})
    with pytest.raises(InputError, match=r"on a drum cannot be steered, .*; expected a slider, a cart or a carrier"):
        SteeredPath.of(task)
