"""Writing the record of a run while it goes on."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from hognose.drive.record import messages
from hognose.drive.record.messages import CycleRow, Event
from hognose.drive.record.record_file import RecordFile, refuse_full_disk
from hognose.errors import InputError, MissingExtraError
from hognose.planning import Plan
from hognose.planning.columns import LABELS
from hognose.planning.motion import Motion
from hognose.planning.plan_file import to_parquet
from hognose.version import __version__

if TYPE_CHECKING:
    from foxglove import Channel, Context

#: Version of what a record holds; newer ones are refused.
SCHEMA_VERSION = 1
#: The entry of the metadata that says whose record it is, and the attachments beside it.
METADATA, PLAN, NETWORK = "hognose", "plan.parquet", "network.json"
#: The event that ends a record that was closed; its text is the verdict.
VERDICT = "verdict"
#: Room is asked for so many times what the plan takes, and this many seconds: people pause and look.
_TIMES, _PAUSES = 3.0, 600.0
#: What the container adds to each message, at most (bytes).
_FRAME = 31


def motion_digest(plan: Motion) -> str:
    """SHA-256 over times, feeds and motor counts of a plan: what drives are told."""
    return motion_digest_of(plan.time, plan.feed, plan.motor_counts)


def motion_digest_of(time: ArrayLike, feed: ArrayLike, counts: ArrayLike) -> str:
    """The same of times (T,) s, feeds (T,) m and motor counts (T, A)."""
    found = hashlib.sha256()
    for values, kind in ((time, "<f8"), (feed, "<f8"), (counts, "<i8")):
        found.update(np.ascontiguousarray(values, kind).tobytes())
    return found.hexdigest()


def cycle_bytes(cables: int) -> int:
    """How many bytes a cycle takes in a record, about."""
    joints = messages.names_of([f"cable_{number:02d}" for number in range(1, cables + 2)])
    whole, zero = np.zeros(cables, np.int64), np.zeros(cables)
    row = CycleRow(0.0, "PREFILL", 0.0, whole, whole, zero, zero, zero, whole.astype(np.uint16), 0.0, 0.0, 0.0)
    states = (messages.joints_message(0, joints, np.zeros(cables + 1), np.zeros(n)) for n in (0, cables + 1))
    return 3 * _FRAME + len(messages.cycle_message(0, row)) + sum(map(len, states))


class RecordWriter:
    """A record (MCAP) that holds all it was given when a call returns, also if the program is killed then.

    Topics and messages are those of `hognose.drive.record.messages`. The plan and the network are inside. Written by
    foxglove-sdk without chunks, so that there is nothing in memory that could be lost; no more than one thread may use
    it at a time. After a failure, as of a full disk, nothing more is recorded, and `fault` says why.

    Parameters
    ----------
    file
        Made anew; never written over.
    plan
        What is run; good or not.
    network
        The network file, as JSON can hold it.
    start
        When time 0 was; without a time zone it is local.
    cycle_s
        How often there will be a cycle, to see beforehand whether there is room on the disk.

    Raises
    ------
    InputError
        The file is there already or cannot be written, or there is too little room.
    MissingExtraError
        foxglove-sdk is not installed.
    """

    def __init__(
        self, file: Path | str, plan: Plan, network: dict[str, Any], start: datetime, cycle_s: float = 0.02
    ) -> None:
        sdk = _sdk()
        robot, held = plan.robot, to_parquet(plan, plan.checks)
        cycles = (_TIMES * float(plan.time[-1]) + _PAUSES) / cycle_s
        refuse_full_disk(Path(file), len(held) + int(cycles * cycle_bytes(robot.cables)))
        self._start = self._logged = round(start.timestamp() * 1e6) * 1000
        self._names = messages.names_of([*(f"cable_{each}" for each in LABELS["cable"](robot)), "slider"])
        self._travel = np.asarray(robot.travel_per_count, np.float64)
        self._cables, self._open, self._last = robot.cables, True, 0.0
        network_text = json.dumps(network, default=str).encode()
        self._file = RecordFile(Path(file))
        #: Called with each message as it is recorded: topic, log time (ns since 1970), content. Also after a failure.
        self.also: Callable[[str, int, bytes], None] | None = None
        #: Of foxglove-sdk: a live server that is started in it sends what is recorded.
        self.context: Context = sdk.Context()
        options = sdk.mcap.MCAPWriteOptions(compression=None, use_chunks=False, profile="ros2")
        self._writer = sdk.open_mcap(self._file, writer_options=options, context=self.context)
        self._channels = {topic: self._channel(sdk, topic) for topic in messages.TOPICS}
        said = {
            "schema": str(SCHEMA_VERSION),
            "version": __version__,
            "start": start.astimezone(UTC).isoformat(),
            "task": plan.task.name,
            "robot": robot.name,
            "robot_fingerprint": robot.fingerprint,
            "motion_sha256": motion_digest(plan),
            "cables": str(robot.cables),
            "steps": str(len(plan.time) - 1),
        }
        self._writer.write_metadata(METADATA, said)
        self._attach(PLAN, "application/vnd.apache.parquet", held)
        self._attach(NETWORK, "application/json", network_text)
        self._file.flush()
        if self.fault is not None:
            self.close(None)
            raise InputError(self.fault)

    @property
    def path(self) -> Path:
        """The file."""
        return self._file.path

    @property
    def start(self) -> int:
        """When time 0 was, in ns since 1970."""
        return self._start

    @property
    def fault(self) -> str | None:
        """Why nothing is recorded any more, in a sentence; None as long as all is well."""
        return self._file.fault

    def cycle(self, row: CycleRow) -> None:
        """Record a cycle; a ValueError if arrays are not (A,)."""
        for name in ("commanded", "measured", "tensions", "currents", "following", "status"):
            if np.shape(getattr(row, name)) != (self._cables,):
                raise ValueError(f"{name}: expected shape ({self._cables},), got {np.shape(getattr(row, name))}")
        if not self._open:
            return
        stamp = self._stamp(row.time)
        self._log("/state", stamp, messages.cycle_message(stamp, row))
        for topic, counts, slider, efforts in (
            ("/commanded", row.commanded, row.slider_commanded, ()),
            ("/measured", row.measured, row.slider_measured, [*row.tensions, np.nan]),
        ):
            positions = np.append(counts * self._travel, slider)
            self._log(topic, stamp, messages.joints_message(stamp, self._names, positions, np.asarray(efforts)))
        self._writer.flush()

    def event(self, time: float, kind: str, text: str, node: int | None = None, step: float | None = None) -> None:
        """Record that something happened; parameters as of `Event`."""
        if self._open:
            stamp = self._stamp(time)
            self._log("/events", stamp, messages.event_message(stamp, Event(time, kind, text, node, step)))
            self._writer.flush()

    def image(self, time: float, jpeg: bytes) -> None:
        """Record a picture of the camera on the tip, `time` in s."""
        if self._open:
            stamp = self._stamp(time)
            self._log("/tip_camera", stamp, messages.image_message(stamp, jpeg))
            self._writer.flush()

    def close(self, verdict: str | None) -> None:
        """End the record with a verdict, a sentence; None leaves it without one. Does nothing the second time."""
        if not self._open:
            return
        if verdict is not None:
            self.event(self._last, VERDICT, verdict)
        self._open = False
        self._writer.close()
        self._file.flush()
        self._file.close()
        for channel in self._channels.values():
            channel.close()

    def __enter__(self) -> Self:
        """Itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it, without a verdict if that was not done before."""
        self.close(None)

    def _stamp(self, time: float) -> int:
        self._last = max(self._last, time)
        return self._start + round(1e9 * time)

    def _log(self, topic: str, stamp: int, message: bytes) -> None:
        # Readers want a file in the order of time. A picture may be older than what is recorded: its header says that.
        self._logged = max(self._logged, stamp)
        self._channels[topic].log(message, log_time=self._logged)
        if self.also is not None:
            self.also(topic, self._logged, message)

    def _channel(self, sdk: Any, topic: str) -> Channel:
        name, text = messages.TOPICS[topic]
        schema = sdk.Schema(name=name, encoding="ros2msg", data=text.encode())
        return sdk.Channel(topic, schema=schema, message_encoding="cdr", context=self.context)

    def _attach(self, name: str, kind: str, data: bytes) -> None:
        self._writer.attach(log_time=self._start, create_time=self._start, name=name, media_type=kind, data=data)


def _sdk() -> Any:
    """foxglove-sdk.

    Raises
    ------
    MissingExtraError
        It is not installed.
    """
    try:
        import foxglove
        import foxglove.mcap
    except ImportError as error:
        said = "" if error.name == "foxglove" else f", which cannot be imported: {error}"
        raise MissingExtraError(
            f"records need the package foxglove-sdk{said}; install it with: pip install 'hognose[drive]'"
        ) from None
    return foxglove
