"""What only the master of a bus says: heard from somebody else, two programs command the same drives."""

from __future__ import annotations

from collections.abc import Container

from hognose.drive.configuration import ALL_CONTROL, CONTROL, DECELERATION, SET_POINT
from hognose.drive.frames import Frame
from hognose.drive.network_spec import MASTER
from hognose.drive.sdo import REQUEST

_NMT, _SYNC, _HEARTBEAT = 0x000, 0x080, 0x700
#: Base identifiers of what drives are told.
_TOLD = (SET_POINT, DECELERATION, CONTROL)


def commanding(frame: Frame, nodes: Container[int]) -> str:
    """What somebody who sends this frame does to the drives with these nodes, in words; empty if it is no command."""
    cob, data = frame
    base, node = cob & 0x780, cob & 0x7F
    if cob == _SYNC and len(data) <= 1:
        return "sends SYNC (0x080)"
    if cob == _NMT:
        return "starts, stops or resets nodes (0x000)"
    if cob == _HEARTBEAT + MASTER:
        return f"sends the heartbeats of node {MASTER}, the master's (0x{cob:03X})"
    if cob == ALL_CONTROL or (base in _TOLD and node in nodes) or (base == REQUEST and node):
        return f"tells drives what to do (0x{cob:03X})"
    return ""
