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
        spacing, said = float(feeds[1] - feeds[0]), robot.spec.limits
        moved = [(angles.reshape(len(feeds), -1), math.radians(said.joint_speed_deg_s), _joint_acceleration(robot))]
        moved.append((cable_lengths, said.cable_speed, said.cable_acceleration or math.inf))
        speed = np.full(len(feeds), of_speed * robot.spec.feed.speed)
        slopes = []
        for values, fastest, hardest in moved:
            slope, bend = _largest_derivatives(values, spacing, math.isfinite(hardest))
            slopes.append((slope, bend, of_change * hardest))
            speed = np.minimum(speed, of_speed * fastest / np.maximum(slope.max(axis=1), _NOTHING))
            if bend is not None:
                square = _FOR_SPEED * of_change * hardest / np.maximum(bend.max(axis=1), _NOTHING)
                speed = np.minimum(speed, np.sqrt(square))
        acceleration = np.full(len(feeds), of_change * robot.spec.feed.acceleration_limit)
        for slope, bend, hardest in slopes:
            if bend is not None:
                left = (hardest - bend * speed[:, None] ** 2) / np.maximum(slope, _NOTHING)
                acceleration = np.minimum(acceleration, left.min(axis=1))
        return cls(feeds, speed, acceleration)

    def eroded(self, reach: float) -> FeedLimits:
        """The smallest limits within a reach (m) to either side of every place."""
        places = math.ceil(reach / float(self.feeds[1] - self.feeds[0]))
        return FeedLimits(self.feeds, _smallest_near(self.speed, places), _smallest_near(self.acceleration, places))


def _joint_acceleration(robot: Robot) -> float:
    return math.radians(robot.spec.limits.joint_acceleration_deg_s2)


def _largest_derivatives(values: Array, spacing: float, second: bool) -> tuple[Array, Array | None]:
    """|dq/ds| and, if asked for, |d²q/ds²| (G, k) of values (G, k): the larger of those on both sides of a place."""
    steps = np.abs(np.diff(values, axis=0)) / spacing
    slope = np.concatenate([steps[:1], np.maximum(steps[1:], steps[:-1]), steps[-1:]])
    if not second:
        return slope, None
    bend = np.zeros_like(values)
    bend[1:-1] = np.abs(values[2:] - 2 * values[1:-1] + values[:-2]) / spacing**2
    bend[0], bend[-1] = bend[1], bend[-2]
    return slope, bend


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
