"""Messages as ROS 2 puts them into bytes: little-endian plain CDR, as of the Object Management Group's DDSI-RTPS.

A value is aligned to its own size, counted from behind the four bytes that say how the rest is encoded. Sequences have
their length before them, strings as well, and these end with a zero byte.
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Plain CDR, little-endian, no options.
_HEAD = b"\x00\x01\x00\x00"


class Encoder:
    """Puts one value after the other into bytes.

    Attributes
    ----------
    data
        What there is so far.
    """

    def __init__(self, begun: bytes = _HEAD) -> None:
        self.data = bytearray(begun)

    def put(self, kind: str, value: float) -> None:
        """Append a number of a `struct` format, as "d"."""
        self._align(struct.calcsize(kind))
        self.data += struct.pack(f"<{kind}", value)

    def text(self, value: str) -> None:
        """Append a string; what is no letter, as in names of files that are not UTF-8, becomes a question mark."""
        raw = value.encode(errors="replace")
        self.put("I", len(raw) + 1)
        self.data += raw + b"\x00"

    def raw(self, value: bytes) -> None:
        """Append a sequence of bytes."""
        self.put("I", len(value))
        self.data += value

    def array(self, kind: str, values: ArrayLike) -> None:
        """Append a sequence of numbers of a numpy format without its byte order, as "f8"."""
        numbers = np.asarray(values, f"<{kind}")
        self.put("I", numbers.size)
        if numbers.size:
            self._align(numbers.itemsize)
            self.data += numbers.tobytes()

    def _align(self, size: int) -> None:
        self.data += bytes(-(len(self.data) - len(_HEAD)) % size)


class Decoder:
    """Takes one value after the other from the bytes of a message.

    Raises
    ------
    ValueError
        By all methods: the bytes end too early, or are not what was asked for.
    """

    def __init__(self, data: bytes) -> None:
        if data[:2] != _HEAD[:2] or len(data) < len(_HEAD):
            raise ValueError("not encoded as little-endian plain CDR")
        self._data, self._at = data, len(_HEAD)

    def get(self, kind: str) -> Any:
        """The next number, of a `struct` format."""
        size = struct.calcsize(kind)
        self._align(size)
        return struct.unpack(f"<{kind}", self._take(size))[0]

    def text(self) -> str:
        """The next string."""
        raw = self._take(self.get("I"))
        if not raw.endswith(b"\x00"):
            raise ValueError("a string without its end")
        return raw[:-1].decode()

    def raw(self) -> bytes:
        """The next sequence of bytes."""
        return self._take(self.get("I"))

    def array(self, kind: str) -> NDArray[Any]:
        """The next sequence of numbers (n,) of a numpy format."""
        count, dtype = self.get("I"), np.dtype(f"<{kind}")
        if not count:
            return np.zeros(0, dtype)
        self._align(dtype.itemsize)
        return np.frombuffer(self._take(count * dtype.itemsize), dtype)

    def _align(self, size: int) -> None:
        self._at += -(self._at - len(_HEAD)) % size

    def _take(self, size: int) -> bytes:
        taken = self._data[self._at : self._at + size]
        if len(taken) < size:
            raise ValueError("the message ends too early")
        self._at += size
        return taken
