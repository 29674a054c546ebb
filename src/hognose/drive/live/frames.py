"""What a run and its followers send each other: frames with their length in front, of two kinds.

A frame is its length in bytes (32 bits, little-endian, of all that comes behind it), its kind (a byte), and its
content. A word is JSON. A message is one of the record: the number of its topic (a byte; the opening word lists
topics), its log time (64 bits, ns since 1970), and its bytes as they are in the record.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from typing import Any, NamedTuple

from hognose.drive.record.messages import TOPICS

#: Version of all this; a run and a follower have to agree.
PROTOCOL = 1
#: Kinds of frames.
WORD, MESSAGE = ord("J"), ord("M")
#: The longest frame that a run takes, and that a follower takes, in bytes.
LONGEST_ASKED, LONGEST_TOLD = 4096, 1 << 26

_LENGTH, _MESSAGE = struct.Struct("<I"), struct.Struct("<IBBQ")
_TOPICS = tuple(TOPICS)
_NUMBERS = {topic: number for number, topic in enumerate(_TOPICS)}


class Message(NamedTuple):
    """A message of the record: topic, log time (ns since 1970), content (CDR)."""

    topic: str
    stamp: int
    data: bytes


class NotUnderstoodError(ValueError):
    """Bytes that are no frames of this protocol."""


def word(said: Mapping[str, Any]) -> bytes:
    """The frame of a word."""
    body = json.dumps(said).encode()
    return _LENGTH.pack(1 + len(body)) + bytes([WORD]) + body


def message_frame(topic: str, stamp: int, data: bytes) -> bytes:
    """The frame of a message."""
    return _MESSAGE.pack(10 + len(data), MESSAGE, _NUMBERS[topic], stamp) + data


class Reader:
    """Takes frames out of bytes as they come.

    Parameters
    ----------
    longest
        In bytes; a longer frame is none, before any of it is kept.
    """

    def __init__(self, longest: int) -> None:
        self._longest, self._rest = longest, bytearray()

    def take(self, data: bytes) -> list[Message | dict[str, Any]]:
        """The frames that are whole with these bytes: messages, and words as their JSON objects.

        Raises
        ------
        NotUnderstoodError
            They are no frames.
        """
        self._rest += data
        found, at = [], 0
        while len(self._rest) - at >= _LENGTH.size:
            (length,) = _LENGTH.unpack_from(self._rest, at)
            if not 1 <= length <= self._longest:
                raise NotUnderstoodError(f"a frame of {length:,} bytes; expected from 1 to {self._longest:,}")
            end = at + _LENGTH.size + length
            if len(self._rest) < end:
                break
            found.append(_read(bytes(self._rest[at:end])))
            at = end
        del self._rest[:at]
        return found


def _read(frame: bytes) -> Message | dict[str, Any]:
    kind = frame[_LENGTH.size]
    if kind == WORD:
        try:
            said = json.loads(frame[_LENGTH.size + 1 :])
        except (ValueError, RecursionError):
            raise NotUnderstoodError("a word that is no JSON") from None
        if not isinstance(said, dict):
            raise NotUnderstoodError("a word that is no JSON object")
        return said
    if kind != MESSAGE or len(frame) < _MESSAGE.size:
        raise NotUnderstoodError(f"a frame of the kind {kind}")
    _, _, number, stamp = _MESSAGE.unpack_from(frame)
    if number >= len(_TOPICS):
        raise NotUnderstoodError(f"a message of the topic {number}")
    return Message(_TOPICS[number], stamp, frame[_MESSAGE.size :])
