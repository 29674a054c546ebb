"""Criteria of set-points and speeds."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hognose.planning import timing
from hognose.planning.base_limits import BaseLimits
from hognose.planning.checks.check import Check
from hognose.planning.checks.criterion import KINEMATICS, Criterion
from hognose.planning.checks.findings import most, peak
from hognose.planning.checks.shared import Shared
from hognose.planning.motion import Motion
from hognose.planning.thresholds import COLUMN_TOLERANCE, FEED_SLACK, TIME_TOLERANCE
from hognose.ties import first_largest

Array = NDArray[np.float64]


def set_points_a_step_apart(motion: Motion, shared: Shared) -> Iterator[Check]:
    """Each feed is one step on, so that none was left out, doubled or swapped; the rest is where the tip arrives.

    Made for constant feed.
    """
    if is_fastest(motion):
        return
    step, last = motion.task.spec.motion.step, len(motion.time) - 1
    feed = motion.feed[::-1] if motion.retracts else motion.feed
    off = np.abs(feed - timing.steady(last + 1, step, motion.task.spec.motion.period_s).feed)
    off[-1] = 0.0  # what is left of the way, where the insertion ends or the retraction begins
    rest = float(feed[-1] - feed[-2]) if last else 0.0
    # The planner counts steps to nine digits, and what is over goes with the rest.
    fits = timing.is_last_step(rest, feed[-1], step, COLUMN_TOLERANCE) and bool(off.max() <= COLUMN_TOLERANCE)
    (row,) = first_largest(off)
    which, place = ("first", last - row) if motion.retracts else ("last", row)
    detail = f"feeds are {1e3 * step:g} mm apart, the {which} two {1e3 * rest:.6g} mm"
    yield most(off[row], COLUMN_TOLERANCE, fits, step=place, detail=detail)


def set_points_go_on(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No set-point is behind the one before it. Made for the fastest profile."""
    if is_fastest(motion):
        back = np.diff(motion.feed) * (1.0 if motion.retracts else -1.0)
        yield peak(np.maximum(back, 0.0)[:, None], 0.0)


def set_points_a_period_apart(motion: Motion, shared: Shared) -> Iterator[Check]:
    """Each time is one period on; at constant feed, a shorter step at the end may take its part of a period."""
    said = motion.task.spec.motion
    off = np.abs(motion.time - timing.steady(len(motion.time), said.step, said.period_s).time)
    detail = f"times are {said.period_s:g} s apart"
    if off.max() > TIME_TOLERANCE and not is_fastest(motion):
        short = _with_short_end(motion)
        if np.abs(motion.time - short).max() <= TIME_TOLERANCE:
            off = np.abs(motion.time - short)
            detail += ", those of the shorter step its part of that"
    (row,) = first_largest(off)
    yield most(off[row], TIME_TOLERANCE, step=row, detail=detail)


def _with_short_end(motion: Motion) -> Array:
    """Times (T,) s of constant feed if the shorter step takes its part of a period."""
    said = motion.task.spec.motion
    even = timing.steady(len(motion.time), said.step, said.period_s)
    feed = motion.feed[::-1] if motion.retracts else motion.feed
    short = timing.SetPoints(np.append(even.feed[:-1], feed[-1]), even.time).with_short_end()
    return short.backwards().time if motion.retracts else short.time


def joint_speed(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No joint turns faster than the robot allows."""
    limit = math.radians(motion.robot.spec.limits.joint_speed_deg_s)
    yield peak(np.abs(shared.joint_speed).max(axis=2), limit, "section")


def joint_acceleration(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No joint accelerates more than the robot allows; in the fastest profile from rest to rest."""
    limit = math.radians(motion.robot.spec.limits.joint_acceleration_deg_s2)
    acceleration = shared.accelerations(shared.joint_speed, is_fastest(motion))
    yield peak(np.abs(acceleration).max(axis=2), limit, "section")


def feed_speed(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The slider, or the arm on its drum, moves no faster than it can."""
    if not motion.task.base.follows:
        yield peak(
            np.abs(shared.feed_speed)[:, None],
            motion.robot.spec.feed.speed,
            detail=start_and_stop_words(motion, shared),
        )


def start_and_stop_words(motion: Motion, shared: Shared) -> str:
    """What constant feed takes where it starts and stops, in words; empty of another profile."""
    if is_fastest(motion) or len(motion.time) < 2:
        return ""
    slider, joints = (
        np.abs(shared.accelerations(speed, rests=True)) for speed in (shared.feed_speed, shared.joint_speed)
    )
    needed, turned = (float(each[[0, -1]].max()) for each in (slider, joints))
    mover = motion.task.spec.base.mover
    what = "of the feed" if mover == "drum" else f"of the {mover}"
    return (
        f"constant: starts and stops within a period, with {1e3 * needed:.4g} mm/s² {what} and "
        f"{math.degrees(turned):.4g} deg/s² of a joint"
    )


def feed_acceleration(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The slider, or the arm on its drum, accelerates no more than it can, from rest to rest.

    Made for the fastest profile, and at constant feed if the robot file gives its acceleration.
    """
    limits = BaseLimits.of(motion.task)
    if not motion.task.base.follows and (is_fastest(motion) or not limits.acceleration_source):
        acceleration = np.abs(shared.accelerations(shared.feed_speed, rests=True))
        yield peak(acceleration[:, None], limits.acceleration, detail=from_rest(motion, limits))


def from_rest(motion: Motion, limits: BaseLimits) -> str:
    """What is judged of an acceleration from rest to rest, in words."""
    said = ["from rest to rest"]
    if not is_fastest(motion):
        said.append('constant feed starts and stops within a period, motion.profile = "fastest" does not')
    if limits.acceleration_source:
        said.append(limits.acceleration_source)
    return "; ".join(said)


def feed_jerk(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The acceleration of the feed builds up no faster than twice the base's limit in the smoothing time.

    Made for the fastest profile.
    """
    if is_fastest(motion):
        period = motion.task.spec.motion.period_s
        changes = np.diff(np.pad(shared.accelerations(shared.feed_speed, rests=True), 1)) / period
        limit = 2 * BaseLimits.of(motion.task).acceleration / motion.task.spec.motion.smoothing_time
        yield peak(np.abs(changes[:-1])[:, None], limit)


def slider_travel(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The slider stays within its travel."""
    if motion.task.spec.base.slides:
        axis = motion.robot.spec.feed
        (step,) = first_largest(motion.feed)
        within = bool(axis.min <= motion.feed.min() and motion.feed[step] <= axis.max * (1 + FEED_SLACK))
        yield most(motion.feed[step], axis.max, within, step=step)


def is_fastest(motion: Motion) -> bool:
    """Whether its profile is the fastest."""
    return motion.task.spec.motion.profile_of(motion.retracts) == "fastest"


CRITERIA = (
    Criterion("set_points_a_step_apart", "set-points a step apart", "m", set_points_a_step_apart, KINEMATICS),
    Criterion("set_points_go_on", "set-points go on", "m", set_points_go_on, KINEMATICS),
    Criterion("set_points_a_period_apart", "set-points a period apart", "s", set_points_a_period_apart, KINEMATICS),
    Criterion("joint_speed", "joint speed", "rad/s", joint_speed, KINEMATICS),
    Criterion("joint_acceleration", "joint acceleration", "rad/s²", joint_acceleration, KINEMATICS),
    Criterion("feed_speed", "feed speed", "m/s", feed_speed, KINEMATICS),
    Criterion("feed_acceleration", "feed acceleration", "m/s²", feed_acceleration, KINEMATICS),
    Criterion("feed_jerk", "feed jerk", "m/s³", feed_jerk, KINEMATICS),
    Criterion("slider_travel", "slider travel", "m", slider_travel, KINEMATICS),
)
