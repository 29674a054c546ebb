"""When the arm is fed how far: the set-points of a motion in feed and time, a step and a control period apart."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Steps of a way are counted to so many parts; what is over goes with the last one.
COUNTED_TO = 1e-9
#: More steps than this are not counted.
_MOST_STEPS = 1e15


@dataclass(frozen=True)
class SetPoints:
    """Feeds and times of a motion.

    Attributes
    ----------
    feed : (T,) m
    time : (T,) s
    """

    feed: Array
    time: Array

    def with_short_end(self) -> SetPoints:
        """The same feeds, but the last step, if it is shorter, takes its part of a period: the speed stays the same."""
        time = self.time.copy()
        if len(time) > 2:
            (step, rest), period = np.diff(self.feed[-3:]).tolist(), float(time[-1] - time[-2])
            time[-1] = time[-2] + part_of_period(rest, step) * period
        return SetPoints(self.feed, time)

    def backwards(self) -> SetPoints:
        """The same way back, in the same time; the feeds are the same, bit for bit."""
        return SetPoints(np.ascontiguousarray(self.feed[::-1]), self.time[-1] - self.time[::-1])


def steps_of(length: float, step: float) -> int:
    """How many steps a way takes that is `length` m long: each `step` m, and the last what is left."""
    return max(1, math.ceil(min(length / step * (1 - COUNTED_TO), _MOST_STEPS)))


def steady(rows: int, step: float, period: float) -> SetPoints:
    """So many set-points, from 0 on `step` m and `period` s apart."""
    return SetPoints(step * np.arange(rows, dtype=np.float64), period * np.arange(rows, dtype=np.float64))


def set_points(length: float, step: float, period: float) -> SetPoints:
    """Set-points from feed 0 to `length` m, `step` m and `period` s apart; the last step takes what is left."""
    made = steady(steps_of(length, step) + 1, step, period)
    made.feed[-1] = length
    return made


def part_of_period(rest: float, step: float) -> float:
    """The part of a period that the last step of `rest` m takes at the speed of the others."""
    return min(rest / step, 1.0)


def is_last_step(left: float, length: float, step: float, tolerance: float) -> bool:
    """Whether the last step (m) of a way can be `left`: some of it, but no more than a step and what is over."""
    return bool(0 < left <= step + tolerance + 2 * COUNTED_TO * length)
