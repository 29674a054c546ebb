"""A whole motion, step by step, and what follows from it."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.cached import cached_array, cached_property, read_only
from hognose.errors import InfeasibleError, InputError
from hognose.following import METHODS, OF_SECTIONS, Follower, body_deviation
from hognose.following.exact import Exact
from hognose.following.sections import ExactSections
from hognose.mechanics import Held, postures
from hognose.path import Path
from hognose.planning.followed import followed, followed_on_base, method_of
from hognose.planning.penetration import clearance_of_all, per_section
from hognose.planning.task import Task
from hognose.robot import Robot
from hognose.robot.base import centre_line, joints_on, lengths_on, outline
from hognose.robot.sections import MixedSections
from hognose.scene import Scene

Array = NDArray[np.float64]

#: Clearances (m) are exact below this and lower bounds at it, unless the margin asks for more.
HORIZON = 0.05


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion from the arm straight at the entrance to the tip on the target, or back, T steps long; not judged yet.

    Its arrays cannot be written to: verdicts hold of the figures that were judged. `dataclasses.replace` makes another
    motion of other figures.

    Attributes
    ----------
    time, feed : (T,) s, (T,) m
    joints : (T, n+1, 3) m
        Joints and tip on the path, in the task's frame.
    angles : (T, n, 2) rad
        α and β of every section: what the arm is commanded.
    cable_lengths : (T, c) m
    motor_counts : (T, c) int
        Of the lengths that are commanded: less than the cables' by the stretch, where mechanics are known.
    clearance : (T, n) m
        Distance of every link's body to the obstacles with the arm at `angles`; at `horizon` a lower bound.
    way_points : (m, 3) m
        Those of the task and those the detour put between them.
    base_pose : (T, 7), optional
        Of a carrier that takes the first joint along: its place, x, y, z in m, and a unit quaternion w, x, y, z.
        A motion on another base may have it, too; nothing is worked out from it there.
    extra
        Columns of its file that Hognose does not know, by name: cells (T,), numbers or text.
    notes
        What a person should know of the file that it comes from, in sentences; files that are made of it keep them.
    method_package
        The package that added the task's following method where it was planned; empty if that is not known, or if the
        method is Hognose's own.
    """

    task: Task
    way_points: Array
    time: Array
    feed: Array
    joints: Array
    angles: Array
    cable_lengths: Array
    motor_counts: NDArray[np.int64]
    clearance: Array
    horizon: float = HORIZON
    base_pose: Array | None = None
    extra: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    method_package: str = ""

    def __post_init__(self) -> None:
        for each in fields(Motion):
            value = getattr(self, each.name)
            if isinstance(value, np.ndarray):
                object.__setattr__(self, each.name, read_only(value))
        extra = {name: read_only(c) if isinstance(c, np.ndarray) else c for name, c in self.extra.items()}
        object.__setattr__(self, "extra", extra)

    def refuse_misshapen(self) -> None:
        """Raise an InputError that names an array of another shape than it must have, with a row for each step."""
        robot, steps = self.robot, np.shape(self.time)[:1]
        if not steps or not steps[0]:
            raise InputError("time: expected one step or more, got none; a plan without steps cannot be judged")
        joints, angles, cables = (robot.sections + 1, 3), (robot.sections, 2), (robot.cables,)
        rows = {"time": (), "feed": (), "joints": joints, "angles": angles, "clearance": (robot.sections,)}
        rows |= {"cable_lengths": cables, "motor_counts": cables, "base_pose": (7,)}
        for name, each in rows.items():
            found = getattr(self, name)
            if found is not None and np.shape(found) != (*steps, *each):
                raise InputError(
                    f"{name}: expected shape {(*steps, *each)}, a row for each step, got {np.shape(found)}"
                )

    @property
    def robot(self) -> Robot:
        """The robot it was made for."""
        return self.task.robot

    @property
    def scene(self) -> Scene:
        """The obstacles."""
        return self.task.scene

    @cached_property
    def path(self) -> Path:
        """The desired path: the base's run and the curve through `way_points`."""
        return self.task.path_through(self.way_points)

    @property
    def retracts(self) -> bool:
        """Whether it leads from the target back to the straight arm, not the other way round."""
        return bool(self.feed[0] > self.feed[-1])

    @property
    def clock(self) -> Array:
        """Times (T,) s at the steps on the clock of moving obstacles, which begins with the insertion."""
        if not self.retracts:
            return self.time
        start = self.task.spec.motion.retraction_start_s
        # An insertion with the same profile takes as long as this.
        return self.time + (float(self.time[-1]) if start is None else start)

    @cached_array
    def at(self) -> Array:
        """Coordinates (T, k) of the base: the feed alone, or the pose of a carrier.

        Where the pose of a carrier is missing, that which its joints need.
        """
        if not self.task.base.follows:
            return self.task.base.coordinates(self.feed, self.joints)
        return self.needed_pose if self.base_pose is None else self.base_pose

    @cached_array
    def needed_pose(self) -> Array:
        """The pose (T, 7) of a carrier that the joints need, or where sections are no links, the following method."""
        base = self.task.base
        if isinstance(self.robot.model, MixedSections):
            with suppress(InfeasibleError):  # joints of a path that cannot be followed are shown all the same
                # Not with `follower`, which may remember: some methods go on from where they last were.
                return followed_on_base(self.task, self.path, self.feed)[1]
        return base.coordinates(self.feed, self.joints)

    @cached_array
    def body(self) -> Array:
        """Joints and tip (T, n+1, 3) m where the commanded angles put them (forward kinematics, eq. 13)."""
        return joints_on(self.task.base, self.robot, self.angles, self.at, self.section_lengths)

    @cached_array
    def section_lengths(self) -> Array:
        """How long (T, n) m every section is: as its joints say if it extends, and else as at rest."""
        return lengths_on(self.task.base, self.robot, self.joints, self.at)

    @cached_array
    def postures(self) -> Array:
        """Commanded angles (T, n, 2) rad, and (T, n, 3) with the lengths of sections that extend, as mechanics ask."""
        return postures(self.robot, self.angles, self.section_lengths)

    @property
    def missing_method(self) -> str | None:
        """The name of the task's following method if it is not installed: then the motion can be shown, but not judged.

        Motions from files may have one.
        """
        method = self.task.spec.motion.method
        return None if method in METHODS or method in OF_SECTIONS else method

    @cached_array
    def centre_line(self) -> Array:
        """Ends (T, p+1, 3) m of the chords of the commanded body."""
        return centre_line(self.task.base, self.robot, self.body, self.at, self.angles)

    @cached_array
    def outline(self) -> Array:
        """Ends (T, c+1, 3) m of the chords of `Robot.outline` with the commanded body: clearances are theirs."""
        if not self.robot.outline.flat:
            return self.centre_line
        return outline(self.task.base, self.robot, self.body, self.at, self.angles)

    @cached_property
    def held(self) -> Held | None:
        """How the cables hold the arm at the commanded angles; None if its mechanics are not known."""
        return self.task.held(self.angles, self.at, self.section_lengths)

    @cached_array
    def commanded_lengths(self) -> Array:
        """Cable lengths (T, c) m of the commanded angles without the stretch; with it, if mechanics are not known."""
        return self.task.commanded_lengths(self.angles, self.at, self.section_lengths)

    def scene_at(self, step: int) -> Scene:
        """All obstacles as they stand at a step."""
        return self.task.scene_at(float(self.clock[step]))

    def clearance_now(self) -> Array:
        """Clearance (T, n) m of every link at `body`, measured anew; at the horizon a lower bound."""
        task = self.task
        return clearance_of_all(self.scene, task.moving, self.robot, self.outline, self.horizon, self.clock)

    @cached_property
    def follower(self) -> Follower:
        """The task's following method on this path; an InputError if it is not installed."""
        return method_of(self.task, self.path)

    @cached_array
    def exact_joints(self) -> Array:
        """Joints (T, n+1, 3) m where exact following of the method's curve puts them at the same feeds.

        Of the path, where the method is not installed, as what it makes of the path is not known then.
        """
        if self.missing_method is not None:
            return followed(self.task, self.path, self.feed, "exact")
        if isinstance(self.follower, Exact | ExactSections):
            return self.joints
        return followed(self.task, self.follower.curve, self.feed, "exact")

    @cached_array
    def tip_error(self) -> Array:
        """Distance (T,) m of the commanded tip from where exact following of the method's curve puts it.

        From the curve itself, where sections are no rigid links: how far along a tip comes then depends on the method.
        """
        if isinstance(self.robot.model, MixedSections):
            return self.follower.curve.distance_to(self.body[:, -1])
        return np.linalg.norm(self.body[:, -1] - self.exact_joints[:, -1], axis=1)

    @cached_array
    def body_deviation(self) -> Array:
        """How far (T, n) m each link leaves the path: the largest distance of points along it to the path."""
        if self.robot.straight_links:
            return body_deviation(self.path, self.body)
        return per_section(self.robot.chord_sections, body_deviation(self.path, self.centre_line), np.maximum)
