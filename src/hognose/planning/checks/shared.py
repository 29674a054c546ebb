"""What several criteria need to know of a motion, worked out once."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hognose.cached import cached_array, cached_property
from hognose.planning.certificate import (
    Certificate,
    OwnClearance,
    Passing,
    UndeterminedError,
    cables_motion,
    certify,
    certify_cables,
    certify_own_body,
    certify_passing,
    gliding_motion,
    interpolated_motion,
    judges_cables,
    outlined,
)
from hognose.planning.certificate.moving import Moving, apart
from hognose.planning.checks.between_steps import TensionsBetween, tensions_between
from hognose.planning.checks.mount import MountShared
from hognose.planning.followed import followed
from hognose.planning.motion import Motion
from hognose.planning.penetration import per_section, section_clearance
from hognose.planning.tolerance.allowance import Allowance
from hognose.planning.tolerance.pulls import PullAllowance
from hognose.robot.base import angles_on, centre_line, centre_line_on, outline, outline_on
from hognose.robot.own_body import bends_of, clearance_of_neighbours
from hognose.threads import together
from hognose.ties import first_smallest

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Shared:
    """Figures that follow from a motion's feeds and angles; nothing stored is believed.

    `measured` is the clearance (T, n) m at `motion.body`, if it was only just measured.
    """

    motion: Motion
    measured: Array | None = None

    @property
    def arrived(self) -> int:
        """The row at which the tip is on the target."""
        return 0 if self.motion.retracts else len(self.motion.time) - 1

    @property
    def outside(self) -> int:
        """The row at which the arm is straight before the entrance."""
        return len(self.motion.time) - 1 if self.motion.retracts else 0

    @property
    def tolerance(self) -> float:
        """How closely (m) the following method places joints."""
        return max(self.motion.follower.tolerance, 1e-11)

    @cached_array
    def followed(self) -> Array:
        """Joints and tip (T, n+1, 3) m where the task's method puts them; errors as of `follow`."""
        motion = self.motion
        # Not with `motion.follower`, which may remember: some methods go on from where they last were.
        return followed(motion.task, motion.path, motion.feed)

    @cached_array
    def rest(self) -> Array:
        """Angles (n, 2) rad of the arm where it lies on its base at feed 0: straight, but on a drum."""
        motion, base = self.motion, self.motion.task.base
        if base.straight:
            return np.zeros((motion.robot.sections, 2))
        joints = followed(motion.task, motion.path, [0.0], "exact")
        return angles_on(base, motion.robot, joints, base.coordinates(np.zeros(1), joints))[0]

    @cached_array
    def intervals(self) -> Array:
        """Times (T-1,) s from step to step."""
        return np.diff(self.motion.time)

    @cached_array
    def joint_speed(self) -> Array:
        """Speeds (T-1, n, 2) rad/s of the joint angles."""
        return np.diff(self.motion.angles, axis=0) / self.intervals[:, None, None]

    @cached_array
    def feed_speed(self) -> Array:
        """Speeds (T-1,) m/s of the feed, signed."""
        return np.diff(self.motion.feed) / self.intervals

    def accelerations(self, speed: Array, rests: bool = False) -> Array:
        """Accelerations (T-2, ...) between speeds (T-1, ...); (T, ...) if the motion rests before and after them."""
        intervals = self.intervals
        if rests:
            speed = np.pad(speed, [(1, 1)] + [(0, 0)] * (speed.ndim - 1))
            intervals = np.pad(intervals, 1, mode="edge")
        between = 0.5 * (intervals[1:] + intervals[:-1])
        return np.diff(speed, axis=0) / between.reshape(-1, *[1] * (speed.ndim - 1))

    @cached_array
    def cable_lengths(self) -> Array:
        """Cable lengths (T, c) m of the angles."""
        return self.motion.robot.cable_lengths(self.motion.angles, self.motion.section_lengths)

    @cached_array
    def clearance(self) -> Array:
        """Clearance (T, n) m of every link at `motion.body`; at the horizon a lower bound."""
        if self.measured is not None:
            return self.measured
        motion = self.motion
        return motion.clearance_now() if motion.task.moving else self._measured_at(motion.outline)

    @cached_array
    def still(self) -> Array:
        """Clearance (T, n) m of every link at `motion.body` to the obstacles that stand still."""
        return self._measured_at(self.motion.outline) if self.motion.task.moving else self.clearance

    @cached_property
    def allowance(self) -> Allowance | None:
        """What tolerances take of clearances; None without tolerances."""
        motion, budget = self.motion, self.motion.task.budget
        if budget is None:
            return None
        held = motion.held if budget.mechanics else None
        return Allowance.of(budget, motion.task.base, motion.angles, motion.at, motion.body, held)

    @cached_property
    def pulls(self) -> PullAllowance | None:
        """What tolerances take of tensions and load factors; None if nothing, or where mechanics are not known."""
        motion, task = self.motion, self.motion.task
        return PullAllowance.of(task.budget, task.mechanics, motion.angles, motion.held, task.gravity(motion.at))

    @cached_property
    def between(self) -> TensionsBetween:
        """Tensions on the way from each step to the next, and what tolerances leave of them."""
        return tensions_between(self.motion, 0.0 if self.pulls is None else self.pulls.taken)

    @cached_array
    def taken(self) -> Array:
        """What tolerances take (T, n) m of the clearance of every link at the steps."""
        if self.allowance is None:
            return np.zeros_like(self.clearance)
        taken = self.allowance.at_steps(self.motion.outline)
        return per_section(self.motion.robot.outline.sections, taken, np.maximum)

    @cached_array
    def left(self) -> Array:
        """The clearance (T, n) m of every link that tolerances leave at the steps."""
        return self.clearance - self.taken

    @cached_property
    def along_path(self) -> Certificate | None:
        """What is proven of the motion that the method makes of a steady feed; None if joints may jump."""
        if self.gliding is None:
            return None
        motion, line = self.motion, self.gliding_line
        if motion.exact_joints is motion.joints:
            body = motion.outline if motion.robot.outline.flat else motion.body
            clearance = self.still - apart(body, line).max()
        else:
            clearance = self._measured_at(self._outline_of(motion.exact_joints))
        return self._certified(self._outlined(self.gliding), line, clearance)

    @cached_array
    def gliding_line(self) -> Array:
        """Ends (T, c+1, 3) m of the chords of the outline of straight links at `exact_joints`."""
        joints = self.motion.exact_joints
        return self._outline_of(joints) if self.motion.robot.outline.flat else joints

    @cached_property
    def interpolated(self) -> Certificate:
        """What is proven of feed and joint angles that go linearly from step to step."""
        return self._certified(self._outlined(self.linear), self.motion.outline, self.still)

    def prove_all(self) -> None:
        """Work out the certificates of all motions past what stands still, at the same time."""
        _ = self.still, self.allowance, self.linear  # all of them need these, and none shall work them out again
        cables, glides = judges_cables(self.motion.robot), self.glides
        together(
            lambda: self.cables_interpolated if cables else None,
            lambda: (self.along_path if glides else None, self.interpolated),
        )

    @property
    def glides(self) -> bool:
        """Whether joints glide along the path from step to step, and something is known of it."""
        robot, base = self.motion.robot, self.motion.task.base
        # How a carrier rolls about the first link while joints glide is not known; of a round body it does not matter.
        return self.motion.follower.glides and robot.straight_links and not (robot.outline.flat and base.follows)

    def _certified(self, moving: Moving, vertices: Array, clearance: Array) -> Certificate:
        motion, task = self.motion, self.motion.task
        rest = (motion.horizon, task.margin, self.allowance)
        return certify(moving, motion.robot, motion.scene, vertices, clearance, *rest)

    @cached_property
    def within_body(self) -> OwnClearance:
        """What is proven of the body against itself: joint angles or cables go linearly, or joints glide.

        The worst of them, as far as they exist; cables at whole motor counts. What is close only where sections are
        short is no closer than `clearance_of_neighbours`.
        """
        motion, robot, base = self.motion, self.motion.robot, self.motion.task.base
        straight_links = robot.straight_links
        bends = bends_of(motion.angles) if straight_links else None
        found = [certify_own_body(self.linear, robot, motion.centre_line, bends, base)]
        gliding_on = self.gliding if self.glides else None
        if gliding_on is not None:
            exact = motion.exact_joints
            if exact is not motion.joints:
                bends = bends_of(angles_on(base, robot, exact, motion.at))
            found.append(certify_own_body(gliding_on, robot, centre_line(base, robot, exact, motion.at), bends, base))
        drives = self.drives if judges_cables(robot) else None
        if drives is not None:  # `certified_cables` says if nothing is proven
            with contextlib.suppress(UndeterminedError):
                counted = bends_of(self.counted_angles) if straight_links else None
                found.append(certify_own_body(drives, robot, self.counted_line, counted, base))
        values = np.array([proof.clearance for proof in found])
        (worst,) = first_smallest(values)
        return replace(found[worst], clearance=min(float(values.min()), clearance_of_neighbours(robot, base.mount)))

    @cached_property
    def linear(self) -> Moving:
        """The motion of feed and joint angles that go linearly from step to step."""
        motion = self.motion
        base, sections = motion.task.base, motion.section_lengths
        return interpolated_motion(motion.robot, base, motion.at, motion.angles, sections)

    @cached_property
    def gliding(self) -> Moving | None:
        """The motion of straight links whose joints glide along the path; None where they may jump."""
        return gliding_motion(self.motion.follower.curve, self.motion.robot, self.motion.feed)

    @cached_property
    def drives(self) -> Moving | None:
        """The motion of feed and motor counts that go linearly from step to step; None where it is not determined."""
        motion, angles, sections = self.motion, self.counted_angles, self.counted_sections
        if not (np.isfinite(angles).all() and (sections > 0.0).all()):
            return None
        try:
            return cables_motion(motion.robot, motion.task.base, motion.at, angles, self.counted_lengths, sections)
        except UndeterminedError:
            return None

    @cached_array
    def counted_lengths(self) -> Array:
        """Cable lengths (T, c) m at the motor counts of the angles: rounded as drives round them.

        Where mechanics are known, cables are longer than the motors command by what they are stretched.
        """
        robot, held = self.motion.robot, self.motion.held
        counted = robot.lengths_of_counts(robot.motor_counts(self.motion.commanded_lengths))
        return counted if held is None else counted + held.stretch

    @cached_array
    def counted_angles(self) -> Array:
        """Angles (T, n, 2) rad that belong to the rounded lengths; NaN where the cables do not determine them."""
        return self.motion.robot.angles_from_cables(self.counted_lengths, self.motion.angles)

    @cached_array
    def counted_sections(self) -> Array:
        """Section lengths (T, n) m that belong to the rounded lengths; NaN as of `counted_angles`."""
        return self.motion.robot.lengths_from_cables(self.counted_lengths, self.motion.angles)

    @cached_array
    def counted_line(self) -> Array:
        """Ends (T, p+1, 3) m of the chords of the body at these angles."""
        motion = self.motion
        return centre_line_on(motion.task.base, motion.robot, self.counted_angles, motion.at, self.counted_sections)

    @cached_array
    def counted_outline(self) -> Array:
        """Ends (T, c+1, 3) m of the chords of the outline at these angles."""
        motion = self.motion
        if not motion.robot.outline.flat:
            return self.counted_line
        return outline_on(motion.task.base, motion.robot, self.counted_angles, motion.at, self.counted_sections)

    @cached_array
    def rounding(self) -> Array:
        """How far (T, c) m rounding to motor counts moves the points of each chord of the outline at most."""
        moved = apart(self.motion.outline, self.counted_outline)
        return np.maximum(moved[:, :-1], moved[:, 1:])

    @cached_property
    def cables_interpolated(self) -> Certificate | None:
        """What is proven of feed and motor counts that go linearly from step to step; None if nothing is."""
        motion, robot = self.motion, self.motion.robot
        if self.drives is None:
            return None
        clearance = self.still - per_section(robot.outline.sections, self.rounding, np.maximum)
        found = (self.counted_outline, clearance, motion.horizon, motion.task.margin, self.allowance)
        return certify_cables(self._outlined(self.drives), robot, motion.scene, *found)

    @cached_property
    def passing_along_path(self) -> tuple[Passing, ...]:
        """What is proven of `along_path` and each moving obstacle; nothing is where joints may jump."""
        moving = self.gliding if self.motion.task.moving else None
        return self._passing(moving, self.gliding_line) if moving else ()

    @cached_property
    def passing_interpolated(self) -> tuple[Passing, ...]:
        """What is proven of `interpolated` and each moving obstacle."""
        return self._passing(self.linear, self.motion.outline)

    @cached_property
    def passing_cables(self) -> tuple[Passing, ...] | None:
        """What is proven of `cables_interpolated` and each moving obstacle; None where the motion is not determined."""
        if not self.motion.task.moving:
            return ()
        try:
            return None if self.drives is None else self._passing(self.drives, self.counted_outline)
        except UndeterminedError:
            return None

    @cached_property
    def mount(self) -> MountShared:
        """What is known of the mount."""
        return MountShared(self.motion, lambda: self.gliding)

    def _passing(self, moving: Moving, vertices: Array) -> tuple[Passing, ...]:
        motion, task = self.motion, self.motion.task
        rest = (motion.clock, vertices, motion.horizon, task.margin, self.allowance)
        moving = self._outlined(moving)
        return tuple(certify_passing(moving, motion.robot, obstacle, *rest) for obstacle in task.moving)

    def _outlined(self, moving: Moving) -> Moving:
        return outlined(moving, self.motion.robot, self.motion.task.base)

    def _outline_of(self, joints: Array) -> Array:
        return outline(self.motion.task.base, self.motion.robot, joints, self.motion.at)

    def _measured_at(self, vertices: Array) -> Array:
        return section_clearance(self.motion.scene, self.motion.robot, vertices, self.motion.horizon)
