"""Where along a plan the set-points are: all axes together, forwards or back, at a rate that changes gently.

A plan is a polyline in the space of all motor counts, with a corner at every step. Set-points stay on it whatever the
rate is: each corner is met exactly, so that every drive gets every count of the plan, in order. At the plan's own rate
a step is divided into equal cycles. While the rate changes, a cycle ends at a corner rather than go past it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError

Array = NDArray[np.float64]

#: Parts of a step that rounding leaves; no cycle is so short.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Progress:
    """A place along a plan, in steps, and how fast it changes.

    Attributes
    ----------
    last
        The last step of the plan, T-1.
    cycles
        How many cycles a step takes at the plan's own rate.
    ramp
        In how many cycles the rate goes from 0 to 1.
    place
        From 0 to `last`.
    rate
        As a share of the plan's own; below 0 it goes back.
    """

    last: int
    cycles: int
    ramp: int
    place: float = 0.0
    rate: float = 0.0

    @property
    def rests(self) -> bool:
        """Whether the set-points stay where they are."""
        return self.rate == 0.0

    def next(self, wanted: float, until: float) -> Progress:
        """The progress after a cycle.

        Parameters
        ----------
        wanted
            The rate to go to, from -1 to 1. Towards `until` it is lowered in time to rest there.
        until
            The place, in steps, that is not passed.
        """
        change = 1.0 / self.ramp
        target = wanted if (until - self.place) * wanted > 0 else 0.0
        target = math.copysign(min(abs(target), self._braking(abs(until - self.place))), target)
        rate = self.rate + min(max(target - self.rate, -change), change)
        if rate * self.rate < 0 or abs(rate) < _ROUNDING:  # it rests for a cycle before it turns round
            return replace(self, rate=0.0)
        end = until if (until - self.place) * rate > 0 else float(self.last if rate > 0 else 0)
        if abs(end - self.place) < _ROUNDING:
            return replace(self, place=end, rate=0.0)
        return replace(self, place=self._moved(rate, end), rate=rate)

    def _braking(self, way: float) -> float:
        """The highest rate from which it still comes to rest within a way (steps), one change of the rate a cycle."""
        change = 1.0 / self.ramp
        # k cycles that slow down from rate k·change go change·k(k+1)/2 / cycles.
        k = (math.sqrt(1.0 + 8.0 * way * self.cycles / change) - 1.0) / 2.0
        return max(k * change, change)

    def _moved(self, rate: float, end: float) -> float:
        """The place after a cycle at a rate: on the way to the next corner or the end, or on it."""
        ahead = rate > 0
        corner = math.floor(self.place + _ROUNDING) + 1 if ahead else math.ceil(self.place - _ROUNDING) - 1
        end = min(corner, end) if ahead else max(corner, end)
        left, step = abs(end - self.place), abs(rate) / self.cycles
        count = max(1, math.ceil(left / step - _ROUNDING))  # equal cycles up to the corner
        if count == 1:
            return float(end)
        return self.place + (end - self.place) / count


def interpolated(counts: NDArray[np.int64], place: float) -> NDArray[np.int64]:
    """Whole counts (A,) at a place along a plan's counts (T, A), linear between its steps; exactly its own at a step.

    Raises
    ------
    InputError
        The place is not on the plan.
    """
    last = len(counts) - 1
    if not 0.0 <= place <= last:
        raise InputError(f"place: {place:g} is not on the plan, which goes from step 0 to {last}")
    low = min(int(place), max(last - 1, 0))
    high = min(low + 1, last)
    share = place - low
    return np.rint(counts[low] + share * (counts[high] - counts[low])).astype(np.int64)
