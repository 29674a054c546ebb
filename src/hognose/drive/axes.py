"""All drives of an arm as one: what they say, what they are told, and all of it in one cycle of the bus."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hognose.drive.bus import Bus
from hognose.drive.cia402 import QUICK_STOP, State, state_of
from hognose.drive.clock import Clock
from hognose.drive.configuration import ALL_CONTROL, CONTROL, DECELERATION, FEEDBACK, SET_POINT, STATUS
from hognose.drive.frames import Frame
from hognose.drive.masters import commanding
from hognose.drive.network import Network
from hognose.drive.network_spec import MASTER
from hognose.drive.sdo import Request, Script, run_scripts

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

_SYNC, _NMT, _EMERGENCY, _HEARTBEAT = 0x080, 0x000, 0x080, 0x700
_START, _OPERATIONAL, _BOOT = 0x01, 0x05, 0x00
#: Axes that move slower (counts/s) stop as if they moved so fast: sooner than the others, on a way that is nothing.
_SLOWEST = 200.0
#: What a record's velocity and a deceleration hold: 24 bits signed, 32 bits.
_FASTEST, _HARDEST = 2**23 - 1, 2**32 - 1


def _emptied() -> Script:
    """Empty the buffer of an EPOS2: 0 clears it and lets nothing in, 1 lets records in (maxon's application note)."""
    for value in (0, 1):
        yield Request(0x60C4, 6, bytes([value]))
    return None


class Emergency(NamedTuple):
    """An error that a drive reports: when (s), of which axis (0-based), its code."""

    time: float
    axis: int
    code: int


class Axes:
    """The drives of a network, after they were brought up.

    Attributes
    ----------
    status, position, following, buffer : (A,)
        What the drives said last: statuswords, counts, following errors in counts, and status of the buffer.
    mute_for
        Why the master's heartbeats have ended, so that drives stop by themselves, in words; empty while they go on.
    by_records : (A,)
        Whether they take records of position, velocity and time, not cyclic positions.
    load : (A,)
        What they said of their current, in their unit.
    heard, beaten : (A,) s
        When their status, and their heartbeat came last.
    restarted : (A,)
        Whether they said that they started anew since they were found.
    mode : (A,)
        Of operation, as drives said last; 0 before they did.
    dropped : (A,)
        Whether they say that they are not operational: then they hear no set-points, and no stop.
    emergencies
        All that came, in order.
    foreign_commands, other_master
        How many commands came from somebody else, and what the last did, in words.
    """

    def __init__(self, bus: Bus, clock: Clock, network: Network) -> None:
        self._bus, self.clock, self.network = bus, clock, network
        count = len(network.nodes)
        self.status, self.position = np.zeros(count, np.int64), np.zeros(count, np.int64)
        self.following, self.buffer = np.zeros(count, np.int64), np.zeros(count, np.int64)
        self.load = np.zeros(count)
        self.heard, self.beaten = np.full(count, -np.inf), np.full(count, -np.inf)
        self.restarted, self.dropped = np.zeros(count, bool), np.zeros(count, bool)
        self.mode = np.zeros(count, np.int64)
        self.mute_for = ""
        self.emergencies: list[Emergency] = []
        self.foreign_commands, self.other_master = 0, ""
        self._axis = {node: axis for axis, node in enumerate(network.nodes)}
        self._turns = np.array(network.counts_per_turn, np.float64)
        self.by_records = np.array([kind == "epos2" for kind in network.kinds])
        self._beat = -np.inf

    def __len__(self) -> int:
        return len(self.status)

    def states(self) -> list[State]:
        """Of all drives, as they said last."""
        return [state_of(int(word)) for word in self.status]

    def start(self) -> None:
        """Let all nodes exchange PDOs; nothing is enabled by that."""
        self.restarted[:], self.mute_for = False, ""
        self.forget()
        self._bus.send([Frame(_NMT, bytes([_START, 0]))])

    def forget(self) -> None:
        """Take no drive for heard any more: what was said before is not about what they are now."""
        self.heard[:] = self.beaten[:] = -np.inf

    def stop_one(self, axis: int) -> None:
        """Stop one drive, which did not hear or do what stops all; one that is not operational is made so first."""
        node = self.network.nodes[axis]
        first = [Frame(_NMT, bytes([_START, node]))] if self.dropped[axis] else []
        self._bus.send([*first, Frame(CONTROL + node, struct.pack("<H", QUICK_STOP))])

    def take(self, frame: Frame) -> None:
        """Note what a drive says; frames of others are left alone."""
        cob, data, now = frame.cob, frame.data, self.clock.now()
        axis = self._axis.get(cob & 0x7F)
        if axis is None:
            self._note_command(frame)
            return
        base = cob & 0x780
        if base == STATUS and len(data) >= 8:
            self.status[axis], self.position[axis], self.load[axis] = struct.unpack_from("<Hih", data)
            self.heard[axis] = now
        elif base == FEEDBACK and len(data) >= 5:
            if self.by_records[axis]:
                self.following[axis], self.buffer[axis], self.mode[axis] = struct.unpack_from("<hHb", data)
            else:
                self.following[axis], self.mode[axis] = struct.unpack_from("<ib", data)
        elif base == _HEARTBEAT and data:
            self.beaten[axis] = now
            self.restarted[axis] |= data[0] == _BOOT
            self.dropped[axis] = data[0] != _OPERATIONAL
        elif base == _EMERGENCY and len(data) >= 2 and (code := struct.unpack_from("<H", data)[0]):
            self.emergencies.append(Emergency(now, axis, code))
        elif base != _EMERGENCY:
            self._note_command(frame)

    def _note_command(self, frame: Frame) -> None:
        if does := commanding(frame, self._axis):
            self.foreign_commands, self.other_master = self.foreign_commands + 1, does

    def listen(self) -> None:
        """Take all that came."""
        for frame in self._bus.receive():
            self.take(frame)

    def wait(self, until: float) -> None:
        """Let time pass up to a time (s), with the master's heartbeats on the way, and take what comes."""
        every = 0.5 * self.network.spec.watch.heartbeat_s
        while True:
            self.send([])
            now = self.clock.now()
            self.listen()
            if now >= until:
                return
            self.clock.wait(min(until, now + every))

    def send(self, frames: Sequence[Frame]) -> None:
        """Send frames, behind the master's heartbeat if it is due."""
        now = self.clock.now()
        first = []
        if not self.mute_for and now - self._beat >= 0.5 * self.network.spec.watch.heartbeat_s:
            self._beat, first = now, [Frame(_HEARTBEAT + MASTER, bytes([_OPERATIONAL]))]
        if first or frames:
            self._bus.send([*first, *frames])

    def empty_buffers(self) -> str:
        """Empty the buffers of records and let them take new ones; what went wrong, in words, empty if nothing did."""
        nodes = [node for node, is_record in zip(self.network.nodes, self.by_records, strict=True) if is_record]
        scripts = {node: _emptied() for node in nodes}
        faults = run_scripts(self._bus, self.clock, scripts, self.take, meanwhile=lambda: self.send([]))
        told = [f"{self.network.axis_name(self._axis[node])}: {words}" for node, words in sorted(faults.items())]
        return ", ".join(told)

    def control(self, axis: int, word: int) -> None:
        """Send a controlword to one drive."""
        self.send([Frame(CONTROL + self.network.nodes[axis], struct.pack("<H", word))])

    def control_all(self, word: int) -> None:
        """Send a controlword that acts on all drives at once: a single frame."""
        self._bus.send([Frame(ALL_CONTROL, struct.pack("<H", word))])

    def sync(self) -> None:
        """Let set-points take effect, and ask for the status of all."""
        self.send([Frame(_SYNC, b"")])

    def ask(self) -> None:
        """Ask for the status of all, and wait until the bus has carried it."""
        began = self.clock.now()
        self.sync()
        self.wait(began + self.network.answer_s)

    def set_points(self, counts: Counts, velocity: Array, milliseconds: int, records: bool) -> list[Frame]:
        """The frames that tell drives where to be next: those that take records, or those that take cyclic positions.

        Parameters
        ----------
        counts : (A,)
        velocity : (A,) counts/s
            When they are there.
        milliseconds
            How long until the next ones; 0 ends the motion.
        """
        rpm = np.clip(np.rint(60.0 * velocity / self._turns), -_FASTEST, _FASTEST).astype(np.int64)
        found = []
        for node, is_record, position, speed in zip(
            self.network.nodes, self.by_records.tolist(), counts.tolist(), rpm.tolist(), strict=True
        ):
            if is_record != records:
                continue
            data = struct.pack("<i", position)
            if is_record:
                data += speed.to_bytes(3, "little", signed=True) + bytes([milliseconds])
            found.append(Frame(SET_POINT + node, data))
        return found

    def decelerations(self, velocity: Array, duration: float) -> list[Frame]:
        """The frames by which a quick stop from velocities (A,) counts/s takes all axes the same duration (s)."""
        speed = np.maximum(np.abs(velocity), _SLOWEST)
        rpm = np.clip(np.ceil(60.0 * speed / self._turns / duration), 1, _HARDEST).astype(np.int64)
        return [
            Frame(DECELERATION + node, struct.pack("<I", value))
            for node, value in zip(self.network.nodes, rpm.tolist(), strict=True)
        ]

    @property
    def tensions(self) -> Array:
        """What the cables pull (c,) N, by what their drives say."""
        return self.network.spec.drives.newton_per_unit * self.load[: len(self.network.spec.drives.nodes)]
