"""Set-points of all axes, cycle after cycle: along a plan, or straight to where a plan begins."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from hognose.drive.network import Network
from hognose.drive.progress import Progress, interpolated
from hognose.planning import Plan

Array = NDArray[np.float64]
Counts = NDArray[np.int64]


class SetPoint(NamedTuple):
    """Where all axes are to be, and where along the plan that is (steps)."""

    counts: Counts
    place: float


class Motion(Protocol):
    """Gives set-points until it ends."""

    def next(self) -> SetPoint | None:
        """The set-point of the next cycle; None at the end."""
        ...

    def stop(self) -> None:
        """Come to rest soon, on the way."""
        ...


def counts_of(plan: Plan, network: Network) -> Counts:
    """The counts (T, A) that the drives of all axes are to say at the steps of a plan; see `Network.counts_of`."""
    return network.counts_of(plan)


class AlongPlan:
    """Along a plan, at a rate that may be changed on the way."""

    def __init__(self, counts: Counts, progress: Progress, rate: float, until: float) -> None:
        self._counts, self.progress = counts, progress
        self.rate, self.until, self._stops = rate, until, False

    def next(self) -> SetPoint | None:
        """See `Motion.next`."""
        if self.progress.rests and (self._stops or self.progress.place == self.until):
            return None
        self.progress = self.progress.next(0.0 if self._stops else self.rate, self.until)
        place = self.progress.place
        return SetPoint(interpolated(self._counts, place), place)

    def stop(self) -> None:
        """See `Motion.stop`."""
        self._stops = True


@dataclass
class Straight:
    """Straight in the counts of all axes from one place to another, gently.

    Attributes
    ----------
    start, end : (A,) counts
    cycles
        How many cycles it takes.
    place
        Along the plan (steps), of its end.
    """

    start: Counts
    end: Counts
    cycles: int
    place: float
    done: int = 0

    def next(self) -> SetPoint | None:
        """See `Motion.next`."""
        if self.done >= self.cycles:
            return None
        self.done += 1
        share = 0.5 - 0.5 * math.cos(math.pi * self.done / self.cycles)
        between = np.rint(self.start + share * (self.end - self.start)).astype(np.int64)
        return SetPoint(self.end if self.done == self.cycles else between, self.place)

    def stop(self) -> None:
        """See `Motion.stop`; it is short, and ends where it is."""
        self.done = self.cycles


def nearest_place(counts: Counts, measured: Counts) -> tuple[float, Counts]:
    """The place (steps) on a plan's counts (T, A) closest to measured ones (A,), and how far off (A,) these are.

    Closest by the sum of squares over all axes, each by its own travel in the plan.
    """
    travel = np.maximum(np.ptp(counts, axis=0), 1).astype(np.float64)
    points, at = counts / travel, measured / travel
    if len(counts) == 1:
        return 0.0, measured - counts[0]
    steps = np.diff(points, axis=0)
    squares = np.maximum((steps**2).sum(axis=1), 1e-300)
    share = np.clip(((at - points[:-1]) * steps).sum(axis=1) / squares, 0.0, 1.0)
    away = ((points[:-1] + share[:, None] * steps - at) ** 2).sum(axis=1)
    step = int(np.argmin(away))
    place = step + float(share[step])
    return place, measured - interpolated(counts, place)
