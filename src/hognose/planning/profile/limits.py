"""How fast the feed may be, and how fast it may change, at every place of a path."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.planning.profile.moved import Moved

Array = NDArray[np.float64]


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
    def of(cls, feeds: Array, moved: Sequence[Moved], of_speed: float = 1, of_change: float = 1) -> FeedLimits:
        """The limits that all that is moved sets.

        Parameters
        ----------
        feeds : (G,) m
            Evenly spaced; at least three.
        moved
            What has limits at these feeds; the feed itself is one of them.
        of_speed, of_change
            The part of all speed limits, and of all acceleration limits, that may be used.
        """
        speed = np.minimum.reduce([each.speed(of_speed, of_change) for each in moved])
        acceleration = np.minimum.reduce([each.acceleration(speed, of_change) for each in moved])
        return cls(feeds, speed, acceleration)

    def eroded(self, reach: float) -> FeedLimits:
        """The smallest limits within a reach (m) to either side of every place."""
        places = math.ceil(reach / float(self.feeds[1] - self.feeds[0]))
        return FeedLimits(self.feeds, _smallest_near(self.speed, places), _smallest_near(self.acceleration, places))


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
