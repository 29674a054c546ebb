"""The SDO server of an emulated drive: expedited transfers, and text in segments (CiA 301, 7.2.4.3)."""

from __future__ import annotations

import struct
from collections.abc import Callable

from hognose.drive.emulator.objects import Entry, Objects

#: Abort codes (CiA 301, table 22).
NO_OBJECT, NO_SUB, ONLY_READ, ONLY_WRITE, WRONG_LENGTH = 0x06020000, 0x06090011, 0x06010002, 0x06010001, 0x06070010
NOT_MAPPABLE, PDO_TOO_LONG = 0x06040041, 0x06040042
TOO_HIGH, TOO_LOW, NOT_NOW, UNKNOWN_COMMAND = 0x06090031, 0x06090032, 0x08000022, 0x05040001
#: Called with index, sub-index and the number that is to be written; an abort code, or 0 if it may be.
Written = Callable[[int, int, int], int]
#: Called with index and sub-index before an entry is read, so that its value can be brought up to date.
Read = Callable[[int, int], None]


class SdoServer:
    """Answers requests for one object dictionary."""

    def __init__(self, objects: Objects, read: Read, written: Written) -> None:
        self._objects, self._read, self._written = objects, read, written
        self._left, self._toggle = b"", 0

    def answer(self, data: bytes) -> bytes:
        """The eight bytes that answer a request of eight."""
        data = data.ljust(8, b"\0")
        command = data[0]
        index, sub = struct.unpack_from("<HB", data, 1)
        if command & 0xE0 == 0x60:
            return self._segment()
        if command & 0xE0 == 0x20:
            return self._download(command, index, sub, data[4:])
        if command & 0xE0 == 0x40:
            return self._upload(index, sub)
        return _abort(index, sub, UNKNOWN_COMMAND)

    def _entry(self, index: int, sub: int) -> Entry | int:
        found = self._objects.get((index, sub))
        if found is not None:
            return found
        return NO_SUB if any(key[0] == index for key in self._objects) else NO_OBJECT

    def _upload(self, index: int, sub: int) -> bytes:
        entry = self._entry(index, sub)
        if isinstance(entry, int):
            return _abort(index, sub, entry)
        if entry.access == "wo":
            return _abort(index, sub, ONLY_WRITE)
        self._read(index, sub)
        value = entry.bytes()
        if len(value) <= 4:
            return struct.pack("<BHB", 0x43 | (4 - len(value)) << 2, index, sub) + value.ljust(4, b"\0")
        self._left, self._toggle = value, 0
        return struct.pack("<BHBI", 0x41, index, sub, len(value))

    def _segment(self) -> bytes:
        part, self._left = self._left[:7], self._left[7:]
        last = 0 if self._left else 1
        head = self._toggle << 4 | (7 - len(part)) << 1 | last
        self._toggle ^= 1
        return bytes([head]) + part.ljust(7, b"\0")

    def _download(self, command: int, index: int, sub: int, value: bytes) -> bytes:
        entry = self._entry(index, sub)
        if isinstance(entry, int):
            return _abort(index, sub, entry)
        if entry.access in ("ro", "const"):
            return _abort(index, sub, ONLY_READ)
        size = 4 - (command >> 2 & 3) if command & 1 else 4
        if not command & 2 or size != entry.size:
            return _abort(index, sub, WRONG_LENGTH)
        number = entry.number_of(value[:size])
        if entry.high is not None and number > entry.high:
            return _abort(index, sub, TOO_HIGH)
        if entry.low is not None and number < entry.low:
            return _abort(index, sub, TOO_LOW)
        code = self._written(index, sub, number)
        if code:
            return _abort(index, sub, code)
        entry.value = number
        return struct.pack("<BHB4x", 0x60, index, sub)


def _abort(index: int, sub: int, code: int) -> bytes:
    return struct.pack("<BHBI", 0x80, index, sub, code)
