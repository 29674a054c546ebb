"""What the twin reached, as a motion: everything that draws and measures plans works on it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hognose.planning import Plan
from hognose.robot.base import angles_on, joints_on
from hognose.sim import Changes, Simulated


def reached(done: Simulated, changes: Changes | None = None) -> Plan:
    """The motion that the twin made, P periods long and not judged, among the obstacles as they stood.

    Angles, joints, cable lengths and clearances are those of the twin. Feeds are where its base was along the path, and
    motor counts are what was commanded. How far it was from its plan is `Simulated.tip_errors`: `Plan.tip_error` would
    compare it with itself.

    Parameters
    ----------
    done
    changes
        With which it was simulated.
    """
    plan, count = done.plan, len(done.angles)
    base, robot = plan.task.base, plan.robot
    task = plan.task
    if changes is not None and changes.shifted:
        task = task.with_obstacles(changes.scene(task.scene), task.moving)
    feed = plan.feed[:count].copy()
    if not base.follows:  # a carrier is where it was told to be; a drive lags behind
        planned = joints_on(base, robot, plan.angles[:count], plan.at[:count])[:, 0]
        feed += np.einsum("tx,tx->t", done.joints[:, 0] - planned, plan.path.tangent(plan.feed[:count]))
    moved = replace(
        plan,
        task=task,
        time=plan.time[:count],
        feed=feed,
        joints=done.joints,
        motor_counts=plan.motor_counts[:count],
        angles=plan.angles[:count],
        cable_lengths=plan.cable_lengths[:count],
        clearance=plan.clearance[:count],
        base_pose=None if plan.base_pose is None else plan.base_pose[:count],
        extra={},
        checks=(),
    )
    # Of its joints, not those of the log, which are of the end of the step in which those were seen.
    angles = angles_on(base, robot, done.joints, moved.at)
    moved = replace(moved, angles=angles, cable_lengths=robot.cable_lengths(angles))
    return replace(moved, clearance=moved.clearance_now())
