"""An emulated drive: a CANopen node with the state machine of CiA 402 and one motor."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass

from hognose.drive import cia402
from hognose.drive.cia402 import CYCLIC_POSITION, HOMING, INTERPOLATED_POSITION, State
from hognose.drive.emulator.axis import Axis, Record
from hognose.drive.emulator.encoder import Encoder
from hognose.drive.emulator.objects import RECORDS, Objects, objects_of
from hognose.drive.emulator.sdo_server import NOT_MAPPABLE, NOT_NOW, PDO_TOO_LONG, SdoServer
from hognose.drive.frames import Frame
from hognose.drive.network_spec import Kind

#: NMT states as heartbeats say them (CiA 301, table 43).
BOOT, OPERATIONAL, STOPPED, PRE_OPERATIONAL = 0x00, 0x05, 0x04, 0x7F
#: Error codes of maxon's drives: following error, heartbeat, interpolated position mode, over-current, bus off.
FOLLOWING, HEARTBEAT, INTERPOLATION, OVERCURRENT, BUS_OFF = 0x8611, 0x8130, 0xFF0C, 0x2310, 0x81FD
_UNUSED = 1 << 31
_QUICK_STOP = 3
#: Objects that are read all the time: window of the following error, time of heartbeats, and of the master's.
WINDOW, BEATS, SILENCE = (0x6065, 0), (0x1017, 0), (0x1016, 1)


@dataclass
class _Mapped:
    """A PDO that is in use: its objects and their sizes in bytes, and when it goes."""

    objects: list[tuple[tuple[int, int], int]]
    kind: int
    waiting: bytes | None = None


class EmulatedDrive:
    """One node.

    Attributes
    ----------
    node
    kind
    axis
        Its motor.
    encoder
        What the drive knows of where the motor is.
    state
        Of the state machine.
    nmt
        Of the node on the network.
    load
        What its motor says of its current: mA of an EPOS2, a thousandth of the rated torque of others.
    out
        Frames that are to be sent.
    errors
        Codes of errors that are not reset.
    """

    def __init__(
        self,
        node: int,
        kind: Kind = "epos2",
        start: int = 0,
        counts_per_turn: int = 2000,
        encoder: Encoder | None = None,
    ) -> None:
        self.node, self.counts_per_turn, self.encoder = node, counts_per_turn, encoder or Encoder()
        self.kind: Kind = kind
        self.axis = Axis(start)
        self.state, self.nmt, self.load = State.SWITCH_ON_DISABLED, PRE_OPERATIONAL, 0
        self.out: list[Frame] = [Frame(0x700 + node, bytes([BOOT]))]
        self.errors: list[int] = []
        self.objects: Objects = objects_of(kind, node, 1000 + node, counts_per_turn)
        self._sdo = SdoServer(self.objects, self._refresh, self._written)
        self._receives: dict[int, list[_Mapped]] = {}
        self._transmits: list[tuple[int, _Mapped]] = []
        self._beat, self._heard, self._master = 0.0, -1.0, False
        self._now, self._last_sync, self._period = 0.0, -1.0, 0.02
        self._control, self._syncs = 0, 0
        self._takes_records = False
        self._window, self._beats, self._silence = (self.objects[each] for each in (WINDOW, BEATS, SILENCE))

    def _value(self, index: int, sub: int = 0) -> int:
        return self.objects[index, sub].value

    def receive(self, frame: Frame, now: float) -> None:
        """Take a frame from the bus."""
        self._now, (cob, data) = now, frame
        if cob == 0x000:
            if len(data) == 2 and data[1] in (0, self.node):
                self._manage(data[0])
        elif cob == 0x600 + self.node:
            if self.nmt != STOPPED:
                self.out.append(Frame(0x580 + self.node, self._sdo.answer(data)))
        elif cob == self._value(0x1005) & 0x7FF:
            self._sync()
        elif 0x700 < cob <= 0x77F:
            self._listen(cob - 0x700)
        elif self.nmt == OPERATIONAL:
            for mapped in self._receives.get(cob, ()):
                if mapped.kind <= 240:
                    mapped.waiting = data
                else:
                    self._take(mapped, data)

    def advance(self, dt: float, now: float) -> None:
        """Let a time (s) of `dt` pass, up to now."""
        self._now = now
        if self.state.has_power:
            if not self.axis.step(dt):
                self.fault(INTERPOLATION)
            elif abs(self.axis.demanded - self.axis.actual) > self._window.value:
                self.fault(FOLLOWING)
        every = 1e-3 * self._beats.value
        if every and now - self._beat >= every - 1e-9:
            self._beat = now
            self.out.append(Frame(0x700 + self.node, bytes([self.nmt])))
        lost = 1e-3 * (self._silence.value & 0xFFFF)
        if self._master and lost and now - self._heard > lost:
            self._master = False
            self._say(HEARTBEAT)
            if self._value(0x6007) == _QUICK_STOP and self.state is State.OPERATION_ENABLED:
                self._quick_stop()

    def fault(self, code: int) -> None:
        """Report an error and cut the power, as the reaction to a fault does."""
        self._say(code)
        self.state = State.FAULT
        self.axis.hold()

    def lose_power(self) -> None:
        """Start anew, as after its supply was cut."""
        self.encoder.lose_supply(round(self.axis.actual))
        self.__init__(self.node, self.kind, round(self.axis.actual), self.counts_per_turn, self.encoder)

    def _say(self, code: int) -> None:
        self.errors.append(code)
        register = 0x11 if code >= 0x8000 else 0x03
        self.objects[0x1001, 0].value = register
        self.out.append(Frame(0x80 + self.node, struct.pack("<HB5x", code, register)))

    def _manage(self, command: int) -> None:
        """A command of the network's master (CiA 301, 7.2.8.3)."""
        if command in (0x81, 0x82):
            self.lose_power()
            return
        self.nmt = {0x01: OPERATIONAL, 0x02: STOPPED, 0x80: PRE_OPERATIONAL}.get(command, self.nmt)
        if command == 0x01:
            self._map()

    def _listen(self, node: int) -> None:
        if node == self._value(0x1016, 1) >> 16 & 0x7F:
            self._heard, self._master = self._now, True

    def _map(self) -> None:
        """Put the PDOs into use that are enabled."""
        self._receives, self._transmits = {}, []
        for k in range(4):
            for base in (0x1400, 0x1800):
                cob = self._value(base + k, 1)
                count = self._value(base + 0x200 + k, 0)
                if cob & _UNUSED or not count:
                    continue
                entries = [self._value(base + 0x200 + k, i) for i in range(1, count + 1)]
                mapped = _Mapped(
                    [((e >> 16, e >> 8 & 0xFF), (e & 0xFF) // 8) for e in entries], self._value(base + k, 2)
                )
                if base == 0x1400:
                    self._receives.setdefault(cob & 0x7FF, []).append(mapped)
                else:
                    self._transmits.append((cob & 0x7FF, mapped))

    def _take(self, mapped: _Mapped, data: bytes) -> None:
        if len(data) < sum(size for _, size in mapped.objects):
            self._say(0x8210)
            return
        at = 0
        for key, size in mapped.objects:
            entry = self.objects[key]
            number = entry.number_of(data[at : at + size])
            if not self._written(*key, number):
                entry.value = number
            at += size

    def _sync(self) -> None:
        """What takes effect at SYNC, and what is sent then."""
        if self.nmt != OPERATIONAL:
            return
        if self._last_sync >= 0:
            self._period = self._now - self._last_sync
        self._last_sync = self._now
        self._syncs += 1
        for each in self._receives.values():
            for mapped in each:
                if mapped.waiting is not None:
                    self._take(mapped, mapped.waiting)
                    mapped.waiting = None
        for cob, mapped in self._transmits:
            if mapped.kind <= 240 and mapped.kind and self._syncs % mapped.kind == 0:
                self.out.append(Frame(cob, b"".join(self._bytes(*key) for key, _ in mapped.objects)))

    def _bytes(self, index: int, sub: int) -> bytes:
        self._refresh(index, sub)
        return self.objects[index, sub].bytes()

    def _refresh(self, index: int, sub: int) -> None:
        """Bring an entry up to date before it is read."""
        says = _UP_TO_DATE.get((index, sub))
        if says is not None:
            self.objects[index, sub].value = says(self)

    def behind(self) -> int:
        """How far (counts) the motor is behind what is demanded."""
        return round(self.axis.demanded - self.axis.actual)

    def status(self) -> int:
        """The statusword."""
        word = self.state.value[0] | 0x0200 | self.encoder.bits(self._value(0x6060) == HOMING)
        if self.state is not State.QUICK_STOP_ACTIVE and self.state not in (State.FAULT, State.SWITCH_ON_DISABLED):
            word |= 0x20
        if self.state.has_power:
            word |= 0x10
        if self.axis.velocity == 0.0:
            word |= 0x0400
        if self.axis.interpolates:
            word |= 0x1000
        return word

    def buffer_status(self) -> int:
        """Warnings of the buffer in bits 0 (few records) and 1 (many); bits 14 and 15: it is enabled, and in use."""
        count = len(self.axis.records)
        warnings = (count < self._value(0x20C4, 2)) | (count > self._value(0x20C4, 3)) << 1
        enabled = 0x4000 if self._takes_records else 0
        return warnings | enabled | (0x8000 if self.axis.interpolates else 0)

    def _written(self, index: int, sub: int, number: int) -> int:
        """What writing a number sets off; an abort code if it cannot be written now."""
        if index == 0x6040:
            self._command(number)
        elif index == 0x20C1:
            return self._record(number)
        elif index == 0x60C4 and sub == 6:
            self.axis.records.clear()
            self._takes_records = number == 1
        elif index == 0x6060 and self.state is State.OPERATION_ENABLED and number != self._value(0x6060):
            self.axis.hold()
        elif index == 0x607A and self.state is State.OPERATION_ENABLED and self._value(0x6060) == CYCLIC_POSITION:
            period = 1e-3 * self._value(0x60C2, 1) if (0x60C2, 1) in self.objects else self._period
            self.axis.target(number + self.encoder.origin, period)
        elif index & 0xFFFC in (0x1400, 0x1800) and sub == 1 and self.nmt == OPERATIONAL:
            return NOT_NOW
        elif index & 0xFFFC in (0x1600, 0x1A00):
            return self._mapping(index, sub, number)
        return 0

    def _mapping(self, index: int, sub: int, number: int) -> int:
        """Why a PDO cannot be mapped so, as an abort code; 0 if it can (CiA 301, 7.5.2.36)."""
        if not self._value(index - 0x200, 1) & _UNUSED:
            return NOT_NOW
        if sub:
            mapped = self.objects.get((number >> 16, number >> 8 & 0xFF))
            fits = mapped is not None and mapped.mapped and 8 * mapped.size == number & 0xFF
            return 0 if fits or not number else NOT_MAPPABLE
        bits = sum(self._value(index, k) & 0xFF for k in range(1, number + 1))
        return PDO_TOO_LONG if bits > 64 else 0

    def _record(self, number: int) -> int:
        """Put a record of position (32 bits), velocity (24, rpm) and time (8, ms) into the buffer."""
        if not self._takes_records:
            return NOT_NOW
        if len(self.axis.records) >= RECORDS:
            self.fault(INTERPOLATION)
            return NOT_NOW
        position, velocity, milliseconds = struct.unpack("<i3sB", (number % (1 << 64)).to_bytes(8, "little"))
        rpm = int.from_bytes(velocity, "little", signed=True)
        at = round(position + self.encoder.origin)
        self.axis.records.append(Record(at, rpm * self.counts_per_turn / 60.0, 1e-3 * milliseconds))
        if self._control & 0x10:  # the bit is a level, not an edge
            self._go(True, True)
        return 0

    def _quick_stop(self) -> None:
        self.state = State.QUICK_STOP_ACTIVE
        self.axis.stop(self._value(0x6085) * self.counts_per_turn / 60.0)  # rpm/s

    def _command(self, word: int) -> None:
        """Transitions of the state machine (CiA 402, figure 3)."""
        rising, self._control = word & ~self._control, word
        state = self.state
        if state is State.FAULT:
            if rising & cia402.FAULT_RESET:
                self.state, self.errors = State.SWITCH_ON_DISABLED, []
                self.objects[0x1001, 0].value = 0
        elif not word & 0x02:  # disable voltage
            self._power_off()
        elif not word & 0x04:
            if state is State.OPERATION_ENABLED:
                self._quick_stop()
            elif state is not State.QUICK_STOP_ACTIVE:
                self.state = State.SWITCH_ON_DISABLED
        elif word & 0x0F == cia402.SHUTDOWN:
            if state is State.SWITCH_ON_DISABLED or not state.has_power:
                self.state = State.READY_TO_SWITCH_ON
            elif state is State.OPERATION_ENABLED:
                self._power_off()
                self.state = State.READY_TO_SWITCH_ON
        elif word & 0x0F == cia402.SWITCH_ON:
            if state is State.OPERATION_ENABLED:  # transition 5 cuts the power
                self._power_off()
            if state in (State.READY_TO_SWITCH_ON, State.OPERATION_ENABLED):
                self.state = State.SWITCHED_ON
        elif word & 0x0F == cia402.ENABLE:
            self._enable(state)
            self._go(bool(word & 0x10), not rising & 0x10)

    def _power_off(self) -> None:
        self.state = State.SWITCH_ON_DISABLED
        self.axis.hold()

    def _enable(self, state: State) -> None:
        if state in (State.SWITCHED_ON, State.READY_TO_SWITCH_ON, State.QUICK_STOP_ACTIVE):
            self.state = State.OPERATION_ENABLED
            self.axis.hold()

    def _go(self, goes: bool, was: bool) -> None:
        """Bit 4 of the controlword: begin the records, or stop; or begin to home."""
        if goes and not was and self.state is State.OPERATION_ENABLED and self._value(0x6060) == HOMING:
            self.encoder.home(self.axis, self.objects, self.kind)
        if self.state is not State.OPERATION_ENABLED or self._value(0x6060) != INTERPOLATED_POSITION:
            return
        if goes and not self.axis.interpolates:
            if not self.axis.begin() and not was:  # fewer than two records are an underflow (maxon's application note)
                self.fault(INTERPOLATION)
        elif not goes and self.axis.interpolates:
            self.axis.stop(self._value(0x6085) * self.counts_per_turn / 60.0)


#: What entries say that follow the motor, as they are read.
_UP_TO_DATE: dict[tuple[int, int], Callable[[EmulatedDrive], int]] = {
    (0x6041, 0): EmulatedDrive.status,
    (0x6061, 0): lambda drive: drive.objects[0x6060, 0].value,
    (0x6064, 0): lambda drive: drive.encoder.says(drive.axis.actual),
    (0x6078, 0): lambda drive: drive.load,
    (0x6077, 0): lambda drive: drive.load,
    (0x20F4, 0): lambda drive: max(min(drive.behind(), 32767), -32768),
    (0x60F4, 0): EmulatedDrive.behind,
    (0x20C4, 1): EmulatedDrive.buffer_status,
    (0x60C4, 2): lambda drive: RECORDS - len(drive.axis.records),
}
