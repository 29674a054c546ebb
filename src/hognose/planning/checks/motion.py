"""Criteria of set-points and speeds."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from hognose.planning.checks.check import Check
from hognose.planning.checks.criterion import KINEMATICS, Criterion
from hognose.planning.checks.findings import most, peak
from hognose.planning.checks.shared import Shared
from hognose.planning.motion import Motion
from hognose.planning.tolerances import COLUMN_TOLERANCE, TIME_TOLERANCE
from hognose.ties import first_largest


def set_points_a_step_apart(motion: Motion, shared: Shared) -> Iterator[Check]:
    """Each feed is one step on, so that none was left out, doubled or swapped; the rest is where the tip arrives."""
    step, last = motion.task.spec.motion.step, len(motion.time) - 1
    feed = motion.feed[::-1] if motion.retracts else motion.feed
    off = np.abs(feed - step * np.arange(last + 1))
    off[-1] = 0.0  # what is left of the way, where the insertion ends or the retraction begins
    rest = float(feed[-1] - feed[-2]) if last else 0.0
    # The planner counts steps to nine digits, and what is over goes with the rest.
    fits = bool(off.max() <= COLUMN_TOLERANCE and 0 < rest <= step + COLUMN_TOLERANCE + 2e-9 * feed[-1])
    (row,) = first_largest(off)
    which, place = ("first", last - row) if motion.retracts else ("last", row)
    detail = f"feeds are {1e3 * step:g} mm apart, the {which} two {1e3 * rest:.6g} mm"
    yield most(off[row], COLUMN_TOLERANCE, fits, step=place, detail=detail)


def set_points_a_period_apart(motion: Motion, shared: Shared) -> Iterator[Check]:
    """Each time is one period on."""
    period = motion.task.spec.motion.period_s
    off = np.abs(motion.time - period * np.arange(len(motion.time)))
    (row,) = first_largest(off)
    yield most(off[row], TIME_TOLERANCE, step=row, detail=f"times are {period:g} s apart")


def joint_speed(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No joint turns faster than the robot allows."""
    limit = math.radians(motion.robot.spec.limits.joint_speed_deg_s)
    yield peak(np.abs(shared.joint_speed).max(axis=2), limit, "section")


def joint_acceleration(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No joint accelerates more than the robot allows."""
    limit = math.radians(motion.robot.spec.limits.joint_acceleration_deg_s2)
    between = 0.5 * (shared.intervals[1:] + shared.intervals[:-1])
    acceleration = np.diff(shared.joint_speed, axis=0) / between[:, None, None]
    yield peak(np.abs(acceleration).max(axis=2), limit, "section")


def feed_speed(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The slider moves no faster than it can."""
    speed = np.abs(np.diff(motion.feed)) / shared.intervals
    yield peak(speed[:, None], motion.robot.spec.feed.speed)


def slider_travel(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The slider stays within its travel."""
    axis = motion.robot.spec.feed
    (step,) = first_largest(motion.feed)
    within = bool(axis.min <= motion.feed.min() and motion.feed[step] <= axis.max)
    yield most(motion.feed[step], axis.max, within, step=step)


CRITERIA = (
    Criterion("set_points_a_step_apart", "set-points a step apart", "m", set_points_a_step_apart, KINEMATICS),
    Criterion("set_points_a_period_apart", "set-points a period apart", "s", set_points_a_period_apart, KINEMATICS),
    Criterion("joint_speed", "joint speed", "rad/s", joint_speed, KINEMATICS),
    Criterion("joint_acceleration", "joint acceleration", "rad/s²", joint_acceleration, KINEMATICS),
    Criterion("feed_speed", "feed speed", "m/s", feed_speed, KINEMATICS),
    Criterion("slider_travel", "slider travel", "m", slider_travel, KINEMATICS),
)
