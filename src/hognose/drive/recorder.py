"""Puts what happens in a run into its record, cycle by cycle."""

from __future__ import annotations

import math

import numpy as np

from hognose.drive.clock import Clock
from hognose.drive.executor import Executor
from hognose.drive.record import CycleRow, RecordWriter
from hognose.drive.stream import Cycle


class Recorder:
    """Records the cycles and events of one executor.

    Attributes
    ----------
    cycles, pictures
        How many were recorded.
    """

    def __init__(self, clock: Clock) -> None:
        """Nothing is recorded before `begin`."""
        self._clock, self._began = clock, clock.now()
        self._writer: RecordWriter | None = None
        self._executor: Executor | None = None
        self._told = False
        self.cycles = self.pictures = 0

    def begin(self, writer: RecordWriter, executor: Executor) -> None:
        """Record from now on."""
        self._writer, self._executor, self._began = writer, executor, self._clock.now()

    def cycle(self, cycle: Cycle) -> None:
        """Record a cycle; see `Executor.seen`."""
        executor, writer = self._executor, self._writer
        if executor is None or writer is None:
            return
        if writer.fault is not None and not self._told:
            # What moves without a record is not known afterwards; back it may go, and followers see it.
            self._told = True
            executor.refuse_to_go_on(writer.fault)
        if writer.fault is not None:
            executor.obstructed = executor.obstructed or writer.fault
        self.cycles += writer.fault is None
        axes, spec = executor.axes, executor.network.spec
        cables = len(spec.drives.nodes)
        zeros = executor.network.zeros  # the record has the plan's counts, so that it can be compared with it
        counts, measured = cycle.set_point.counts - zeros, axes.position - zeros
        per_count = math.nan if spec.slider is None else 1.0 / spec.slider.counts_per_metre
        has_slider, in_milliamperes = len(axes) > cables, spec.drives.kind == "epos2"
        writer.cycle(
            CycleRow(
                cycle.time - self._began,
                executor.phase.name,
                cycle.set_point.place,
                counts[:cables],
                measured[:cables],
                axes.tensions,
                1e-3 * axes.load[:cables] if in_milliamperes else np.full(cables, math.nan),
                axes.following[:cables].astype(np.float64),
                axes.status[:cables].astype(np.uint16),
                per_count * float(counts[cables]) if has_slider else math.nan,
                per_count * float(measured[cables]) if has_slider else math.nan,
                cycle.lateness,
            )
        )

    def image(self, time: float, jpeg: bytes) -> None:
        """Record a picture that was taken at a time (s) of the clock."""
        if self._writer is not None:
            self.pictures += self._writer.fault is None
            self._writer.image(max(0.0, time - self._began), jpeg)

    def event(self, kind: str, words: str, axis: int | None = None) -> None:
        """Record an event; see `Executor.said`."""
        executor, writer = self._executor, self._writer
        if executor is None or writer is None:
            return
        node = None if axis is None else executor.network.nodes[axis]
        writer.event(self._clock.now() - self._began, kind, words, node, executor.place)
