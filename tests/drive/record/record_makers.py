"""Records of a run through the beginning of a plan, with figures that are hard to mistake."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

import hognose
from hognose.drive.record import CycleRow, RecordWriter

START = datetime(2026, 11, 27, 14, 0, 0, 123457, UTC)
NETWORK = {"name": "bench", "cycle_s": 0.05, "nodes": [1, 2, 3]}


def row_at(plan: hognose.Plan, time: float, state: str, place: float, seed: int) -> CycleRow:
    """A cycle that commands what the plan says, with drawn measurements."""
    drawn, cables, low = np.random.default_rng(seed), plan.robot.cables, int(place)
    share, high = place - low, min(low + 1, len(plan.time) - 1)
    counts = np.rint(plan.motor_counts[low] * (1 - share) + plan.motor_counts[high] * share).astype(np.int64)
    feed = plan.feed[low] * (1 - share) + plan.feed[high] * share
    return CycleRow(
        time, state, place, counts, counts - drawn.integers(0, 9, cables), 40 + drawn.normal(size=cables),
        drawn.normal(size=cables), drawn.integers(-90, 90, cables).astype(float),
        drawn.integers(0, 2**16, cables).astype(np.uint16), float(feed), float(feed) - 1e-5, drawn.uniform(0, 1e-3),
    )  # fmt: skip


@dataclass
class Made:
    """A record, what was written into it, and the size of the file after each call."""

    file: Path
    rows: list[CycleRow] = field(default_factory=list)
    sizes: list[int] = field(default_factory=list)


def write(plan: hognose.Plan, file: Path, cycles: int = 40, verdict: str | None = "held at step 6.6") -> Made:
    """A record with some cycles at rest and then a run, four cycles a step."""
    made = Made(file)
    with RecordWriter(file, plan, NETWORK, START) as writer:
        made.sizes.append(file.stat().st_size)
        for k in range(cycles):
            state, place = ("HOLD", 0.0) if k < 10 else ("RUN", (k - 10) / 4)
            made.rows.append(row_at(plan, 0.05 * k, state, place, k))
            writer.cycle(made.rows[-1])
            made.sizes.append(file.stat().st_size)
        writer.image(1.5, b"\xff\xd8 not quite a JPEG \xff\xd9")
        writer.event(1.75, "fault", "cable 7 pulls 31 N more than planned", node=7, step=6.25)
        writer.event(1.8, "note", "märchenhaft")
        if verdict is not None:
            writer.close(verdict)
    return made


def assert_same_row(row: CycleRow, expected: CycleRow) -> None:
    """Bit for bit."""
    for name, value, other in zip(CycleRow._fields, row, expected, strict=True):
        if isinstance(other, np.ndarray):
            assert np.asarray(value).dtype == other.dtype, name
            assert np.asarray(value).tobytes() == other.tobytes(), name
        else:
            assert value == other, name
