"""An emulated board of a slider: the serial protocol, the states, and one motor; also a pattern for a board's program.

It does what docs/slider-board.md asks of a board, and nothing that it does not ask for.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

import numpy as np

from hognose.drive.emulator.axis import Axis
from hognose.drive.emulator.faults import Fault
from hognose.drive.serial_slider.framing import START, Decoder, Message, framed
from hognose.drive.serial_slider.messages import (
    DELAY_UNIT,
    LONGEST_TARGET,
    VERSION,
    Ability,
    BoardState,
    Configure,
    Flags,
    Kind,
    Result,
    Status,
    Target,
    Welcome,
)

#: Error codes (CiA 402, maxon): following error, the host is silent, over-current, generic.
FOLLOWING, SILENCE, OVERCURRENT, GENERIC = 0x8611, 0x8130, 0x2310, 0x1000
#: How late a board that is late is (s), and how far an encoder jumps (counts).
_LATE, _JUMP = 0.1, 10_000.0
#: One answer in so many is damaged by `bad_checksums`.
_EVERY = 3


class EmulatedBoard:
    """The board.

    Attributes
    ----------
    axis
        Its motor.
    state
    error
        The code of its error, 0 for none.
    referenced
        Whether it knows where it is.
    version
        Of the protocol that it says it speaks.
    """

    def __init__(self, start: int = 0, seed: int = 0) -> None:
        self.axis, self.referenced, self.version = Axis(start), True, VERSION
        self._apart = 0.0  # where the carriage is, less what the counter says
        self._rng = np.random.default_rng(seed)
        self._faults: set[str] = set()
        self._out: list[tuple[float, bytes]] = []
        self._now, self._answers = 0.0, 0
        self._begin()

    def _begin(self) -> None:
        """As after power-up."""
        self.state, self.error, self._lost = BoardState.UNCONFIGURED, 0, 0
        self._decoder = Decoder()
        self._last: int | None = None
        self._limits: Configure | None = None
        self._held: tuple[int, Target | Result] | None = None
        self._due: tuple[float, Target] | None = None
        self._heard, self._deceleration = self._now, 1.0

    def hear(self, data: bytes, now: float) -> None:
        """Take bytes from the line."""
        self._now = now
        if "frozen" in self._faults:
            return
        for message in self._decoder.feed(data, now):
            self._take(message)

    def say(self, now: float) -> bytes:
        """The bytes that go onto the line by now (s)."""
        due = [data for when, data in self._out if when <= now + 1e-12]
        self._out = [each for each in self._out if each[0] > now + 1e-12]
        return b"".join(due)

    def advance(self, dt: float, now: float) -> None:
        """Let a time (s) of `dt` pass, up to now."""
        self._now = now
        if "frozen" not in self._faults:
            for message in self._decoder.feed(b"", now):  # behind one that was cut off
                self._take(message)
        if self._due is not None and now >= self._due[0] - 1e-9:
            self._effect(self._due[1])
        if self._has_power:
            self.axis.step(dt)
        if self._limits is None or self.state is not BoardState.ENABLED:
            return
        if abs(self.axis.demanded - self.axis.actual) > self._limits.window:
            self.fail(FOLLOWING)
        elif now - self._heard > 1e-3 * self._limits.watchdog:
            self.error = SILENCE
            self._stop(self._deceleration)

    def fail(self, code: int) -> None:
        """An error: hold where the motor is, and say so."""
        self.state, self.error, self._due = BoardState.ERROR, code, None
        self.axis.hold()

    def inject(self, fault: Fault) -> None:
        """Let something go wrong at once."""
        kind = fault.kind
        at_once: dict[str, Callable[[], None]] = {
            "following_error": lambda: self.fail(FOLLOWING),
            "overcurrent": lambda: self.fail(OVERCURRENT),
            "emergency": lambda: self.fail(GENERIC),
            "power_lost": self._lose_power,
        }
        if kind in at_once:
            at_once[kind]()
            return
        self._faults.add(kind)
        if kind == "stuck":
            self.axis.is_stuck = True
        elif kind == "encoder_jump":
            self.axis.actual += _JUMP
            self._apart -= _JUMP

    def repair(self) -> None:
        """End all faults; an error stays until it is reset."""
        self._faults.clear()
        self.axis.is_stuck = False

    @property
    def place(self) -> float:
        """Where the carriage is, in counts from where it would be at 0 at first, whatever the counter says."""
        return self.axis.actual + self._apart

    @property
    def _has_power(self) -> bool:
        return self.state in (BoardState.ENABLED, BoardState.STOPPED, BoardState.ERROR)

    def _lose_power(self) -> None:
        """Its counter begins at zero then, wherever the motor is."""
        self._begin()
        self._count_from(0)
        self.referenced = False
        self._out.clear()

    def _count_from(self, position: int) -> None:
        """Let the counter say another position, of a motor at rest."""
        place, is_stuck = self.place, self.axis.is_stuck
        self.axis = Axis(position)
        self.axis.is_stuck, self._apart = is_stuck, place - position

    def _take(self, message: Message) -> None:
        kind, number, payload = message
        self._heard = self._now
        if kind != Kind.HELLO and self._last is not None:
            self._lost += (number - self._last - 1) % 256
        self._last = number
        if kind == Kind.HELLO:
            self._answer(Message(Kind.WELCOME, number, self._welcome()))
            return
        takes = {
            Kind.CONFIGURE: (Configure.FORM.size, self._configure),
            Kind.ENABLE: (0, self._enable),
            Kind.DISABLE: (0, self._disable),
            Kind.TARGET: (Target.FORM.size, lambda data: self._target(number, data)),
            Kind.LATCH: (3, self._latch),
            Kind.STOP: (4, lambda data: self._stop(float(struct.unpack("<I", data)[0]))),
            Kind.RESET: (0, self._reset),
            Kind.ASK: (0, lambda data: Result.DONE),
            Kind.REFERENCE: (4, self._reference),
        }
        found = takes.get(Kind(kind)) if kind in set(Kind) else None
        if found is None:
            result = Result.UNKNOWN_KIND
        else:
            result = found[1](payload) if len(payload) == found[0] else Result.WRONG_LENGTH
        if kind != Kind.TARGET:
            self._answer(Message(Kind.STATUS, number, self._status(result)))

    def _answer(self, message: Message) -> None:
        """Put an answer onto the line, damaged or late if it is to be."""
        if self._faults & {"frozen", "heartbeat_lost"}:
            return
        data, self._answers = framed(message), self._answers + 1
        if "garbage" in self._faults:
            data = bytes(self._rng.integers(0, START, len(data), dtype=np.uint8))
        elif "bad_checksums" in self._faults and self._answers % _EVERY == 0:
            data = data[:-1] + bytes([data[-1] ^ 0x10])
        self._out.append((self._now + (_LATE if "late" in self._faults else 0.0), data))

    @property
    def _flags(self) -> Flags:
        found = Flags.HOLDS if self._has_power else Flags(0)
        found |= Flags.REFERENCED if self.referenced else Flags(0)
        return found | (Flags.MOVES if self.axis.velocity != 0.0 else Flags(0))

    def _welcome(self) -> bytes:
        place = round(self.axis.actual)
        name = "slider board (emulated)"
        return Welcome(self.version, Ability.BRAKE, self.state, self._flags, 1126, place, name).payload()

    def _status(self, result: Result) -> bytes:
        place, off = round(self.axis.actual), round(self.axis.demanded - self.axis.actual)
        bad = self._decoder.bad
        return Status(result, self.state, self._flags, place, off, self.error, bad, self._lost).payload()

    def _configure(self, data: bytes) -> Result:
        given = Configure(*Configure.FORM.unpack(data))
        if not given.watchdog or given.window < 1 or given.lowest >= given.highest:
            return Result.NOT_ALLOWED
        if self.axis.velocity != 0.0:
            return Result.NOT_NOW
        self._limits = given
        if self.state is BoardState.UNCONFIGURED:
            self.state = BoardState.DISABLED
        return Result.DONE

    def _enable(self, data: bytes) -> Result:
        del data
        if self.state not in (BoardState.DISABLED, BoardState.STOPPED) or not self.referenced:
            return Result.DONE if self.state is BoardState.ENABLED else Result.NOT_NOW
        self.state, self.error, self._held = BoardState.ENABLED, 0, None
        self.axis.hold()
        return Result.DONE

    def _disable(self, data: bytes) -> Result:
        del data
        if self.state in (BoardState.ENABLED, BoardState.STOPPED):
            self.state, self._due = BoardState.DISABLED, None
            self.axis.hold()
        return Result.DONE

    def _target(self, number: int, data: bytes) -> Result:
        """Keep a target until its LATCH comes, or why it cannot be one."""
        target = Target(*Target.FORM.unpack(data))
        allowed = 1 <= target.duration <= LONGEST_TARGET and min(target.fastest, target.deceleration) >= 1
        if self._limits is None or self.state is not BoardState.ENABLED:
            self._held = (number, Result.NOT_NOW)
        elif not (allowed and self._limits.lowest <= target.position <= self._limits.highest):
            self._held = (number, Result.NOT_ALLOWED)
        else:
            self._held = (number, target)
        return Result.DONE

    def _latch(self, data: bytes) -> Result:
        number, delay = struct.unpack("<BH", data)
        if self._held is None or self._held[0] != number:
            return Result.NO_SUCH_TARGET if self.state is BoardState.ENABLED else Result.NOT_NOW
        target, self._held = self._held[1], None
        if isinstance(target, Result):
            return target
        if self.state is not BoardState.ENABLED:
            return Result.NOT_NOW
        if self._due is not None:  # the one before must not be forgotten
            self._effect(self._due[1])
        if delay:
            self._due = (self._now + DELAY_UNIT * delay, target)
        else:
            self._effect(target)
        return Result.DONE

    def _effect(self, target: Target) -> None:
        self._due, self._deceleration = None, float(target.deceleration)
        least = abs(target.position - self.axis.demanded) / target.fastest
        self.axis.target(target.position, max(1e-3 * target.duration, least))

    def _stop(self, deceleration: float) -> Result:
        self._due = self._held = None
        if self.state is BoardState.ENABLED:
            self.state = BoardState.STOPPED
            self.axis.stop(deceleration)
        return Result.DONE if self.state is BoardState.STOPPED else Result.NOT_NOW

    def _reset(self, data: bytes) -> Result:
        del data
        if self.state is BoardState.ERROR:
            self.state = BoardState.DISABLED
            self.axis.hold()
        self.error = 0
        return Result.DONE

    def _reference(self, data: bytes) -> Result:
        if self.state not in (BoardState.UNCONFIGURED, BoardState.DISABLED):
            return Result.NOT_NOW
        self._count_from(struct.unpack("<i", data)[0])
        self.referenced = True
        return Result.DONE
