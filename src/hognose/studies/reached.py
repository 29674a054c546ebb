"""What the twin reached, as a motion: everything that draws and measures plans works on it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hognose.planning import Plan, Task
from hognose.robot.base import angles_on, joints_on
from hognose.sim import Simulated


def reached(done: Simulated) -> Plan:
    """The motion that the twin made, a step a row of its log and not judged, among the obstacles where they were.

    Angles, joints, cable lengths and clearances are those of the twin. Feeds are where its base was along the path, and
    motor counts are what was commanded. How far it was from its plan is `Simulated.tip_errors`: `Plan.tip_error` would
    compare it with itself.
    """
    plan, base, robot = done.plan, done.plan.task.base, done.plan.robot
    last = np.minimum(np.searchsorted(plan.time, done.time - 1e-9), len(plan.time) - 1)
    if base.follows:  # a carrier is where it was told to be
        feed, pose = plan.feed[last], done.at
    else:  # a drive lags behind
        told = base.along(done.at)
        planned = joints_on(base, robot, done.commanded, done.at, done.section_lengths)[:, 0]
        lag = np.einsum("tx,tx->t", done.joints[:, 0] - planned, plan.path.tangent(told))
        feed, pose = told + lag, None
    moved = replace(
        plan,
        task=_among(done),
        time=done.time,
        feed=feed,
        joints=done.joints,
        angles=done.angles,
        cable_lengths=robot.cable_lengths(done.angles, done.section_lengths),
        motor_counts=plan.motor_counts[last],
        clearance=plan.clearance[last],
        base_pose=pose,
        extra={},
        checks=(),
    )
    # Of its joints, as nothing keeps those and the angles of the log to the same instant.
    angles = angles_on(base, robot, done.joints, moved.at)
    moved = replace(moved, angles=angles, cable_lengths=robot.cable_lengths(angles, moved.section_lengths))
    return replace(moved, clearance=moved.clearance_now())


def _among(done: Simulated) -> Task:
    """The task among the obstacles where they were; its clock begins when the motion did, however far that came."""
    plan, task = done.plan, done.plan.task
    if plan.retracts:
        motion = task.spec.motion.model_copy(update={"retraction_start_s": float(plan.clock[0] - plan.time[0])})
        task = Task(task.spec.model_copy(update={"motion": motion}), task.robot)
    scene, moving = done.changes.space(plan.task.scene, plan.task.moving)
    return task.with_obstacles(scene, tuple(moving))
