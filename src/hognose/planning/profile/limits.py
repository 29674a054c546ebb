"""How fast the feed may be, and how fast it may change, at every place of a path."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.robot import Robot

Array = NDArray[np.float64]

#: The part of an acceleration limit that the feed speed alone may use up; what is left is for speeding up and down.
_FOR_SPEED = 0.6
#: Derivatives below this are none.
_NOTHING = 1e-12


@dataclass(frozen=True, eq=False)
class FeedLimits:
    """Limits of the feed at places of a path.

    A joint angle q(s) at feed s moves at q' v and accelerates at q' a + q'' v² (docs/profile.md). Where the feed speed
    is at most `speed` and the feed acceleration at most `acceleration`, up or down, no limit of the robot is exceeded.

    Attributes
    ----------
    feeds : (G,) m
        Evenly spaced, from 0 to where the tip is on the target.
    speed : (G,) m/s
    acceleration : (G,) m/s²
        Above 0.
    """

    feeds: Array
    speed: Array
    acceleration: Array

    @classmethod
    def of(
        cls, robot: Robot, feeds: Array, angles: Array, cable_lengths: Array, of_speed: float = 1, of_change: float = 1
    ) -> FeedLimits:
        """The limits that joints, cables and slider set.

        Parameters
        ----------
        robot
        feeds : (G,) m
            Evenly spaced; at least three.
        angles : (G, n, 2) rad
            At these feeds.
        cable_lengths : (G, c) m
            At these feeds.
        of_speed, of_change
            The part of all speed limits, and of all acceleration limits, that may be used.
        """
        said, axis = robot.spec.limits, robot.spec.feed
        hardest_turn = math.radians(said.joint_acceleration_deg_s2)
        moved = (
            _Moved.along(feeds, angles, math.radians(said.joint_speed_deg_s), hardest_turn, of_speed, of_change),
            _Moved.along(feeds, cable_lengths, said.cable_speed, said.cable_acceleration, of_speed, of_change),
        )
        speed = np.full(len(feeds), of_speed * axis.speed)
        for each in moved:
            speed = np.minimum(speed, each.speed())
        acceleration = np.full(len(feeds), of_change * axis.acceleration_limit)
        for each in moved:
            acceleration = np.minimum(acceleration, each.acceleration(speed))
        return cls(feeds, speed, acceleration)

    def eroded(self, reach: float) -> FeedLimits:
        """The smallest limits within a reach (m) to either side of every place."""
        places = math.ceil(reach / float(self.feeds[1] - self.feeds[0]))
        return FeedLimits(self.feeds, _smallest_near(self.speed, places), _smallest_near(self.acceleration, places))


@dataclass(frozen=True, eq=False)
class _Moved:
    """Quantities that the feed moves, and their limits.

    Attributes
    ----------
    slope, bend : (G, k)
        |dq/ds| and |d²q/ds²|.
    fastest, hardest
        Limits of |dq/dt| and of |d²q/dt²|; the second is infinite if there is none.
    """

    slope: Array
    bend: Array
    fastest: float
    hardest: float

    @classmethod
    def along(
        cls, feeds: Array, values: Array, fastest: float, hardest: float | None, of_speed: float, of_change: float
    ) -> _Moved:
        """Of values (G, ...) at evenly spaced feeds; a slope is the larger one of those on both sides of a place."""
        spacing, values = float(feeds[1] - feeds[0]), values.reshape(len(feeds), -1)
        steps = np.abs(np.diff(values, axis=0)) / spacing
        slope = np.concatenate([steps[:1], np.maximum(steps[1:], steps[:-1]), steps[-1:]])
        if hardest is None:
            return cls(slope, np.zeros((len(feeds), 1)), of_speed * fastest, math.inf)
        inner = np.abs(values[2:] - 2 * values[1:-1] + values[:-2]) / spacing**2
        return cls(slope, np.concatenate([inner[:1], inner, inner[-1:]]), of_speed * fastest, of_change * hardest)

    def speed(self) -> Array:
        """The largest feed speeds (G,) m/s that leave some acceleration for speeding up and down."""
        speed = self.fastest / np.maximum(self.slope.max(axis=1), _NOTHING)
        square = _FOR_SPEED * self.hardest / np.maximum(self.bend.max(axis=1), _NOTHING)
        return np.minimum(speed, np.sqrt(square))

    def acceleration(self, speed: Array) -> Array:
        """The largest feed accelerations (G,) m/s² at feed speeds (G,) m/s, up or down."""
        if math.isinf(self.hardest):
            return np.full(len(speed), math.inf)
        left = self.hardest - self.bend * speed[:, None] ** 2
        return (left / np.maximum(self.slope, _NOTHING)).min(axis=1)


def _smallest_near(values: Array, places: int) -> Array:
    """The smallest of values (G,) within so many places to either side."""
    places = min(places, len(values) - 1)
    reached, found = 0, values
    while reached < places:  # windows of twice the width, until they are wide enough
        more = min(places - reached, max(reached, 1))
        padded = np.pad(found, more, mode="edge")
        found = np.minimum(np.minimum(padded[: len(values)], padded[2 * more :]), found)
        reached += more
    return found
