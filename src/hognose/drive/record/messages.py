"""What is in a record: the messages of its topics, their definitions, and how they become bytes and back."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hognose.drive.record.cdr import Decoder, Encoder

Array = NDArray[np.float64]
Counts = NDArray[np.int64]


class CycleRow(NamedTuple):
    """What was commanded and measured in a cycle, of A cables and the slider.

    Attributes
    ----------
    time : s
        Since the start of the record.
    state
        Of the executor: OFF, ARMED, HOLD, TENSION, READY, PREFILL, RUN, HELD.
    progress
        Place along the plan in steps, 0 to T-1.
    commanded, measured : (A,) int64 counts
    tensions : (A,) N
    currents : (A,) A
    following : (A,) counts
        Following errors as the drives say them.
    status : (A,) uint16
        Statuswords.
    slider_commanded, slider_measured : m
    lateness : s
        How late this cycle began.
    """

    time: float
    state: str
    progress: float
    commanded: Counts
    measured: Counts
    tensions: Array
    currents: Array
    following: Array
    status: NDArray[np.uint16]
    slider_commanded: float
    slider_measured: float
    lateness: float


class Event(NamedTuple):
    """Something that happened.

    Attributes
    ----------
    time : s
        Since the start of the record.
    kind
        One word, as "fault".
    text
        A sentence.
    node
        Of the drive that it is about, or None.
    step
        Where the arm was along the plan, in steps, or None.
    """

    time: float
    kind: str
    text: str
    node: int | None = None
    step: float | None = None

    @property
    def words(self) -> str:
        """In a line."""
        node = "" if self.node is None else f", node {self.node}"
        step = "" if self.step is None else f", step {self.step:.1f}"
        return f"{self.time:9.3f} s  {self.kind}{node}{step}: {self.text}"


_HEADER = """\
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""

CYCLE = f"""\
# What was commanded and measured in a cycle; one entry a cable in each array.
std_msgs/Header header
float64 time              # s since the start of the record
string state              # OFF ARMED HOLD TENSION READY PREFILL RUN HELD
float64 progress          # place along the plan, in steps
int64[] commanded         # counts
int64[] measured          # counts
float64[] tensions        # N
float64[] currents        # A
float64[] following       # counts: following error
uint16[] status           # CiA 402 statuswords
float64 slider_commanded  # m
float64 slider_measured   # m
float64 lateness          # s: how late the cycle began
{_HEADER}"""

EVENT = f"""\
# Something that happened.
std_msgs/Header header
float64 time  # s since the start of the record
string kind
string text
int32 node    # of the drive that it is about; -1: none
float64 step  # place along the plan, in steps; NaN: none
{_HEADER}"""

JOINTS = f"""\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
{_HEADER}"""

IMAGE = f"""\
std_msgs/Header header
string format
uint8[] data
{_HEADER}"""

#: Name and definition (ros2msg) of the messages of each topic.
TOPICS: Mapping[str, tuple[str, str]] = {
    "/state": ("hognose_msgs/msg/Cycle", CYCLE),
    "/commanded": ("sensor_msgs/msg/JointState", JOINTS),
    "/measured": ("sensor_msgs/msg/JointState", JOINTS),
    "/events": ("hognose_msgs/msg/Event", EVENT),
    "/tip_camera": ("sensor_msgs/msg/CompressedImage", IMAGE),
}


def _begun(stamp: int, frame: str = "") -> Encoder:
    """A message with its header; `stamp` in ns since 1970."""
    message = Encoder()
    message.put("i", stamp // 1_000_000_000)
    message.put("I", stamp % 1_000_000_000)
    message.text(frame)
    return message


def cycle_message(stamp: int, row: CycleRow) -> bytes:
    """A cycle; `stamp` in ns since 1970."""
    message = _begun(stamp)
    message.put("d", row.time)
    message.text(row.state)
    message.put("d", row.progress)
    for kind, values in (
        ("i8", row.commanded),
        ("i8", row.measured),
        ("f8", row.tensions),
        ("f8", row.currents),
        ("f8", row.following),
        ("u2", row.status),
    ):
        message.array(kind, values)
    for number in (row.slider_commanded, row.slider_measured, row.lateness):
        message.put("d", number)
    return bytes(message.data)


def cycle_row(data: bytes) -> CycleRow:
    """The cycle of a message; a ValueError if it is none."""
    message = _after_header(data)
    return CycleRow(  # arguments are evaluated in the order of the message
        time=message.get("d"),
        state=message.text(),
        progress=message.get("d"),
        commanded=message.array("i8"),
        measured=message.array("i8"),
        tensions=message.array("f8"),
        currents=message.array("f8"),
        following=message.array("f8"),
        status=message.array("u2"),
        slider_commanded=message.get("d"),
        slider_measured=message.get("d"),
        lateness=message.get("d"),
    )


def event_message(stamp: int, event: Event) -> bytes:
    """An event; `stamp` in ns since 1970."""
    message = _begun(stamp)
    message.put("d", event.time)
    message.text(event.kind)
    message.text(event.text)
    message.put("i", -1 if event.node is None else event.node)
    message.put("d", np.nan if event.step is None else event.step)
    return bytes(message.data)


def event(data: bytes) -> Event:
    """The event of a message; a ValueError if it is none."""
    message = _after_header(data)
    time, kind, text, node, step = message.get("d"), message.text(), message.text(), message.get("i"), message.get("d")
    return Event(time, kind, text, None if node == -1 else node, None if np.isnan(step) else step)


def names_of(names: Sequence[str]) -> bytes:
    """The names of joints as they are in every message of their states, which are the same each time."""
    # Behind a header with an empty frame they begin at byte 16, a multiple of 8: aligned as on their own.
    message = Encoder()
    message.put("I", len(names))
    for name in names:
        message.text(name)
    return bytes(message.data[4:])


def joints_message(stamp: int, names: bytes, positions: Array, efforts: Array) -> bytes:
    """Joint states (j,) m and (j,) N or none; `stamp` in ns since 1970, `names` from `names_of`."""
    message = _begun(stamp)
    message.data += bytes(3) + names  # an empty frame leaves one byte behind a multiple of 4
    message.array("f8", positions)
    message.array("f8", ())
    message.array("f8", efforts)
    return bytes(message.data)


def image_message(stamp: int, jpeg: bytes) -> bytes:
    """A picture of the camera on the tip; `stamp` in ns since 1970."""
    message = _begun(stamp, "tip_camera")
    message.text("jpeg")
    message.raw(jpeg)
    return bytes(message.data)


def image(data: bytes) -> tuple[int, bytes]:
    """The stamp (ns since 1970) and the JPEG of a message; a ValueError if it is none."""
    message = Decoder(data)
    stamp = message.get("i") * 1_000_000_000 + message.get("I")
    message.text()
    message.text()
    return stamp, message.raw()


def _after_header(data: bytes) -> Decoder:
    message = Decoder(data)
    message.get("i")
    message.get("I")
    message.text()
    return message
