"""Puts what happens in a run into its record, cycle by cycle."""

from __future__ import annotations

import numpy as np

from hognose.drive.clock import Clock
from hognose.drive.executor import Executor
from hognose.drive.record import CycleRow, RecordWriter
from hognose.drive.stream import Cycle


class Recorder:
    """Records the cycles and events of one executor."""

    def __init__(self, writer: RecordWriter, clock: Clock) -> None:
        self._writer, self._clock, self._began = writer, clock, clock.now()
        self.executor: Executor | None = None

    def cycle(self, cycle: Cycle) -> None:
        """Record a cycle; see `Executor.seen`."""
        executor = self.executor
        if executor is None:
            return
        axes, spec = executor.axes, executor.network.spec
        cables = len(spec.drives.nodes)
        counts = cycle.set_point.counts
        per_count = 0.0 if spec.slider is None else 1.0 / spec.slider.counts_per_metre
        has_slider = len(axes) > cables
        self._writer.cycle(
            CycleRow(
                cycle.time - self._began,
                executor.phase.name,
                cycle.set_point.place,
                counts[:cables],
                axes.position[:cables],
                axes.tensions,
                1e-3 * axes.load[:cables],
                axes.following[:cables].astype(np.float64),
                axes.status[:cables].astype(np.uint16),
                per_count * float(counts[cables]) if has_slider else 0.0,
                per_count * float(axes.position[cables]) if has_slider else 0.0,
                cycle.lateness,
            )
        )

    def event(self, kind: str, words: str, axis: int | None = None) -> None:
        """Record an event; see `Executor.said`."""
        executor = self.executor
        node = None if axis is None or executor is None else executor.network.nodes[axis]
        place = None if executor is None else executor.place
        self._writer.event(self._clock.now() - self._began, kind, words, node, place)
