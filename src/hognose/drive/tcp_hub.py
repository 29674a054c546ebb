"""The hub of a CAN bus over TCP on this machine: frames in order, none lost.

A frame is 16 bytes: identifier (32 bits), how many bytes of data (8), three unused, and 8 bytes of data. A hub gives
every frame to all others that are connected, as a bus does.

A hub says its bitrate first, and who connects may say its own. If it is another one, nobody hears it, and it hears
nobody: there are error frames alone, as on a bus.
"""

from __future__ import annotations

import contextlib
import select
import socket
import struct
from collections.abc import Sequence

from hognose.drive.frames import Frame
from hognose.errors import InputError

_FORM = struct.Struct("<IB3x8s")
#: What is read from a socket at a time, bytes.
AT_ONCE = 1 << 16
_LAST_PORT = 65535


#: Identifiers that are no frames: an error frame (as in SocketCAN), and a bitrate that is said (in 4 bytes).
ERROR, BITRATE = 0x2000_0000, 0x4000_0000


def packed(frames: Sequence[Frame]) -> bytes:
    """Frames as bytes."""
    return b"".join(_FORM.pack(cob, len(data), data) for cob, data in frames)


def unpacked(data: bytes) -> tuple[list[Frame], bytes]:
    """The frames in some bytes, and the bytes of one that is not whole yet."""
    whole = len(data) // _FORM.size * _FORM.size
    found = [Frame(cob, body[:size]) for cob, size, body in _FORM.iter_unpack(data[:whole])]
    return found, data[whole:]


class Hub:
    """Gives the frames of everyone who is connected to all others; drives beside it are reached by `give`."""

    def __init__(self, port: int = 0, bitrate: int = 1_000_000) -> None:
        """Listen on 127.0.0.1, on a free port unless one is given, as a bus with a bitrate (bit/s).

        Raises
        ------
        InputError
            The port cannot be listened on.
        """
        if not 0 <= port <= _LAST_PORT:
            raise InputError(f"port {port}: expected a number from 1 to {_LAST_PORT}, or 0 for a free one")
        try:
            self._listener = socket.create_server(("127.0.0.1", port))
        except OSError as error:
            raise InputError(f"port {port}: cannot be listened on: {error.strerror}. Take another") from None
        self.port: int = self._listener.getsockname()[1]
        self.bitrate = bitrate
        self._rests: dict[socket.socket, bytes] = {}
        self._strange: set[socket.socket] = set()

    def take(self, timeout: float) -> list[Frame]:
        """The frames that came, in order, after waiting for so long (s) at most for the first."""
        found: list[Frame] = []
        ready = select.select([self._listener, *self._rests], [], [], timeout)[0]
        for one in ready:
            if one is self._listener:
                other = self._listener.accept()[0]
                other.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._rests[other] = b""
                with contextlib.suppress(OSError):
                    other.sendall(packed([Frame(BITRATE, self.bitrate.to_bytes(4, "little"))]))
            else:
                found += self._from(one)
        return found

    def _from(self, one: socket.socket) -> list[Frame]:
        data = b""
        with contextlib.suppress(OSError):
            data = one.recv(AT_ONCE)
        if not data:
            self._leave(one)
            return []
        frames, self._rests[one] = unpacked(self._rests[one] + data)
        said = [int.from_bytes(data, "little") for cob, data in frames if cob == BITRATE]
        frames = [frame for frame in frames if frame.cob != BITRATE]
        if any(bitrate != self.bitrate for bitrate in said):
            self._strange.add(one)
        if one in self._strange:
            with contextlib.suppress(OSError):
                one.sendall(packed([Frame(ERROR, bytes(8))] * len(frames)))
            return []
        self.give(frames, sender=one)
        return frames

    def give(self, frames: Sequence[Frame], sender: socket.socket | None = None) -> None:
        """Send frames to all that are connected, but to their sender."""
        if not frames:
            return
        data = packed(frames)
        for one in [each for each in self._rests if each is not sender and each not in self._strange]:
            try:
                one.sendall(data)
            except OSError:
                self._leave(one)

    def _leave(self, one: socket.socket) -> None:
        del self._rests[one]
        self._strange.discard(one)
        one.close()

    def close(self) -> None:
        """Let everyone go."""
        for one in list(self._rests):
            self._leave(one)
        self._listener.close()
