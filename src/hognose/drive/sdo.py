"""Reading and writing the object dictionaries of many drives at the same time (CiA 301, 7.2.4: SDO).

What is to be done with one drive is a script: a generator that yields requests, and gets what was read. All scripts go
on at once, each waiting for its own drive, in one thread. So 36 drives take hardly longer than one.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Generator, Mapping
from typing import NamedTuple

from hognose.drive.bus import Bus
from hognose.drive.clock import Clock
from hognose.drive.frames import Frame
from hognose.errors import HognoseError

#: Base identifiers of requests and replies; the node is added.
REQUEST, REPLY = 0x600, 0x580
#: A drive answers within this (s), or is asked again, so often.
PATIENCE, TRIES = 0.25, 3
#: How long (s) the bus is not looked at while all drives are waited for.
_PAUSE = 0.0005
#: What abort codes mean (CiA 301, table 22).
ABORTS = {
    0x05030000: "the toggle bit did not change",
    0x05040000: "it took too long",
    0x05040001: "it does not know the command",
    0x06010000: "the object cannot be accessed so",
    0x06010001: "the object can only be written",
    0x06010002: "the object can only be read",
    0x06020000: "there is no such object",
    0x06040041: "the object cannot be mapped to a PDO",
    0x06040042: "the PDO would become too long",
    0x06060000: "its hardware failed",
    0x06070010: "the value has another length",
    0x06070012: "the value is too long",
    0x06070013: "the value is too short",
    0x06090011: "there is no such sub-index",
    0x06090030: "the value is not allowed",
    0x06090031: "the value is too high",
    0x06090032: "the value is too low",
    0x08000020: "it cannot store it",
    0x08000022: "it cannot in its present state",
}


class Request(NamedTuple):
    """Read an entry of an object dictionary, or write bytes to it."""

    object_index: int
    sub: int
    value: bytes | None = None

    def __str__(self) -> str:
        return f"0x{self.object_index:04X}:{self.sub}"


#: What is to be done with one drive; it ends by itself, or with an `SdoError`.
Script = Generator[Request, bytes, "bool | None"]


class SdoError(HognoseError):
    """A drive did not do what it was asked for; says what and why."""


class _Waiting:
    """A script that waits for its drive."""

    def __init__(self, node: int, script: Script) -> None:
        self.node, self.script = node, script
        self.request: Request | None = None
        self.tries, self.since, self.toggle = 0, 0.0, 0
        self.read: bytearray | None = None
        self.error = ""

    def begin(self, request: Request | None, now: float) -> list[Frame]:
        self.request, self.tries, self.read = request, 0, None
        return [] if request is None else self.ask(now)

    def ask(self, now: float) -> list[Frame]:
        """The frame that asks for what is waited for."""
        assert self.request is not None, "only asked while it waits"
        self.since, self.tries, self.read = now, self.tries + 1, None
        index, sub, value = self.request
        if value is None:
            data = struct.pack("<BHB4x", 0x40, index, sub)
        else:
            data = struct.pack("<BHB", 0x23 | (4 - len(value)) << 2, index, sub) + value.ljust(4, b"\0")
        return [Frame(REQUEST + self.node, data)]

    def segment(self, now: float) -> list[Frame]:
        self.since = now
        return [Frame(REQUEST + self.node, bytes([0x60 | self.toggle << 4, 0, 0, 0, 0, 0, 0, 0]))]


def run_scripts(
    bus: Bus,
    clock: Clock,
    scripts: Mapping[int, Script],
    others: Callable[[Frame], None] = lambda frame: None,
    progress: Callable[[int, int], None] = lambda done, total: None,
    meanwhile: Callable[[], None] = lambda: None,
) -> dict[int, str]:
    """Run the scripts of nodes at the same time; what went wrong, in words, for each node where something did.

    Parameters
    ----------
    bus
    clock
    scripts
        By node.
    others
        Called with frames that are no replies to what is asked: heartbeats, emergencies, other nodes.
    progress
        Called with how many scripts are done, and how many there are.
    meanwhile
        Called again and again while drives are waited for: heartbeats must go on.
    """
    waiting, faults, done = {}, {}, 0
    for node, script in scripts.items():
        waiting[node] = _Waiting(node, script)
        bus.send(_advance(waiting[node], None, clock.now()))
    while waiting:
        for frame in bus.receive():
            one = waiting.get(frame.cob - REPLY)
            if one is None or one.request is None:
                others(frame)
            else:
                bus.send(_answered(one, frame, clock.now()))
        now = clock.now()
        for node, one in list(waiting.items()):
            if one.request is not None and now - one.since > PATIENCE:
                bus.send(_again(one, now))
            if one.request is None:
                done += 1
                progress(done, len(scripts))
                if one.error:
                    faults[node] = one.error
                del waiting[node]
        if waiting:
            clock.wait(clock.now() + _PAUSE)
            meanwhile()
    return faults


def _advance(one: _Waiting, reply: bytes | None, now: float) -> list[Frame]:
    """Go on with a script that got a reply, or begins."""
    try:
        request = next(one.script) if reply is None else one.script.send(reply)
    except StopIteration:
        request = None
    except SdoError as error:
        one.error, request = str(error), None
    return one.begin(request, now)


def _failed(one: _Waiting, words: str, now: float) -> list[Frame]:
    """Tell a script that its request failed; it may go on."""
    try:
        request = one.script.throw(SdoError(f"{one.request}: {words}"))
    except StopIteration:
        request = None
    except SdoError as error:
        one.error, request = str(error), None
    return one.begin(request, now)


def _again(one: _Waiting, now: float) -> list[Frame]:
    if one.tries >= TRIES:
        return _failed(one, f"no answer in {1e3 * PATIENCE * TRIES:.0f} ms", now)
    return one.ask(now)


def _answered(one: _Waiting, frame: Frame, now: float) -> list[Frame]:
    """What is sent after a reply."""
    request, data = one.request, frame.data.ljust(8, b"\0")
    assert request is not None, "it waits for one"
    command = data[0]
    if command == 0x80:
        if struct.unpack_from("<HB", data, 1) != (request.object_index, request.sub):
            return []  # of a request that was given up
        code = struct.unpack_from("<I", data, 4)[0]
        return _failed(one, f"{ABORTS.get(code, 'refused')} (abort code 0x{code:08X})", now)
    if one.read is not None and command & 0xE0 == 0x00:
        if command >> 4 & 1 != one.toggle:
            return []  # a repeated segment
        one.read += data[1 : 8 - (command >> 1 & 7)]
        one.toggle ^= 1
        return _advance(one, bytes(one.read), now) if command & 1 else one.segment(now)
    if struct.unpack_from("<HB", data, 1) != (request.object_index, request.sub):
        return []
    if request.value is not None:
        return _advance(one, b"", now) if command == 0x60 else []
    if command & 0xE2 == 0x42:  # all of it in this frame
        size = 4 - (command >> 2 & 3) if command & 1 else 4
        return _advance(one, data[4 : 4 + size], now)
    if command & 0xE2 == 0x40:
        one.read, one.toggle = bytearray(), 0
        return one.segment(now)
    return []
