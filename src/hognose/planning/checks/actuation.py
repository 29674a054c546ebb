"""Criteria of cables and motors."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hognose.planning.certificate import judges_cables
from hognose.planning.checks.check import Check
from hognose.planning.checks.criterion import KINEMATICS, Criterion
from hognose.planning.checks.findings import agrees, informative, most, not_judged, peak, within
from hognose.planning.checks.shared import Shared
from hognose.planning.motion import Motion
from hognose.ties import first_largest
from hognose.wording import at_most


def cables_agree_with_angles(motion: Motion, shared: Shared) -> Iterator[Check]:
    """Cable lengths are those of the angles."""
    yield agrees(np.abs(shared.cable_lengths - motion.cable_lengths))


def cable_travel(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No cable is pulled in or paid out farther than the robot allows.

    Where mechanics are known, by what motors do: stretch is pulled in besides.
    """
    travel = motion.commanded_lengths - motion.robot.straight_cable_lengths
    yield within(travel, motion.robot.spec.limits.cable_travel)


def cable_speed(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No cable moves faster than the robot allows; where mechanics are known, as motors command it."""
    speed = np.abs(np.diff(motion.commanded_lengths, axis=0)) / shared.intervals[:, None]
    yield peak(speed, motion.robot.spec.limits.cable_speed, "cable")


def cable_acceleration(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No cable accelerates more than the robot allows; in the fastest profile from rest to rest.

    Made for robots that have such a limit; where mechanics are known, of what motors command.
    """
    limit = motion.robot.spec.limits.cable_acceleration
    if limit is not None:
        speed = np.diff(motion.commanded_lengths, axis=0) / shared.intervals[:, None]
        rests = motion.task.spec.motion.profile_of(motion.retracts) == "fastest"
        yield peak(np.abs(shared.accelerations(speed, rests)), limit, "cable")


def motor_counts_agree_with_cables(motion: Motion, shared: Shared) -> Iterator[Check]:
    """Motor counts are those of the cable lengths of the angles, exactly.

    Where mechanics are known, the lengths are those that are commanded, without the stretch.
    """
    expected, given = motion.robot.motor_counts(motion.commanded_lengths), motion.motor_counts
    size = np.abs(expected.astype(np.float64) - given)
    step, cable = first_largest(np.where(expected != given, size + 1.0, 0.0))
    # In Python's whole numbers: the difference of two of 64 bits may need 65.
    wrong = abs(int(expected[step, cable]) - int(given[step, cable]))
    yield most(wrong, 0, step=step, cable=cable) if wrong else most(0, 0)


def motor_counts(motion: Motion, shared: Shared) -> Iterator[Check]:
    """Motor counts stay within the range of the drives."""
    yield within(motion.robot.motor_counts(motion.commanded_lengths), motion.robot.spec.limits.motor_counts)


def rounding_to_counts(motion: Motion, shared: Shared) -> Iterator[Check]:
    """Rounding cable lengths to motor counts moves no point of the body farther than the margin.

    The certified clearance of interpolated cables has it taken off already, so a task without a margin only gets the
    figure. Not judged where that motion is not.
    """
    if not judges_cables(motion.robot):
        yield not_judged("how cables bend sections of this kind is not known")
        return
    if np.isnan(shared.counted_angles).any():
        step, section = first_largest(shared.counted_angles[:, :, 0])
        detail = "the cables do not determine the joints"
        yield most(np.inf, motion.task.margin, step=step, section=section, detail=detail)
        return
    step, chord = first_largest(shared.rounding)
    section, worst = motion.robot.outline.sections[chord], shared.rounding[step, chord]
    if motion.task.margin > 0:
        yield most(worst, motion.task.margin, step=step, link=section)
    else:
        yield informative(f"{at_most(1e3 * worst, 4)} mm, where the task has no margin", step=step, link=section)


CRITERIA = (
    Criterion("cables_agree_with_angles", "cables agree with angles", "m", cables_agree_with_angles, KINEMATICS),
    Criterion("cable_travel", "cable travel", "m", cable_travel, KINEMATICS),
    Criterion("cable_speed", "cable speed", "m/s", cable_speed, KINEMATICS),
    Criterion("cable_acceleration", "cable acceleration", "m/s²", cable_acceleration, KINEMATICS),
    Criterion(
        "motor_counts_agree_with_cables",
        "motor counts agree with cables",
        "counts",
        motor_counts_agree_with_cables,
        KINEMATICS,
    ),
    Criterion("motor_counts", "motor counts", "counts", motor_counts, KINEMATICS),
    Criterion("rounding_to_counts", "rounding to counts moves the body", "m", rounding_to_counts, KINEMATICS),
)
