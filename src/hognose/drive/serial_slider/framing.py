"""Messages on a serial line: found again behind garbage, and trusted only with their checksum.

A message is a start byte, how many bytes of payload it has, its kind, its number, the payload, and a CRC-16 of all that
but the start byte, low byte first.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

#: The first byte of a message, what surrounds a payload in all, and the longest payload.
START, AROUND, LONGEST = 0xA5, 6, 48
#: A message that is not whole so long (s) after its first byte was never one.
UNFINISHED = 0.02
_HEAD = 4
_POLYNOMIAL, _FIRST = 0x1021, 0xFFFF


class Message(NamedTuple):
    """What goes over the line: of which kind (8 bits), with which number (8 bits), and up to 48 bytes."""

    kind: int
    number: int
    payload: bytes = b""


def _table() -> tuple[int, ...]:
    found = []
    for byte in range(256):
        crc = byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ _POLYNOMIAL if crc & 0x8000 else crc << 1) & 0xFFFF
        found.append(crc)
    return tuple(found)


_TABLE = _table()


def crc16(data: bytes) -> int:
    """CRC-16/CCITT-FALSE: polynomial 0x1021, from 0xFFFF on, nothing reflected; 0x29B1 for `123456789`."""
    crc = _FIRST
    for byte in data:
        crc = (crc << 8 ^ _TABLE[crc >> 8 ^ byte]) & 0xFFFF
    return crc


def framed(message: Message) -> bytes:
    """A message as bytes."""
    kind, number, payload = message
    assert len(payload) <= LONGEST, "no message is longer"
    body = bytes([len(payload), kind, number]) + payload
    return bytes([START]) + body + struct.pack("<H", crc16(body))


class Decoder:
    """Finds messages in bytes as they come, however they are cut.

    Attributes
    ----------
    bad
        How many times something began like a message and was none: a wrong checksum, an impossible length, cut off.
    skipped
        How many bytes belonged to no message.
    """

    def __init__(self) -> None:
        self.bad, self.skipped = 0, 0
        self._rest = bytearray()
        self._since = self._latest = 0.0

    def feed(self, data: bytes, now: float) -> list[Message]:
        """The messages that are whole with these bytes, which came by now (s).

        Call it without bytes from time to time: what was cut off is given up then, and what came behind it is found.
        """
        if data:
            self._latest = now
            if not self._rest:
                self._since = now
        self._rest += data
        found = self._taken()
        while self._rest and now - self._since > UNFINISHED:  # it is no message, but there may be one behind it
            self._give_up()
            found += self._taken()
        return found

    def _taken(self) -> list[Message]:
        found: list[Message] = []
        while self._to_start():
            rest = self._rest
            if len(rest) < 2:
                break
            size = rest[1]
            whole = size + AROUND
            if size <= LONGEST and len(rest) < whole:
                break
            if size > LONGEST or crc16(bytes(rest[1 : whole - 2])) != rest[whole - 2] | rest[whole - 1] << 8:
                self._give_up()
                continue
            found.append(Message(rest[2], rest[3], bytes(rest[_HEAD : whole - 2])))
            del rest[:whole]
            self._since = self._latest
        return found

    def _give_up(self) -> None:
        """Take the start byte for none; what is behind it may have come later."""
        self.bad += 1
        self._drop(1)
        self._since = self._latest

    def _to_start(self) -> bool:
        """Whether there is a start byte, at the beginning now."""
        at = self._rest.find(START)
        self._drop(len(self._rest) if at < 0 else at)
        return at >= 0

    def _drop(self, count: int) -> None:
        del self._rest[:count]
        self.skipped += count
