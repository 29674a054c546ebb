"""A run with its record: an executor, of which every cycle and event is written down as it happens."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from hognose.drive.bus import Bus
from hognose.drive.clock import Clock
from hognose.drive.executor import Executor
from hognose.drive.network import Network
from hognose.drive.record import RecordWriter
from hognose.drive.recorder import Recorder
from hognose.drive.senses import Senses, Sensing
from hognose.drive.settings import Settings
from hognose.drive.stream import Cycle
from hognose.planning import Plan

#: Called with the kind of an event, and what happened in words.
Said = Callable[[str, str], None]


class RecordedRun:
    """An executor and its record.

    Attributes
    ----------
    executor
    writer
        Of the record; to be closed by who made the run.
    at_cycle
        What is called with every cycle that is over, in this order; recording it is the first.
    """

    def __init__(
        self,
        plan: Plan,
        network: Network,
        bus: Bus,
        clock: Clock,
        file: Path,
        settings: Settings,
        said: Said = lambda kind, words: None,
        senses: Senses | None = None,
    ) -> None:
        """Nothing is sent yet; the record is there.

        Raises
        ------
        InputError
            The plan or the network cannot be run, or the record cannot be written.
        """
        self._recorder, self._senses = Recorder(clock), senses
        recorder = self._recorder
        self.at_cycle: list[Callable[[Cycle], None]] = [recorder.cycle]

        def tell(kind: str, words: str, axis: int | None) -> None:
            recorder.event(kind, words, axis)
            said(kind, words)

        self.executor = Executor(plan, network, bus, clock, settings, self._seen, tell)
        content = network.spec.model_dump(mode="json", by_alias=True)
        self.writer = RecordWriter(file, plan, content, datetime.now().astimezone(), self.executor.cycle)
        recorder.begin(self.writer, self.executor)
        if senses is not None:
            self.at_cycle.append(Sensing(senses, recorder, self.executor).cycle)

    def _seen(self, cycle: Cycle) -> None:
        for call in self.at_cycle:
            call(cycle)

    def reached(self) -> dict[str, Any]:
        """Where the tip is, if it is seen, and how much was recorded; in SI units, for machines."""
        tip = None if self._senses is None else self._senses.tip()
        body, place = self.executor.plan.body[:, -1], self.executor.place
        low = min(int(place), len(body) - 1)
        planned = body[low] + (place - low) * (body[min(low + 1, len(body) - 1)] - body[low])
        return {
            "tip_m": None if tip is None else tip.tolist(),
            "tip_planned_m": planned.tolist(),
            "tip_off_m": None if tip is None else float(np.linalg.norm(tip - planned)),
            "cycles": self._recorder.cycles,
            "pictures": self._recorder.pictures,
        }
