"""What motors and base are told within a plan's control periods, interpolated as the drives do."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.planning import Plan

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SetPoints:
    """Set-points of K steps of the integration, beginning now.

    Attributes
    ----------
    begin, step : s
        On the plan's clock.
    clock : s
        What the clock of moving obstacles says at the beginning.
    lengths, speeds : (K, c) m, (c,) m/s
    bases, base_speeds : (K+1, k), (K, k)
        The last is where the base is to be afterwards.
    sections, section_speeds : (K+1, n) m, (n,) m/s
        How long sections are, likewise; they only change where they extend.
    """

    begin: float
    step: float
    clock: float
    lengths: Array
    speeds: Array
    bases: Array
    base_speeds: Array
    sections: Array
    section_speeds: Array

    @classmethod
    def of(cls, plan: Plan, period: int, longest: float, lag: float) -> SetPoints:
        """Those of a control period, from 1, in steps of at most so many s; the base is late by a lag (s)."""
        begin, end = float(plan.time[period - 1]), float(plan.time[period])
        count = max(1, math.ceil((end - begin) / longest - 1e-9))
        step = (end - begin) / count
        before, after = plan.commanded_lengths[period - 1 : period + 1]
        shares = np.arange(count + 1)[:, None] / count
        short, long = plan.section_lengths[period - 1 : period + 1]
        if lag:
            at, speeds = base_at(plan, np.arange(count + 1, dtype=np.float64) * step + (begin - lag))
        else:
            first, last = plan.at[period - 1 : period + 1]
            at = plan.task.base.settled(first + shares * (last - first))
            speeds = np.broadcast_to((last - first) / (end - begin), at.shape)
        clock = float(plan.clock[period - 1])
        told = before + shares[:-1] * (after - before), (after - before) / (end - begin)
        long_now = short + shares * (long - short), (long - short) / (end - begin)
        return cls(begin, step, clock, *told, at, speeds[:-1], *long_now)

    def held(self, done: int, duration: float) -> SetPoints:
        """All motors hold what they were told last, after so many of these steps, for a duration (s)."""
        count = max(1, round(duration / self.step))
        gone = done * self.step
        return SetPoints(
            self.begin + gone,
            self.step,
            self.clock + gone,
            np.repeat(self.lengths[done - 1 : done], count, axis=0),
            np.zeros_like(self.speeds),
            np.repeat(self.bases[done - 1 : done], count + 1, axis=0),
            np.zeros((count, self.bases.shape[1])),
            np.repeat(self.sections[done - 1 : done], count + 1, axis=0),
            np.zeros_like(self.section_speeds),
        )


def base_at(plan: Plan, times: Array) -> tuple[Array, Array]:
    """Coordinates (m, k) of the base at times (m,) s, and how they change in a second; it rests before and after."""
    row = np.clip(np.searchsorted(plan.time, times, "right") - 1, 0, len(plan.time) - 2)
    spans = plan.time[row + 1] - plan.time[row]
    shares = ((times - plan.time[row]) / spans)[:, None]
    moves = plan.at[row + 1] - plan.at[row]
    speeds = np.where((shares >= 0) & (shares <= 1), moves / spans[:, None], 0.0)
    return plan.task.base.settled(plan.at[row] + np.clip(shares, 0.0, 1.0) * moves), speeds


def planned_at(plan: Plan, time: float) -> tuple[Array, Array]:
    """Angles (n, 2) rad and coordinates (k,) of the base that a plan has at a time (s)."""
    row = int(np.clip(np.searchsorted(plan.time, time, "right") - 1, 0, len(plan.time) - 2))
    share = min(max((time - plan.time[row]) / (plan.time[row + 1] - plan.time[row]), 0.0), 1.0)
    angles, at = ((1.0 - share) * x[row] + share * x[row + 1] for x in (plan.angles, plan.at))
    return angles, plan.task.base.settled(at[None])[0]
