"""A CAN frame as CANopen uses it."""

from __future__ import annotations

from typing import NamedTuple


class Frame(NamedTuple):
    """An identifier of 11 bits, and up to 8 bytes."""

    cob: int
    data: bytes
