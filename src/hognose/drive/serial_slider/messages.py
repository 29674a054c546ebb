"""What host and board say to each other: kinds of messages and their payloads, all numbers low byte first.

docs/slider-board.md has the same, byte by byte, for those who write a board's program.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from typing import NamedTuple

#: The version of the protocol that this program speaks.
VERSION = 1
#: A delay of a LATCH is so long (s) for each unit of it, and what its 16 bits hold.
DELAY_UNIT, MOST_DELAY = 1e-4, 0xFFFF
#: Speeds (counts/s), decelerations (counts/s²) and durations (ms) that fit.
MOST, LONGEST_TARGET = 2**32 - 1, 1000
#: How many bytes of a board's name are told.
_NAME = 32


class Kind(IntEnum):
    """Of messages: up to 0x7F from the host, from 0x80 on from the board."""

    HELLO = 0x01
    CONFIGURE = 0x02
    ENABLE = 0x03
    DISABLE = 0x04
    TARGET = 0x05
    LATCH = 0x06
    STOP = 0x07
    RESET = 0x08
    ASK = 0x09
    REFERENCE = 0x0A
    WELCOME = 0x81
    STATUS = 0x82


class Result(IntEnum):
    """What came of a message."""

    DONE = 0
    UNKNOWN_KIND = 1
    WRONG_LENGTH = 2
    NOT_ALLOWED = 3
    NOT_NOW = 4
    NO_SUCH_TARGET = 5

    @property
    def words(self) -> str:
        """As people read it."""
        return {
            Result.DONE: "done",
            Result.UNKNOWN_KIND: "it does not know this kind of message",
            Result.WRONG_LENGTH: "the message has another length than it expects",
            Result.NOT_ALLOWED: "a value is beyond what it allows",
            Result.NOT_NOW: "it cannot in its present state",
            Result.NO_SUCH_TARGET: "it did not get the target that was to take effect",
        }[self]


class BoardState(IntEnum):
    """Of a board."""

    UNCONFIGURED = 0
    DISABLED = 1
    ENABLED = 2
    STOPPED = 3
    ERROR = 4


class Flags(IntFlag):
    """What a board says of its motor beside its state."""

    HOLDS = 1
    REFERENCED = 2
    MOVES = 4


class Ability(IntFlag):
    """What a board can do beside what it must."""

    BRAKE = 1
    ABSOLUTE = 2
    END_SWITCHES = 4


@dataclass(frozen=True)
class Configure:
    """What a board needs to know before it can be enabled.

    Attributes
    ----------
    watchdog : ms
        It stops and holds if it hears nothing for so long.
    window : counts
        A following error above this is an error.
    lowest, highest : counts
        Targets beyond are refused.
    """

    watchdog: int
    window: int
    lowest: int
    highest: int
    FORM = struct.Struct("<HIii")

    def payload(self) -> bytes:
        """As bytes."""
        return self.FORM.pack(self.watchdog, self.window, self.lowest, self.highest)


@dataclass(frozen=True)
class Target:
    """Where to be.

    Attributes
    ----------
    position : counts
    duration : ms
        When: so long after it takes effect.
    fastest : counts/s
        The motor goes there no faster, but takes longer, if it is behind.
    deceleration : counts/s²
        How hard to stop on the way there if nothing is heard.
    """

    position: int
    duration: int
    fastest: int
    deceleration: int
    FORM = struct.Struct("<iHII")

    def payload(self) -> bytes:
        """As bytes."""
        return self.FORM.pack(self.position, self.duration, self.fastest, self.deceleration)


class Latch(NamedTuple):
    """The number of the TARGET that takes effect, and when: so many units of 0.1 ms from now."""

    number: int
    delay: int

    def payload(self) -> bytes:
        """As bytes."""
        return struct.pack("<BH", self.number, self.delay)


@dataclass(frozen=True)
class Welcome:
    """A board's answer to HELLO.

    Attributes
    ----------
    version
        Of the protocol that it speaks.
    abilities
    state
    flags
    serial
        Its serial number.
    position : counts
    name
        At most 32 bytes of UTF-8.
    """

    version: int
    abilities: Ability
    state: BoardState
    flags: Flags
    serial: int
    position: int
    name: str
    FORM = struct.Struct("<BHBBIi")

    def payload(self) -> bytes:
        """As bytes."""
        head = (self.version, self.abilities, self.state, self.flags, self.serial, self.position)
        return self.FORM.pack(*head) + self.name.encode("utf-8")[:_NAME]

    @classmethod
    def of(cls, payload: bytes) -> Welcome | None:
        """From bytes; None if they say none. Of another version, only that is told."""
        if payload and payload[0] != VERSION:
            return cls(payload[0], Ability(0), BoardState.UNCONFIGURED, Flags(0), 0, 0, "")
        if len(payload) < cls.FORM.size or payload[3] not in set(BoardState):
            return None
        version, abilities, state, flags, serial, position = cls.FORM.unpack_from(payload)
        name = payload[cls.FORM.size :].decode("utf-8", "replace").strip("\0 ")
        return cls(version, Ability(abilities & 7), BoardState(state), Flags(flags & 7), serial, position, name)


@dataclass(frozen=True)
class Status:
    """A board's answer to everything but HELLO and TARGET.

    Attributes
    ----------
    result
        Of the message that it answers.
    state
    flags
    position, off : counts
        Where the motor is, and by how much it is behind what is demanded.
    error
        A code of CiA 402; 0 for none.
    bad, lost
        How many damaged messages the board got, and how many numbers it missed, up to 65535 and from 0 again.
    """

    result: Result
    state: BoardState
    flags: Flags
    position: int
    off: int
    error: int
    bad: int
    lost: int
    FORM = struct.Struct("<BBBiiHHH")

    def payload(self) -> bytes:
        """As bytes."""
        head = (self.result, self.state, self.flags, self.position, self.off)
        return self.FORM.pack(*head, self.error, self.bad & 0xFFFF, self.lost & 0xFFFF)

    @classmethod
    def of(cls, payload: bytes) -> Status | None:
        """From bytes; None if they say none."""
        if len(payload) != cls.FORM.size or payload[0] not in set(Result) or payload[1] not in set(BoardState):
            return None
        result, state, flags, *numbers = cls.FORM.unpack(payload)
        return cls(Result(result), BoardState(state), Flags(flags & 7), *numbers)
