"""Following a run from another program: what it records, as it does, and asking for what is wanted."""

from __future__ import annotations

import select
import socket
from types import TracebackType
from typing import Any, Self

from hognose.drive.live.address import Address
from hognose.drive.live.frames import LONGEST_TOLD, PROTOCOL, Message, NotUnderstoodError, Reader, word
from hognose.drive.wishes import Want
from hognose.errors import InputError

#: A run answers within this (s).
_PATIENCE = 5.0
_AT_ONCE = 1 << 18


class Following:
    """Follows a run.

    Parameters
    ----------
    address
        Where it is followed.
    who
        How the follower is called where the run asks whether to do what it wants; 40 letters at most.

    Attributes
    ----------
    run
        What the run says of itself; docs/watch.md lists it.
    ended
        Whether the run said that it is over.
    lost
        Whether the connection ended without that: the program that ran the plan is gone.

    Raises
    ------
    InputError
        The program is gone, another one answers there, or it does not let this one follow.
    """

    def __init__(self, address: Address, who: str = "a program") -> None:
        self.address, self.ended, self.lost = address, False, False
        try:
            self._socket = socket.create_connection(("127.0.0.1", address.port), timeout=_PATIENCE)
        except OSError:
            raise InputError(stale(address)) from None
        self._reader = Reader(LONGEST_TOLD)
        self._waiting: list[Message | dict[str, Any]] = []
        try:
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._socket.sendall(word({"token": address.token, "protocol": PROTOCOL, "who": who}))
            self.run = self._first()
        except BaseException as error:
            self._socket.close()
            if isinstance(error, OSError | NotUnderstoodError):
                if address.is_gone:  # killed between the connection and its first word
                    raise InputError(stale(address)) from None
                raise InputError(f"{address.file}: what answers there is no run of Hognose: {error}") from None
            raise
        self._socket.setblocking(False)

    def _first(self) -> dict[str, Any]:
        while not self._waiting:
            data = self._socket.recv(_AT_ONCE)
            if not data:
                raise NotUnderstoodError("it closed the connection")
            self._waiting = self._reader.take(data)
        said = self._waiting.pop(0)
        if isinstance(said, dict) and said.get("kind") == "refused":
            raise InputError(f"{self.address.record}: the run cannot be followed: {said.get('words')}")
        if not isinstance(said, dict) or said.get("kind") != "run" or said.get("protocol") != PROTOCOL:
            raise NotUnderstoodError("it says something else at first")
        return said

    def fileno(self) -> int:
        """Of the socket."""
        return self._socket.fileno()

    def take(self, timeout: float) -> list[Message | dict[str, Any]]:
        """What came: messages of the record, and words; waits so long (s) at most for the first.

        Words have a `kind`: "accepted" or "not accepted" answer `ask`, "left out" says how many cycles and pictures
        were not sent since this follower is slow, "end" is the last.
        """
        found, self._waiting = self._waiting, []
        if not found and not self.lost and select.select([self._socket], [], [], timeout)[0]:
            found = self._received()
        self.ended = self.ended or any(isinstance(each, dict) and each.get("kind") == "end" for each in found)
        self.lost = self.lost and not self.ended
        return found

    def _received(self) -> list[Message | dict[str, Any]]:
        try:
            data = self._socket.recv(_AT_ONCE)
            self.lost = not data
            return self._reader.take(data)
        except (BlockingIOError, InterruptedError):
            return []
        except (OSError, NotUnderstoodError):
            self.lost = True
            return []

    def ask(self, want: Want) -> None:
        """Ask for something; what moves the arm is confirmed at the terminal of the run."""
        try:
            self._socket.setblocking(True)
            self._socket.settimeout(_PATIENCE)
            self._socket.sendall(word({"want": want.value}))
        except OSError:
            self.lost = not self.ended
        finally:
            self._socket.setblocking(False)

    @property
    def is_there(self) -> bool:
        """Whether the run still answers, also where this connection was lost; asks it, with a connection of its own."""
        try:
            # Not only connects: a program that is being killed may still listen when its connections are closed.
            Following(self.address).close()
        except InputError:
            return False
        return True

    def close(self) -> None:
        """Leave; the run goes on."""
        self._socket.close()

    def __enter__(self) -> Self:
        """Itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Leave."""
        self.close()


def stale(address: Address) -> str:
    """What is to be said where nobody listens any more."""
    gone = f"its program (process {address.pid}) is gone" if address.is_gone else "nobody listens there"
    return (
        f"{address.record}: the run is not followed any more, {gone}; its end was not recorded. `hognose log "
        f"{address.record}` reads what was. Remove {address.file.name}"
    )
