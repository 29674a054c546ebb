"""What the feed moves, how far for every bit of feed, and how fast that may be."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.planning.base_limits import BaseLimits
from hognose.planning.task import Task
from hognose.robot.base import turns

Array = NDArray[np.float64]

#: The part of an acceleration limit that the feed speed alone may use up; what is left is for speeding up and down.
_FOR_SPEED = 0.6
#: Derivatives below this are none.
_NOTHING = 1e-12


@dataclass(frozen=True, eq=False)
class Moved:
    """Quantities that the feed moves, and their limits.

    Attributes
    ----------
    slope, bend : (G, k)
        |dq/ds| and |d²q/ds²| at places of the path.
    fastest, hardest
        Limits of |dq/dt| and of |d²q/dt²|; infinite if there is none.
    """

    slope: Array
    bend: Array
    fastest: float
    hardest: float

    @classmethod
    def along(cls, feeds: Array, values: Array, fastest: float, hardest: float | None) -> Moved:
        """Of values (G, ...) at evenly spaced feeds (G,) m; a slope is the larger one of those beside a place."""
        spacing, values = float(feeds[1] - feeds[0]), values.reshape(len(feeds), -1)
        slope = _beside(np.abs(np.diff(values, axis=0)) / spacing)
        if hardest is None:
            return cls(slope, np.zeros((len(feeds), 1)), fastest, math.inf)
        inner = np.abs(values[2:] - 2 * values[1:-1] + values[:-2]) / spacing**2
        return cls(slope, _extended(inner), fastest, hardest)

    @classmethod
    def through_space(cls, feeds: Array, steps: Array, fastest: float, hardest: float) -> Moved:
        """Of a vector that changes by steps (G-1, 3) from each of evenly spaced feeds (G,) m to the next."""
        spacing = float(feeds[1] - feeds[0])
        bend = np.linalg.norm(np.diff(steps, axis=0), axis=1) / spacing**2
        slope = np.linalg.norm(steps, axis=1) / spacing
        return cls(_beside(slope[:, None]), _extended(bend[:, None]), fastest, hardest)

    @classmethod
    def by_the_base(cls, task: Task, feeds: Array, joints: Array, at: Array) -> tuple[Moved, ...]:
        """The feed, and of a carrier the first joint on its way and the axes of the arm.

        Parameters
        ----------
        task
        feeds : (G,) m
            Evenly spaced.
        joints : (G, n+1, 3) m
        at : (G, k)
            Coordinates of the base.
        """
        limits, none = BaseLimits.of(task), np.zeros((len(feeds), 1))
        feed = cls(none + 1.0, none, limits.speed, limits.acceleration)
        if not task.base.follows:
            return (feed,)
        place = cls.through_space(feeds, np.diff(joints[:, 0], axis=0), limits.speed, limits.acceleration)
        axes = cls.through_space(feeds, turns(task.base, at), limits.turn_speed, limits.turn_acceleration)
        return feed, place, axes

    def speed(self, of_speed: float, of_change: float) -> Array:
        """The largest feed speeds (G,) m/s that leave some acceleration for speeding up and down.

        Within so much of the speed limit, and of the acceleration limit.
        """
        speed = of_speed * self.fastest / np.maximum(self.slope.max(axis=1), _NOTHING)
        square = _FOR_SPEED * (of_change * self.hardest) / np.maximum(self.bend.max(axis=1), _NOTHING)
        return np.minimum(speed, np.sqrt(square))

    def acceleration(self, speed: Array, of_change: float) -> Array:
        """The largest feed accelerations (G,) m/s² at feed speeds (G,) m/s, up or down."""
        if math.isinf(self.hardest):
            return np.full(len(speed), math.inf)
        left = of_change * self.hardest - self.bend * speed[:, None] ** 2
        return (left / np.maximum(self.slope, _NOTHING)).min(axis=1)


def _beside(steps: Array) -> Array:
    """At places (G, k) the larger one of the steps (G-1, k) on both sides."""
    return np.concatenate([steps[:1], np.maximum(steps[1:], steps[:-1]), steps[-1:]])


def _extended(inner: Array) -> Array:
    """At places (G, k) what is known (G-2, k) of all but the first and the last."""
    return np.concatenate([inner[:1], inner, inner[-1:]])
