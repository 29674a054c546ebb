"""What the arm stands on: where its first joint is at a feed, and what of it follows behind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Where a slider points in the frame of the task.
AXIS = (0.0, 0.0, 1.0)


class Base(Protocol):
    """Puts the arm's own frame, in which it lies along +z, into the frame of the task.

    Planning, certificate, steering, routes and pictures ask the base; only a base names an axis.
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

    def aligned(self, points: Array) -> Array:
        """Points (..., 3) m of the task's frame in axes parallel to the arm's own, as `Robot.angles` wants them."""
        ...

    def feed_at(self, point: Array) -> tuple[float, float]:
        """Feed (m) that brings the first joint closest to a point (3,) m of the task, and how far off it is (m)."""
        ...

    def behind(self, low: float, high: float) -> tuple[Array, Array]:
        """Ends (k, 3) m of the chords that all bodies behind the first joint sweep while it is fed from low to high."""
        ...


@dataclass(frozen=True, eq=False)
class Slider:
    """A straight slider along +z of the task's frame.

    Attributes
    ----------
    start : (3,) m
        The first joint at feed 0: the arm's length before the entrance.
    length_behind : m
        Of the mount behind the first joint, as thick as the first link.
    """

    start: Array
    length_behind: float

    @property
    def direction(self) -> Array:
        """Unit vector (3,) of the feed."""
        return np.array(AXIS)

    def T_task_base(self, feed: float) -> Array:
        """See `Base.T_task_base`."""
        pose = np.eye(4)
        pose[:3, 3] = self.start + feed * self.direction
        return pose

    def placed(self, points: Array) -> Array:
        """See `Base.placed`."""
        return points + self.start

    def aligned(self, points: Array) -> Array:
        """See `Base.aligned`: the axes are parallel already."""
        return points

    def feed_at(self, point: Array) -> tuple[float, float]:
        """See `Base.feed_at`."""
        along = point - self.start
        return float(along[2]), float(np.linalg.norm(along[:2]))

    def behind(self, low: float, high: float) -> tuple[Array, Array]:
        """See `Base.behind`: one chord, as the mount only slides along the run."""
        first = self.start - self.direction * (self.length_behind - low)
        return first[None], (self.start + self.direction * high)[None]
