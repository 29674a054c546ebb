"""Criteria of a drum and of a carrier: how far the arm is fed, and where a carrier may go and how fast."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from hognose.planning.checks.check import Check
from hognose.planning.checks.criterion import KINEMATICS, Criterion
from hognose.planning.checks.findings import most, not_judged, peak
from hognose.planning.checks.shared import Shared
from hognose.planning.motion import Motion
from hognose.planning.tolerances import COLUMN_TOLERANCE
from hognose.robot.base import axes_of
from hognose.ties import first_largest
from hognose.wording import point


def drum_travel(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The first joint stays on the drum.

    Made for a drum.
    """
    if motion.task.spec.base.kind == "drum":
        (step,) = first_largest(motion.feed)
        limit = motion.task.base.farthest
        yield most(motion.feed[step], limit, bool(motion.feed.min() >= 0 and motion.feed[step] <= limit), step=step)


def base_pose_agrees_with_joints(motion: Motion, shared: Shared) -> Iterator[Check]:
    """A carrier's poses put the first joint on the path, with the arm's z axis along the first link.

    Made for a carrier. A turn that differs counts with the way it moves the tip of the straight arm.
    """
    if motion.base_pose is None:
        return
    base = motion.task.base
    expected = base.coordinates(motion.feed, motion.joints)
    away = np.linalg.norm(motion.base_pose[:, :3] - expected[:, :3], axis=1)
    size = np.abs(np.linalg.norm(motion.base_pose[:, 3:], axis=1) - 1.0)
    # Between two poses the turn is the short one: quaternions of one sign, or it would nearly be a whole turn.
    size[1:] += np.maximum(-(motion.base_pose[1:, 3:] * motion.base_pose[:-1, 3:]).sum(axis=1), 0.0)
    turned = np.linalg.norm(axes_of(base, motion.base_pose) - axes_of(base, expected), axis=(1, 2))
    off = away + (turned + size) * motion.robot.length
    (step,) = first_largest(off)
    yield most(off[step], max(COLUMN_TOLERANCE, 4 * shared.tolerance), step=step)


def carrier_workspace(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The first joint stays in the carrier's workspace: how far it is outside.

    Made for a carrier.
    """
    if motion.base_pose is None:
        return
    box = motion.task.spec.base.workspace
    if box is None:
        yield not_judged("the task gives no base.workspace")
        return
    places = motion.base_pose[:, :3]
    beyond = np.maximum(np.array(box.low) - places, places - np.array(box.high))
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
    (step,) = first_largest(outside)
    yield most(outside[step], 0.0, step=step, detail=f"the first joint at {point(places[step])}")


def carrier_speed(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The carrier moves the first joint no faster than it can.

    Made for a carrier.
    """
    if motion.base_pose is None:
        return
    limit = motion.task.spec.base.speed
    if limit is None:
        yield not_judged("the task gives no base.speed")
    else:
        way = np.linalg.norm(np.diff(motion.base_pose[:, :3], axis=0), axis=1)
        yield peak((way / shared.intervals)[:, None], limit)


def carrier_turn_speed(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The carrier turns the arm no faster than it can.

    Made for a carrier.
    """
    if motion.base_pose is None:
        return
    limit = motion.task.spec.base.turn_speed_deg_s
    if limit is None:
        yield not_judged("the task gives no base.turn_speed_deg_s")
    else:
        turn = np.linalg.norm(motion.task.base.spin(motion.base_pose[:-1], motion.base_pose[1:]), axis=1)
        yield peak((turn / shared.intervals)[:, None], math.radians(limit))


CRITERIA = (
    Criterion("drum_travel", "drum travel", "m", drum_travel, KINEMATICS),
    Criterion(
        "base_pose_agrees_with_joints", "base pose agrees with joints", "m", base_pose_agrees_with_joints, KINEMATICS
    ),
    Criterion("carrier_workspace", "carrier workspace", "m", carrier_workspace, KINEMATICS),
    Criterion("carrier_speed", "carrier speed", "m/s", carrier_speed, KINEMATICS),
    Criterion("carrier_turn_speed", "carrier turn speed", "rad/s", carrier_turn_speed, KINEMATICS),
)
