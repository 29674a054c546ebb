"""A bus with a slider on a serial board: for all that use it, the board is one more drive with cyclic positions.

What is sent to the slider's node becomes messages to the board, and what the board answers becomes frames of that node.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence

from hognose.drive import cia402
from hognose.drive.bus import Bus, BusError, ailment_of
from hognose.drive.bus_load import frame_bits
from hognose.drive.cia402 import State
from hognose.drive.clock import Clock
from hognose.drive.configuration import ALL_CONTROL, CONTROL, DECELERATION, FEEDBACK, SET_POINT, STATUS
from hognose.drive.frames import Frame
from hognose.drive.network import Network
from hognose.drive.network_spec import EMULATED, MASTER
from hognose.drive.serial_slider.line import Line, LineError, SerialLine
from hognose.drive.serial_slider.link import Link
from hognose.drive.serial_slider.messages import (
    DELAY_UNIT,
    LONGEST_TARGET,
    MOST,
    MOST_DELAY,
    BoardState,
    Flags,
    Kind,
    Latch,
    Result,
    Status,
    Target,
)

#: Error codes of the slider's node that are the line's: damaged or lost messages, a line that is gone, a refused one.
DAMAGED, GONE, REFUSED = 0x8181, 0x8182, 0x8183
_SYNC, _EMERGENCY, _HEARTBEAT = 0x080, 0x080, 0x700
_BOOT, _OPERATIONAL = 0x00, 0x05
#: A board that is behind may go so much faster than set-points do, and always so fast (m/s).
_CATCH_UP, _CREEP = 1.25, 1e-3
_REMOTE, _VOLTAGE, _REACHED = 0x0200, 0x10, 0x0400
#: What a board that is not enabled is for CiA 402, step by step.
_RUNGS = (State.SWITCH_ON_DISABLED, State.READY_TO_SWITCH_ON, State.SWITCHED_ON)


def with_slider(bus: Bus, clock: Clock, network: Network, line: Line | None = None) -> Bus:
    """A bus with the slider's board, where a network has one; otherwise the bus itself.

    The line is that of the network file unless given. It is opened when drives are brought up.

    Raises
    ------
    MissingExtraError
        pyserial is not installed.
    """
    slider = network.spec.slider
    if slider is None or slider.kind != "serial":
        return bus
    link = Link(line or SerialLine(slider.port, slider.baud), clock, network.spec.watch.lost_after_s)
    return SliderBus(bus, link, clock, network)


class SliderBus:
    """See `hognose.drive.bus.Bus`.

    Attributes
    ----------
    can
        The bus of the drives.
    link
        The line to the board.
    milliseconds
        How long a cycle is: a TARGET is reached after so long.
    """

    def __init__(self, bus: Bus, link: Link, clock: Clock, network: Network) -> None:
        slider = network.spec.slider
        assert slider is not None, "a network with a board has a slider"
        self.can, self.link, self._clock = bus, link, clock
        self._node, self._turns = slider.at_node, slider.counts_per_turn
        #: A frame of an emulated bus takes no time.
        self._bit_s = [0.0 if bus.interface == EMULATED else 1.0 / bus.bitrate for bus in network.spec.buses]
        self._bus_of = network.bus_of
        #: When (s) each bus has carried all that was sent.
        self._free = [0.0] * len(network.spec.buses)
        self.milliseconds = round(1e3 * network.spec.cycle_s)
        self._frames: list[Frame] = []
        self._on, self._gone, self._stops = False, "", False
        self._rung, self._told = 0, set[int]()
        self._deceleration = 1
        self._before: int | None = None
        self._creep = _CREEP * slider.counts_per_metre
        self._target: int | None = None
        self._handlers: dict[int, Callable[[bytes], None]] = {
            _SYNC: self._sync,
            ALL_CONTROL: self._control,
            CONTROL + self._node: self._control,
            SET_POINT + self._node: self._set_point,
            DECELERATION + self._node: self._decelerate,
            _HEARTBEAT + MASTER: self._ask,
        }

    def open(self) -> None:
        """Open the line anew; a `LineError` if it cannot be opened."""
        self._on, self._gone, self._rung, self._frames, self._stops = False, "", 0, [], False
        self._target = self._before = None
        self._told.clear()
        self.link.open()

    def connect(self, cycle: float) -> None:
        """From now on the board is a node of the bus, with set-points in cycles of so long (s)."""
        self.milliseconds = min(round(1e3 * cycle), LONGEST_TARGET)
        self._on = True

    def send(self, frames: Sequence[Frame]) -> None:
        """See `Bus.send`. A board is stopped where the bus takes no more frames."""
        ahead, others, behind = [], [], []
        for frame in frames:
            is_own, base = frame.cob & 0x7F == self._node, frame.cob & 0x780
            if is_own and base in (DECELERATION, SET_POINT):
                ahead.append(frame)
                continue
            behind.append(frame)
            if not (is_own and base == CONTROL):
                others.append(frame)
        if self._on:  # so that a TARGET is there before the SYNC that lets it take effect
            self._hand_over(sorted(ahead, key=lambda frame: frame.cob, reverse=True))
        try:
            if others:
                self.can.send(others)
        except BusError:
            self._tell(Kind.STOP, struct.pack("<I", self._deceleration))
            raise
        self._queue(others)
        if self._on:
            self._hand_over(behind)

    def receive(self) -> list[Frame]:
        """See `Bus.receive`: also what the board said, as frames of its node."""
        found = self.can.receive()
        if self._on:
            self._hear()
        mine, self._frames = self._frames, []
        return [*found, *mine]

    @property
    def ailment(self) -> str:
        """See `hognose.drive.bus.Ailing.ailment`: of the bus of the drives."""
        return ailment_of(self.can)

    def close(self) -> None:
        """See `Bus.close`; the board stops and holds by its watchdog, if it has not stopped yet."""
        self._on = False
        self.link.line.close()
        self.can.close()

    def _hand_over(self, frames: Sequence[Frame]) -> None:
        """Let the board know what frames are about."""
        for cob, data in frames:
            handler = self._handlers.get(cob)
            if handler is not None:
                handler(data)

    def _queue(self, frames: Sequence[Frame]) -> None:
        """Keep until when (s) each bus will be busy with what was sent: its nodes' frames, and what all are to hear."""
        for k, (free, bit) in enumerate(zip(self._free, self._bit_s, strict=True)):
            mine = [data for cob, data in frames if self._bus_of.get(cob & 0x7F, k) == k]
            self._free[k] = max(free, self._clock.now()) + bit * sum(frame_bits(len(data)) for data in mine)

    def _tell(self, kind: Kind, payload: bytes = b"") -> int:
        """Send a message to the board; where its line is gone, that is reported instead."""
        if self._gone or not self._on:
            return 0
        try:
            return self.link.send(kind, payload)
        except LineError as error:
            self._lose(error)
            return 0

    def _lose(self, error: LineError) -> None:
        self._gone = str(error)
        self._report(GONE)

    def _report(self, code: int) -> None:
        """Say an error of the slider, once until it is reset."""
        if code not in self._told:
            self._told.add(code)
            self._frames.append(Frame(_EMERGENCY + self._node, struct.pack("<HB5x", code, 0x11)))

    @property
    def gone(self) -> str:
        """Why the line is gone, in words; empty while it is there."""
        return self._gone

    @property
    def _state(self) -> BoardState:
        status = self.link.status
        return BoardState.UNCONFIGURED if status is None else status.state

    def _sync(self, data: bytes) -> None:
        """Let the last TARGET take effect when the bus is through with all up to this SYNC, or ask how it is."""
        del data
        if self._target is None:
            self._tell(Kind.ASK)
            return
        delay = max(0.0, max(self._free) - self._clock.now())
        latch = Latch(self._target, min(round(delay / DELAY_UNIT), MOST_DELAY))
        self._target = None
        self._tell(Kind.LATCH, latch.payload())

    def _ask(self, data: bytes) -> None:
        """The master's heartbeat feeds the board's watchdog; one that did not hear that it is to stop is told again."""
        del data
        if self._stops and self._state is BoardState.ENABLED:
            self._tell(Kind.STOP, struct.pack("<I", self._deceleration))
        else:
            self._tell(Kind.ASK)

    def _set_point(self, data: bytes) -> None:
        if len(data) >= 4 and self._state is BoardState.ENABLED:  # as a drive that is not enabled takes none
            (position,) = struct.unpack_from("<i", data)
            target = Target(position, self.milliseconds, self._fastest(position), self._deceleration)
            self._before = position
            self._target = self._tell(Kind.TARGET, target.payload())

    def _fastest(self, position: int) -> int:
        """How fast (counts/s) a board may go to a set-point: what was late or lost is not made up for by a leap."""
        status = self.link.status
        before = self._before if self._before is not None else position if status is None else status.position
        speed = max(_CATCH_UP * abs(position - before) / (1e-3 * self.milliseconds), self._creep)
        return min(math.ceil(speed), MOST)

    def _decelerate(self, data: bytes) -> None:
        """A quick stop's deceleration: rpm/s on the bus, counts/s² on the line."""
        if len(data) >= 4:
            value = struct.unpack_from("<I", data)[0] * self._turns // 60
            self._deceleration = min(max(value, 1), MOST)

    def _control(self, data: bytes) -> None:
        """Do what a controlword says, in the board's state (CiA 402, figure 3)."""
        if len(data) < 2:
            return
        word, state = struct.unpack_from("<H", data)[0], self._state
        if state is BoardState.ERROR:
            if word & cia402.FAULT_RESET:
                self._rung = 0
                self._told.clear()
                self._tell(Kind.RESET)
        elif not word & 0x02:
            self._rung = 0
            self._tell(Kind.DISABLE)
        elif not word & 0x04:
            self._rung, self._stops = 0, True
            self._target = self._before = None
            self._tell(Kind.STOP, struct.pack("<I", self._deceleration))
        elif word & 0x0F == cia402.ENABLE and state is not BoardState.DISABLED:
            self._stops = False
            if state is BoardState.STOPPED:
                self._tell(Kind.ENABLE)
        elif state is BoardState.DISABLED:
            self._climb(word & 0x0F)

    def _climb(self, word: int) -> None:
        """A drive is enabled in three steps, and not by the last one alone."""
        if word == cia402.SHUTDOWN:
            self._rung = 1
        elif word == cia402.SWITCH_ON and self._rung:
            self._rung = 2
        elif word == cia402.ENABLE and self._rung == 2:
            self._stops = False
            self._tell(Kind.ENABLE)

    def _hear(self) -> None:
        """Put what the board said into frames of its node."""
        if self._gone:
            return
        try:
            answers = self.link.receive()
        except LineError as error:
            self._lose(error)
            return
        for kind, status in answers:
            self._say(kind, status)
        if self.link.is_bad:
            self.link.forgive()
            self._told.discard(DAMAGED)
            self._report(DAMAGED)

    def _say(self, kind: Kind, status: Status) -> None:
        node, restarted = self._node, status.state is BoardState.UNCONFIGURED
        beat = _BOOT if restarted else _OPERATIONAL
        word, position = self._word(status), status.position
        self._frames.append(Frame(_HEARTBEAT + node, bytes([beat])))
        self._frames.append(Frame(STATUS + node, struct.pack("<Hih", word, position, 0)))
        self._frames.append(Frame(FEEDBACK + node, struct.pack("<iB", status.off, cia402.CYCLIC_POSITION)))
        if status.error:
            self._report(status.error)
        else:
            self._told -= {code for code in self._told if code not in (DAMAGED, GONE)}
        refused = status.result in (Result.UNKNOWN_KIND, Result.WRONG_LENGTH, Result.NOT_ALLOWED)
        if refused and kind is not Kind.CONFIGURE:
            self._report(REFUSED)

    def _word(self, status: Status) -> int:
        """A statusword (CiA 402) that says the same as a board's status."""
        state = {
            BoardState.ENABLED: State.OPERATION_ENABLED,
            BoardState.STOPPED: State.QUICK_STOP_ACTIVE,
            BoardState.ERROR: State.FAULT,
        }.get(status.state, _RUNGS[self._rung])
        word = state.value[0] | _REMOTE
        if status.flags & Flags.HOLDS:
            word |= _VOLTAGE
        if not status.flags & Flags.MOVES:
            word |= _REACHED
        return word
