"""Runs that can be followed, and what their followers get."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from drive_makers import Rig, boards

from hognose.drive.live.address import Address
from hognose.drive.live.followed import followed
from hognose.drive.live.following import Following
from hognose.drive.live.frames import Message
from hognose.drive.live.server import Limits, Live
from hognose.drive.record import CycleRow, Event, RecordWriter
from hognose.drive.record.messages import TOPICS, cycle_message, event_message, joints_message, names_of
from hognose.drive.recorder import Recorder
from hognose.drive.wishes import Wishes

START = 1_795_788_000_000_000_000
#: So long (s) a condition is waited for; it is far more than any needs.
PATIENCE = 60.0
OPENING: dict[str, Any] = {
    "version": "0", "record": "run.mcap", "start_ns": START, "task": "bench", "robot": "arm", "cables": 3, "steps": 100,
    "step_s": 0.15, "cycle_s": 0.03, "motion_sha256": "0", "nodes": [11, 12, 13, 40], "tension_band_N": 20.0,
    "lost_after_s": 0.1, "wants": [], "topics": [{"topic": topic, "schema": each[0]} for topic, each in TOPICS.items()],
}  # fmt: skip


class Watched(Rig):
    """A rig whose run is recorded."""

    def __init__(self):
        self.recorder: Recorder | None = None
        super().__init__(boards())
        self.recorder = Recorder(self.clock)
        self.at_cycle.append(self.recorder.cycle)

    def _said(self, kind, words, axis):
        super()._said(kind, words, axis)
        if self.recorder is not None:
            self.recorder.event(kind, words, axis)

    @contextmanager
    def recorded(self, file: Path, wishes: Wishes, limits: Limits | None = None) -> Iterator[tuple[RecordWriter, Live]]:
        """Recorded and followed."""
        assert self.recorder is not None
        start = datetime.fromtimestamp(START / 1e9, UTC)
        with (
            RecordWriter(file, self.plan, {}, start) as writer,
            followed(writer, self.executor, wishes, limits) as live,
        ):
            self.recorder.begin(writer, self.executor)
            yield writer, live


class Collector:
    """Reads all that a follower gets, in a thread, until the run is over."""

    def __init__(self, following: Following):
        self.following, self.found = following, []
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self):
        while not (self.following.ended or self.following.lost):
            self.found += self.following.take(1.0)
        self.following.close()

    def all(self) -> list[Message | dict[str, Any]]:
        """All, once the run is over."""
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive()
        return self.found


def address(live: Live, folder: Path) -> Address:
    """Where a server is followed, as the file beside a record would say it."""
    return Address(live.port, live.token, 1, folder / "run.mcap")


def until(holds: Callable[[], object]) -> None:
    """Wait for a condition."""
    end = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < end, "it does not come"
        time.sleep(0.002)


def row(number: int, state: str = "RUN", cables: int = 3) -> CycleRow:
    """A cycle at 0.03 s times its number, a fifth of a step farther each."""
    tensions, errors = np.arange(40.0, 40.0 + cables), np.zeros(cables)
    errors[1] = -7.0
    whole = np.arange(cables) + number
    return CycleRow(
        0.03 * number, state, number / 5, whole, whole, tensions, tensions, errors, np.full(cables, 0x1637, np.uint16),
        0.1, 0.1001, 4e-4,
    )  # fmt: skip


def put_cycle(live: Live, number: int, cables: int = 3) -> None:
    """A cycle with all its messages."""
    stamp, names = START + 30_000_000 * number, names_of([f"cable_{k}" for k in range(cables)])
    live.take("/state", stamp, cycle_message(stamp, row(number, cables=cables)))
    for topic in ("/commanded", "/measured"):
        live.take(topic, stamp, joints_message(stamp, names, np.zeros(cables), np.zeros(cables)))


def put_event(live: Live, time: float, kind: str, text: str) -> None:
    """An event."""
    stamp = START + round(1e9 * time)
    live.take("/events", stamp, event_message(stamp, Event(time, kind, text, 12, 2.0)))
