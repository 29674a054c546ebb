"""One connection to a run: of a newcomer until the token came, of a follower then. Nothing here waits."""

from __future__ import annotations

import socket
from typing import Any

from hognose.drive.live.frames import LONGEST_ASKED, NotUnderstoodError, Reader, message_frame, word
from hognose.drive.live.outbox import Outbox

#: Read from a socket at a time; and what the system keeps of what is sent: the rest waits here, and may be left out.
_AT_ONCE, _SYSTEM_KEEPS = 1 << 14, 1 << 18
#: So many messages are sent at a time.
_MESSAGES = 64


class Visitor:
    """A connection.

    Attributes
    ----------
    socket
    until : s
        When it is closed: a newcomer without a token, or one that was told to leave; None for a follower.
    outbox
        What waits for a follower; None for a newcomer.
    who
        How a follower is called.
    leaves
        Whether it is told what is left, and nothing more is heard.
    gone
        Whether the connection has ended, and is to be closed.
    """

    def __init__(self, connection: socket.socket, until: float) -> None:
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SYSTEM_KEEPS)
        self.socket = connection
        self.until: float | None = until
        self.outbox: Outbox | None = None
        self.who = ""
        self.leaves = self.gone = False
        self._reader, self._outgoing, self._shut = Reader(LONGEST_ASKED), bytearray(), False

    def hear(self) -> list[dict[str, Any]]:
        """The words that came; one who sends anything else is gone."""
        try:
            data = self.socket.recv(_AT_ONCE)
        except (BlockingIOError, InterruptedError):
            return []
        except OSError:
            data = b""
        if not data:
            self.gone = True
        if not data or self.leaves:
            return []
        try:
            found = self._reader.take(data)
        except NotUnderstoodError:
            found = [None]
        words = [each for each in found if isinstance(each, dict)]
        self.gone = len(words) < len(found)
        return words

    def say(self, said: dict[str, Any]) -> None:
        """Send a word behind what was begun."""
        self._outgoing += word(said)

    def leave(self, said: dict[str, Any], until: float) -> None:
        """Send a word, and end the connection once that has arrived, or at a time (s)."""
        self.say(said)
        self.leaves, self.outbox, self.until = True, None, until

    @property
    def has_more(self) -> bool:
        """Whether something is to be sent."""
        return bool(self._outgoing) or (self.leaves and not self._shut)

    @property
    def is_idle(self) -> bool:
        """Whether all that waited was handed on."""
        return not self._outgoing and not self.outbox

    def fill(self) -> bool:
        """Take messages out of the outbox if all before is sent; whether there were any. The outbox must be locked."""
        if self._outgoing or not self.outbox:
            return False
        left_out = self.outbox.told()
        if any(left_out.values()):
            self.say({"kind": "left out", **left_out})
        for _, message in self.outbox.take(_MESSAGES):
            self._outgoing += message_frame(*message)
        return True

    def send(self) -> None:
        """Send as much as can be sent now; then end the sending side, if it is to leave."""
        try:
            if self._outgoing:
                del self._outgoing[: self.socket.send(self._outgoing)]
            if self.leaves and not self._outgoing and not self._shut:
                # Closed at once, with something unread, the system might throw away what was sent last.
                self._shut = True
                self.socket.shutdown(socket.SHUT_WR)
        except (BlockingIOError, InterruptedError):
            pass
        except OSError:
            self.gone = True
