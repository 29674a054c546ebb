"""Bringing all axes slowly to where a plan is: what is too tight gives way, then slack is taken up."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.drive.axes import Axes
from hognose.drive.motions import SetPoint, Straight
from hognose.drive.stream import Stream
from hognose.drive.watch import Stop, Trouble, Watch

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

#: How fast cables are brought there: this share of what the plan does at most.
_SLOWLY = 0.25
#: Every stage takes so many cycles at least.
_FEWEST = 10


class Approach:
    """Brings axes to counts (A,).

    Parameters
    ----------
    axes
    stream
    cycle : s
    counts : (T, A)
        Of the plan.
    cycles
        How many cycles a step of the plan takes.
    """

    def __init__(self, axes: Axes, stream: Stream, cycle: float, counts: Counts, cycles: int) -> None:
        self._axes, self._stream, self._cycle = axes, stream, cycle
        travel = np.abs(axes.network.travel_per_count)
        fastest, cables = travel * np.abs(np.diff(counts, axis=0)).max(axis=0) / cycles, axes.network.robot.cables
        fastest[:cables] = fastest[:cables].max()  # each may go as fast as any does: some hardly move in a plan
        self._fastest = np.maximum(_SLOWLY * fastest / travel, 1.0)
        self._refused = ""
        self._motion: Straight | None = None

    def off(self, end: Counts) -> Array:
        """How far (m) every axis is from counts (A,); above zero a cable is to be pulled in."""
        return (self._axes.position - end).astype(np.float64) * self._axes.network.travel_per_count

    def go(self, end: Counts, place: float, planned: Array | None) -> Trouble | None:
        """Go there; what went wrong on the way, or None.

        Cables within their band go all together. If one is not, all go section by section, and none may come to pull
        more than is planned and its band.

        Parameters
        ----------
        end : (A,)
        place
            Along the plan (steps), which that is.
        planned : (c,) N
            What cables are to pull there; None where that is not known.
        """
        self._refused, watch = "", Watch(self._axes, self._cycle, only_above=True)
        together = planned is None or not watch.is_out(planned)
        for stage in [end] if together else self.stages(end):
            if planned is not None:
                watch.forgive(planned)
            start = SetPoint(self._axes.position.copy(), place)
            self._motion = Straight(start.counts, stage, self._cycles_to(stage), place)
            trouble = self._stream.go(self._motion, start, watch, lambda place: planned).trouble
            if self._refused:
                trouble = trouble or Trouble(Stop.ALONG_PATH, None, self._refused)
            if trouble is not None:
                return trouble
        return None

    def refuse_to_go_on(self, why: str) -> None:
        """Come to rest, and say why."""
        self._refused = self._refused or why
        if self._motion is not None:
            self._motion.stop()

    def stages(self, end: Counts) -> list[Counts]:
        """Where all axes (A,) are after each stage on the way to counts (A,): the last one is there.

        First the base goes, and what is to be paid out; then cables are pulled in, section by section from the base.
        """
        sections = self._axes.network.robot.cable_sections
        order = np.full(len(end), -1)
        order[: len(sections)] = np.where(self.off(end)[: len(sections)] > 0.0, sections, -1)
        now, found = self._axes.position.copy(), []
        for stage in np.unique(order[now != end]):
            now = np.where(order == stage, end, now)
            found.append(now)
        return found or [end]

    def duration(self, end: Counts) -> float:
        """How long (s) it takes to counts (A,) if all go together."""
        return self._cycle * self._cycles_to(end)

    def _cycles_to(self, end: Counts) -> int:
        return max(_FEWEST, math.ceil(float((np.abs(self._axes.position - end) / self._fastest).max())))
