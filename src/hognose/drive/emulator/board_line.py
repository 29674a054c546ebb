"""Serial lines to an emulated board: within the program in simulated time, or over TCP to another one."""

from __future__ import annotations

import contextlib
import select
import socket
from urllib.parse import urlsplit

from hognose.drive.clock import SimulatedClock
from hognose.drive.emulator.board import EmulatedBoard
from hognose.drive.serial_slider.line import LineError
from hognose.errors import InputError

#: What a port of pyserial is called that is a socket of this machine.
_SCHEME, _HERE = "socket", ("127.0.0.1", "localhost")
_BITS_OF_A_BYTE, _AT_ONCE = 10, 4096


class LocalLine:
    """See `hognose.drive.serial_slider.line.Line`: every byte takes its time both ways.

    Attributes
    ----------
    unplugged
        Set it, and nothing goes over it any more.
    """

    def __init__(self, board: EmulatedBoard, clock: SimulatedClock, baud: int) -> None:
        self.board, self._clock, self._byte_s = board, clock, _BITS_OF_A_BYTE / baud
        self.unplugged = False
        self._there: list[tuple[float, bytes]] = []
        self._back: list[tuple[float, bytes]] = []
        clock.attach(self._pass)

    def open(self) -> None:
        """See `Line.open`."""
        self._there, self._back = [], []
        self._check()

    def write(self, data: bytes) -> None:
        """See `Line.write`."""
        self._check()
        self._put(self._there, data)

    def read(self) -> bytes:
        """See `Line.read`."""
        self._check()
        return b"".join(_due(self._back, self._clock.now()))

    def close(self) -> None:
        """See `Line.close`."""
        self._there, self._back = [], []

    def _check(self) -> None:
        if self.unplugged:
            raise LineError("its line is gone; is it unplugged?")

    def _put(self, way: list[tuple[float, bytes]], data: bytes) -> None:
        """Bytes arrive one after another, behind those that are on their way."""
        if data:
            begin = max(self._clock.now(), way[-1][0] if way else 0.0)
            way.append((begin + self._byte_s * len(data), data))

    def _pass(self, now: float) -> None:
        for data in _due(self._there, now):
            if not self.unplugged:
                self.board.hear(data, now)
        self._put(self._back, self.board.say(now))


def _due(way: list[tuple[float, bytes]], now: float) -> list[bytes]:
    """Take what has arrived by now (s)."""
    found = []
    while way and way[0][0] <= now + 1e-12:
        found.append(way.pop(0)[1])
    return found


def port_of(url: str) -> int:
    """The port of this machine that a `socket://127.0.0.1:PORT` means; 0, for a free one, if it means none."""
    try:
        parts = urlsplit(url)
        return (parts.port or 0) if parts.scheme == _SCHEME and parts.hostname in _HERE else 0
    except ValueError:
        return 0


class BoardServer:
    """The line of an emulated board as a TCP port of this machine, for one host at a time, as a line has two ends.

    Attributes
    ----------
    url
        What a network file has as `slider.port`.
    """

    def __init__(self, board: EmulatedBoard, port: int = 0) -> None:
        """Listen on 127.0.0.1, on a free port unless one is given.

        Raises
        ------
        InputError
            The port cannot be listened on.
        """
        self._board, self._rest = board, b""
        self._other: socket.socket | None = None
        try:
            self._listener = socket.create_server(("127.0.0.1", port))
        except (OSError, OverflowError) as error:
            words = getattr(error, "strerror", None) or error
            raise InputError(f"slider.port: port {port} cannot be listened on: {words}. Take another") from None
        self.url = f"{_SCHEME}://127.0.0.1:{self._listener.getsockname()[1]}"

    def serve(self, now: float) -> None:
        """Pass on what came, and what the board says by now (s); never waits."""
        if select.select([self._listener], [], [], 0)[0]:
            self._take_one()
        if self._other is None:
            self._board.say(now)
            return
        try:
            data = self._other.recv(_AT_ONCE)
        except BlockingIOError:
            pass
        except OSError:
            self._leave()
        else:
            if data:
                self._board.hear(data, now)
            else:
                self._leave()
        self._give(self._board.say(now))

    def _take_one(self) -> None:
        """Whoever comes now is the host; one that was there before is let go, as a plug is pulled."""
        with contextlib.suppress(OSError):
            other = self._listener.accept()[0]
            self._leave()
            other.setblocking(False)
            other.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._other = other

    def _give(self, data: bytes) -> None:
        self._rest += data
        if self._rest and self._other is not None:
            try:
                self._rest = self._rest[self._other.send(self._rest) :]
            except BlockingIOError:
                return
            except OSError:
                self._leave()

    def _leave(self) -> None:
        other, self._other, self._rest = self._other, None, b""
        if other is not None:
            other.close()

    def close(self) -> None:
        """Let everyone go."""
        self._leave()
        self._listener.close()
