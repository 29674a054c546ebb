"""Criteria of a drum and of a carrier: how far the arm is fed, and where a carrier may go and how fast."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hognose.planning.base_limits import BaseLimits
from hognose.planning.checks.check import Check
from hognose.planning.checks.criterion import KINEMATICS, Criterion
from hognose.planning.checks.findings import failure, most, not_judged, peak
from hognose.planning.checks.motion import from_rest, is_fastest, start_and_stop_words
from hognose.planning.checks.shared import Shared
from hognose.planning.motion import Motion
from hognose.planning.thresholds import COLUMN_TOLERANCE, FEED_SLACK
from hognose.robot.base import axes_of, turns
from hognose.robot.carrier import axes_of_poses
from hognose.ties import first_largest
from hognose.wording import point

Array = NDArray[np.float64]


def drum_travel(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The first joint stays on the drum.

    Made for a drum.
    """
    if motion.task.spec.base.kind == "drum":
        (step,) = first_largest(motion.feed)
        limit = motion.task.base.farthest
        within = bool(motion.feed.min() >= 0 and motion.feed[step] <= limit * (1 + FEED_SLACK))
        yield most(motion.feed[step], limit, within, step=step)


def base_pose_agrees_with_joints(motion: Motion, shared: Shared) -> Iterator[Check]:
    """Poses put the first joint on the path, and the arm's axes where the base has them: a carrier's along its link.

    Made for a carrier, and where a motion on another base has poses. A turn that differs counts with the way it moves
    the tip of the straight arm.
    """
    if motion.base_pose is None:
        if motion.task.base.follows:
            yield failure("the plan has no poses of its carrier; what is judged besides is of those its joints need")
        return
    base = motion.task.base
    expected = axes_of(base, motion.needed_pose if base.follows else base.coordinates(motion.feed, motion.joints))
    away = np.linalg.norm(motion.base_pose[:, :3] - motion.joints[:, 0], axis=1)
    size = np.abs(np.linalg.norm(motion.base_pose[:, 3:], axis=1) - 1.0)
    # Between two poses the turn is the short one: quaternions of one sign, or it would nearly be a whole turn.
    size[1:] += np.maximum(-(motion.base_pose[1:, 3:] * motion.base_pose[:-1, 3:]).sum(axis=1), 0.0)
    turned = np.linalg.norm(axes_of_poses(motion.base_pose) - expected, axis=(1, 2))
    off = away + (turned + size) * motion.robot.length
    (step,) = first_largest(off)
    yield most(off[step], max(COLUMN_TOLERANCE, 4 * shared.tolerance), step=step)


def carrier_workspace(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The first joint stays in the carrier's workspace: how far it is outside.

    Made for a carrier.
    """
    if not motion.task.base.follows:
        return
    if motion.task.spec.base.workspace is None:
        yield not_judged("the task gives no base.workspace")
        return
    places = motion.at[:, :3]
    outside = np.linalg.norm(motion.task.base.outside(places), axis=1)
    (step,) = first_largest(outside)
    yield most(outside[step], 0.0, step=step, detail=f"the first joint at {point(places[step])}")


def carrier_speed(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The carrier moves the first joint no faster than it can.

    Made for a carrier; judged if the task gives its speed, and in the fastest profile.
    """
    if not motion.task.base.follows:
        return
    limits, starting = BaseLimits.of(motion.task), start_and_stop_words(motion, shared)
    if limits.speed_source and not is_fastest(motion):
        yield not_judged(_and("the task gives no base.speed", starting))
    else:
        detail = _and(limits.speed_source, starting)
        yield peak(_sizes(_velocities(motion, shared)), limits.speed, detail=detail)


def carrier_acceleration(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The carrier accelerates the first joint no more than it can, from rest to rest.

    Made for a carrier in the fastest profile, and at constant feed if the task gives the carrier's acceleration.
    """
    limits = BaseLimits.of(motion.task)
    if motion.task.base.follows and (is_fastest(motion) or not limits.acceleration_source):
        acceleration = shared.accelerations(_velocities(motion, shared), rests=True)
        yield peak(_sizes(acceleration), limits.acceleration, detail=from_rest(motion, limits))


def carrier_turn_speed(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The carrier turns the arm no faster than it can.

    Made for a carrier.
    """
    if not motion.task.base.follows:
        return
    if motion.task.spec.base.turn_speed_deg_s is None:
        yield not_judged("the task gives no base.turn_speed_deg_s")
    else:
        yield peak(_sizes(_turn_rates(motion, shared)), BaseLimits.of(motion.task).turn_speed)


def carrier_turn_acceleration(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The carrier's turning speeds up and slows down no faster than it can, from rest to rest.

    Made for a carrier if the task gives its turn acceleration.
    """
    if motion.task.spec.base.turn_acceleration_deg_s2 is not None:
        limits, rates = BaseLimits.of(motion.task), _turn_rates(motion, shared)
        yield peak(
            _sizes(shared.accelerations(rates, rests=True)), limits.turn_acceleration, detail="from rest to rest"
        )


def _velocities(motion: Motion, shared: Shared) -> Array:
    """Velocities (T-1, 3) m/s of the first joint."""
    return np.diff(motion.at[:, :3], axis=0) / shared.intervals[:, None]


def _turn_rates(motion: Motion, shared: Shared) -> Array:
    """Angular velocities (T-1, 3) rad/s of the arm's axes, in those of the task."""
    return turns(motion.task.base, motion.at) / shared.intervals[:, None]


def _sizes(vectors: Array) -> Array:
    return np.linalg.norm(vectors, axis=1)[:, None]


def _and(*said: str) -> str:
    return "; ".join(words for words in said if words)


CRITERIA = (
    Criterion("drum_travel", "drum travel", "m", drum_travel, KINEMATICS),
    Criterion(
        "base_pose_agrees_with_joints", "base pose agrees with joints", "m", base_pose_agrees_with_joints, KINEMATICS
    ),
    Criterion("carrier_workspace", "carrier workspace", "m", carrier_workspace, KINEMATICS),
    Criterion("carrier_speed", "carrier speed", "m/s", carrier_speed, KINEMATICS),
    Criterion("carrier_acceleration", "carrier acceleration", "m/s²", carrier_acceleration, KINEMATICS),
    Criterion("carrier_turn_speed", "carrier turn speed", "rad/s", carrier_turn_speed, KINEMATICS),
    Criterion(
        "carrier_turn_acceleration", "carrier turn acceleration", "rad/s²", carrier_turn_acceleration, KINEMATICS
    ),
)
