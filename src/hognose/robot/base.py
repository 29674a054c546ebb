"""What the arm stands on: where its first joint is at a feed, and what of it follows behind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hognose.robot.robot import Robot

Array = NDArray[np.float64]

#: How the arm lies at rest, in its own frame.
FORWARD = (0.0, 0.0, 1.0)


@runtime_checkable
class Base(Protocol):
    """Puts the arm's own frame, in which it lies along +z, into the frame of the task.

    Planning, certificate, steering, routes and pictures ask the base; nothing else names an axis.
    """

    @property
    def start(self) -> Array:
        """Position (3,) m of the first joint at feed 0, in the frame of the task."""
        ...

    @property
    def direction(self) -> Array:
        """Unit vector (3,) along which the path begins, in the frame of the task."""
        ...

    def T_task_base(self, feed: float) -> Array:
        """Pose (4, 4) of the first joint at a feed (m); the straight arm lies along its +z."""
        ...

    def placed(self, points: Array) -> Array:
        """Points (..., 3) m of the arm's own frame, such as `Robot.joint_positions` gives, in the task's."""
        ...

    def turned(self, vectors: Array) -> Array:
        """Vectors (..., 3) of the arm's own axes in those of the task."""
        ...

    def aligned(self, vectors: Array) -> Array:
        """Vectors (..., 3) of the task's axes in the arm's own, as `Robot.angles` wants them: undoes `turned`."""
        ...

    def feed_at(self, point: Array) -> tuple[float, float]:
        """Feed (m) that brings the first joint closest to a point (3,) m of the task, and how far off it is (m)."""
        ...

    def behind(self, low: float, high: float) -> tuple[Array, Array, Array]:
        """Ends (k, 3), (k, 3) and radii (k,) m of what the body behind the first joint sweeps between two feeds (m)."""
        ...


@dataclass(frozen=True, eq=False)
class Slider:
    """A straight slider, on which the arm points the way it is fed.

    Attributes
    ----------
    start : (3,) m
        The first joint at feed 0.
    length_behind, radius_behind : m
        Of the mount behind the first joint.
    R_task_base : (3, 3), optional
        A rotation, whose third column is the direction of the feed; unless given, the arm's axes are the task's.
    """

    start: Array
    length_behind: float
    radius_behind: float
    R_task_base: Array | None = None

    @classmethod
    def before(cls, entrance: Array, robot: Robot, R_task_base: Array | None = None) -> Slider:
        """The slider on which, at feed 0, the straight arm has its nose at the entrance (3,) m.

        The mount behind the first joint is as thick as the first link.
        """
        along = np.array(FORWARD) if R_task_base is None else R_task_base[:, 2]
        return cls(entrance - robot.length * along, robot.spec.base_length, float(robot.body_radii[0]), R_task_base)

    @property
    def direction(self) -> Array:
        """See `Base.direction`."""
        return self.turned(np.array(FORWARD))

    def T_task_base(self, feed: float) -> Array:
        """See `Base.T_task_base`."""
        pose = np.eye(4)
        pose[:3, :3] = self.turned(np.eye(3)).T
        pose[:3, 3] = self.start + feed * self.direction
        return pose

    def placed(self, points: Array) -> Array:
        """See `Base.placed`."""
        return self.turned(points) + self.start

    def turned(self, vectors: Array) -> Array:
        """See `Base.turned`."""
        return vectors if self.R_task_base is None else vectors @ self.R_task_base.T

    def aligned(self, vectors: Array) -> Array:
        """See `Base.aligned`."""
        return vectors if self.R_task_base is None else vectors @ self.R_task_base

    def feed_at(self, point: Array) -> tuple[float, float]:
        """See `Base.feed_at`."""
        along = self.aligned(point - self.start)
        return float(along[2]), float(np.linalg.norm(along[:2]))

    def behind(self, low: float, high: float) -> tuple[Array, Array, Array]:
        """See `Base.behind`: one piece, as the mount only slides along the run."""
        first = self.start - self.direction * (self.length_behind - low)
        return first[None], (self.start + self.direction * high)[None], np.array([self.radius_behind])


def centre_line(robot: Robot, base: Base, joints: Array) -> Array:
    """Ends (..., p+1, 3) m of the chords of a body whose joints (..., n+1, 3) m are given in the frame of the task."""
    return base.turned(robot.model.vertices(base.aligned(joints)))
