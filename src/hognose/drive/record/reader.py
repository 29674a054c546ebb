"""Reading the record of a run, also one that was cut off."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hognose.drive.record import messages
from hognose.drive.record.container import Container, read_container
from hognose.drive.record.messages import CycleRow, Event
from hognose.drive.record.writer import METADATA, NETWORK, PLAN, SCHEMA_VERSION, VERDICT
from hognose.errors import InputError

Array = NDArray[np.float64]
Counts = NDArray[np.int64]


class Image(NamedTuple):
    """A picture of the camera on the tip: time in s since the start, and its bytes."""

    time: float
    jpeg: bytes


@dataclass(frozen=True, eq=False)
class Cycles:
    """All cycles, K of them, as arrays; units as of `CycleRow`."""

    time: Array
    state: tuple[str, ...]
    progress: Array
    commanded: Counts
    measured: Counts
    tensions: Array
    currents: Array
    following: Array
    status: NDArray[np.uint16]
    slider_commanded: Array
    slider_measured: Array
    lateness: Array

    @classmethod
    def of(cls, rows: list[CycleRow], cables: int) -> Cycles:
        """Rows, one below the other."""
        columns = list(zip(*rows, strict=True)) if rows else [()] * len(CycleRow._fields)
        kinds = ("f8", "", "f8", "i8", "i8", "f8", "f8", "f8", "u2", "f8", "f8", "f8")
        wide = ("commanded", "measured", "tensions", "currents", "following", "status")
        made: dict[str, Any] = {}
        for name, kind, values in zip(CycleRow._fields, kinds, columns, strict=True):
            shape = (len(rows), cables) if name in wide else (len(rows),)
            made[name] = np.array(values, kind).reshape(shape) if kind else tuple(values)
        return cls(**made)

    def __len__(self) -> int:
        return len(self.time)

    def row(self, cycle: int) -> CycleRow:
        """One of them; a negative number counts from the end."""
        return CycleRow(*(getattr(self, name)[cycle] for name in CycleRow._fields))


@dataclass(frozen=True, eq=False)
class Record:
    """What happened in a run.

    Attributes
    ----------
    path
    start
        When time 0 was.
    said
        What the record says of itself: version, task, robot, robot_fingerprint, motion_sha256, cables, steps.
    cycles, events, images
        In their order.
    plan_file
        The content of the plan file (Parquet).
    network
        The network file, as JSON.
    finished
        Whether it was closed; if not, the program was killed, or the file was cut.
    lost : bytes
        Behind the last whole message.
    altered
        Whether the file was changed after it was closed.
    """

    path: Path
    start: datetime
    said: Mapping[str, str]
    cycles: Cycles
    events: tuple[Event, ...]
    images: tuple[Image, ...]
    plan_file: bytes
    network: Mapping[str, Any]
    finished: bool
    lost: int
    altered: bool

    @property
    def verdict(self) -> str | None:
        """How the run ended, in a sentence; None if nobody could say."""
        said = [event.text for event in self.events if event.kind == VERDICT]
        return said[-1] if said else None

    @property
    def counts(self) -> Counter[str]:
        """How many events there are of each kind."""
        return Counter(event.kind for event in self.events if event.kind != VERDICT)

    @property
    def remarks(self) -> list[str]:
        """What a person should know of the file, in sentences."""
        told = []
        if not self.finished:
            told.append(
                f"the record was not closed: the program was killed, or the file was cut; {self.lost:,} bytes behind "
                "the last whole message are lost"
            )
        if self.altered:
            told.append("the file was changed after it was closed: its checksum is another one")
        return told


def read_record(file: Path | str) -> Record:
    """The record of a run, as far as its messages are whole.

    Raises
    ------
    InputError
        There is no such file, it is no record, of a newer version, or cut before its first message.
    MissingExtraError
        The package mcap is not installed.
    """
    path = Path(file)
    return record_of(path, read_container(path))


def record_of(path: Path, held: Container) -> Record:
    """The record in a container; errors as of `read_record`."""
    said = next((each.metadata for each in held.metadata if each.name == METADATA), None)
    files = {each.name: each.data for each in held.attachments}
    if said is None or PLAN not in files or NETWORK not in files:
        what = "an MCAP file, but not a record of Hognose" if held.finished else "cut before anything was recorded"
        raise InputError(f"{path}: {what}; expected one that `hognose run` has written")
    if said.get("schema") != str(SCHEMA_VERSION):
        raise InputError(
            f"{path}: written by Hognose {said.get('version')} with record schema {said.get('schema')}; this version "
            f"reads {SCHEMA_VERSION}. Update Hognose."
        )
    try:
        start, cables, network = datetime.fromisoformat(said["start"]), int(said["cables"]), json.loads(files[NETWORK])
        rows, events, images = _decoded(held, start, cables)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise InputError(f"{path}: the record is damaged: {error}. `hognose log --recover` may help.") from None
    return Record(
        path, start, said, Cycles.of(rows, cables), tuple(events), tuple(images), files[PLAN], network,
        held.finished, held.lost, held.altered,
    )  # fmt: skip


def _decoded(held: Container, start: datetime, cables: int) -> tuple[list[CycleRow], list[Event], list[Image]]:
    rows, events, images, zero = [], [], [], round(start.timestamp() * 1e6) * 1000
    for message in held.messages:
        topic = held.channels[message.channel_id].topic
        if topic == "/state":
            row = messages.cycle_row(message.data)
            if any(len(values) != cables for values in row if isinstance(values, np.ndarray)):
                raise ValueError(f"a cycle at {row.time:g} s has not {cables} cables")
            rows.append(row)
        elif topic == "/events":
            events.append(messages.event(message.data))
        elif topic == "/tip_camera":
            stamp, jpeg = messages.image(message.data)
            images.append(Image((stamp - zero) / 1e9, jpeg))
    return rows, events, images
