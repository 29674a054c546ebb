"""What criteria need to know of the mount behind the first joint, worked out once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hognose.cached import cached_property
from hognose.planning.certificate import (
    Certificate,
    OneChord,
    Passing,
    certify,
    certify_passing,
    first_joint_motion,
    mount_motion,
)
from hognose.planning.certificate.moving import Moving
from hognose.planning.motion import Motion
from hognose.planning.penetration import clearance_of
from hognose.planning.tolerance.allowance import OnBase


@dataclass(frozen=True, eq=False)
class MountShared:
    """Figures of the mount that follow from a motion.

    Attributes
    ----------
    motion
    joints_gliding
        Makes the motion of joints that glide along the path; None where they may jump.
    """

    motion: Motion
    joints_gliding: Callable[[], Moving | None]

    @cached_property
    def passing(self) -> tuple[Passing, ...]:
        """What is proven of the mount and each moving obstacle; nothing is without a mount.

        The base goes linearly where joints or cables do. Where joints glide, a mount that turns goes another way.
        """
        motion, task, base = self.motion, self.motion.task, self.motion.task.base
        if base.mount is None:
            return ()
        body, found = OneChord(base.mount.radius), []
        for way in filter(None, (self.linear, self.gliding)):
            ends = way.place(way.parameters)[1]
            rest = (motion.clock, ends, motion.horizon, task.margin, self.on_base)
            found += [certify_passing(way, body, obstacle, *rest) for obstacle in task.moving]
        return tuple(found)

    @cached_property
    def on_base(self) -> OnBase | None:
        """What tolerances take of clearances of what is fixed to the base; None without tolerances."""
        budget = self.motion.task.budget
        return None if budget is None else OnBase(budget)

    @cached_property
    def linear(self) -> Moving | None:
        """The motion of the mount while the base's coordinates go linearly from step to step; None without a mount."""
        base = self.motion.task.base
        return None if base.mount is None else mount_motion(first_joint_motion(base, self.motion.at), base)

    @cached_property
    def gliding(self) -> Moving | None:
        """The motion of a mount that turns with the first link while joints glide; None where it is as of the base.

        And of arms with other sections, of which no gliding is judged.
        """
        base, robot = self.motion.task.base, self.motion.robot
        if base.mount is None or not (base.mount.turns and self.motion.follower.glides and robot.straight_links):
            return None
        joints = self.joints_gliding()
        return None if joints is None else mount_motion(joints, base)

    def certified(self, moving: Moving) -> Certificate:
        """What is proven of a motion of the mount past what stands still."""
        motion, mount = self.motion, self.motion.task.base.mount
        body, ends = OneChord(0.0 if mount is None else mount.radius), moving.place(moving.parameters)[1]
        clearance = clearance_of(motion.scene, ends, body.outline.radii, motion.horizon)
        return certify(moving, body, motion.scene, ends, clearance, motion.horizon, motion.task.margin, self.on_base)
