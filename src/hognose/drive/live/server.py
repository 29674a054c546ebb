"""The server of a run: followers that have the token get the messages of the record, and ask for what they want.

It listens on 127.0.0.1 only. Nothing is said to who has not the token. What is recorded is put into the outbox of each
follower by the thread of the run, which never waits for one; everything else is done by a thread of the server.
"""

from __future__ import annotations

import hmac
import secrets
import selectors
import socket
import threading
import time
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from hognose.drive.live.frames import PROTOCOL, Message
from hognose.drive.live.outbox import EVENTS, Numbered, Outbox
from hognose.drive.live.visitor import Visitor
from hognose.drive.wishes import Want, Wishes
from hognose.errors import InputError
from hognose.plain_text import is_plain

#: A follower may call itself by so many letters.
_LONGEST_NAME = 40
#: What was recorded is handed on so much later (s): a cycle is recorded just before the next set-points go out, and the
#: thread of the run is not to share the interpreter with anybody then. It waits for drives soon after.
_LATER = 5e-3


@dataclass(frozen=True)
class Limits:
    """What a server keeps, and how long it waits.

    Attributes
    ----------
    followers, newcomers
        So many at most; newcomers are those who have not said the token yet.
    history
        So many events are kept for those who come later.
    waiting_events
        A follower for whom more wait is closed.
    waiting_bytes
        Of cycles and pictures that wait for a follower; the oldest are left out.
    token_s : s
        A newcomer has so long to say the token.
    farewell_s : s
        So long followers have to read what is left when the run is over.
    """

    followers: int = 8
    newcomers: int = 8
    history: int = 1000
    waiting_events: int = 1000
    waiting_bytes: int = 4_000_000
    token_s: float = 5.0
    farewell_s: float = 2.0


class Live:
    """Serves the messages of a record while it is written.

    Parameters
    ----------
    opening
        What followers are told of the run at first, as JSON can hold it.
    wishes
        Where what followers want is put.
    limits

    Attributes
    ----------
    port
        On 127.0.0.1.
    token

    Raises
    ------
    InputError
        No port can be listened on.
    """

    def __init__(self, opening: Mapping[str, Any], wishes: Wishes, limits: Limits | None = None) -> None:
        self._opening, self._wishes, self._limits = dict(opening), wishes, limits or Limits()
        self.token = secrets.token_urlsafe(32)
        try:
            self._listener = socket.create_server(("127.0.0.1", 0))
        except OSError as error:
            raise InputError(f"127.0.0.1: the run cannot be followed, no port is free: {error.strerror}") from None
        self.port: int = self._listener.getsockname()[1]
        self._listener.setblocking(False)
        self._bell, self._rings = socket.socketpair()
        self._bell.setblocking(False)
        self._rings.setblocking(False)
        # For what both threads use; held for some steps of Python, and for no system call.
        self._lock = threading.Lock()
        self._history: deque[Numbered] = deque(maxlen=self._limits.history)
        self._latest: dict[str, Numbered] = {}
        self._outboxes: list[Outbox] = []
        self._recorded, self._rung = 0, False
        self._visitors: list[Visitor] = []
        self._came, self._ends = 0, False
        self._selector = selectors.DefaultSelector()
        for each in (self._listener, self._rings):
            self._selector.register(each, selectors.EVENT_READ)
        self._thread = threading.Thread(target=self._serve, name="hognose-live", daemon=True)
        self._thread.start()

    @property
    def is_followed(self) -> bool:
        """Whether anybody follows."""
        return bool(self._outboxes)

    def take(self, topic: str, stamp: int, data: bytes) -> None:
        """A message of the record, as it is there; one thread may call this. Never waits for a follower."""
        with self._lock:
            one = Numbered(self._recorded, Message(topic, stamp, data))
            self._recorded += 1
            if topic == EVENTS:
                self._history.append(one)
            else:
                self._latest[topic] = one
            for outbox in self._outboxes:
                outbox.put(one)
            rings = bool(self._outboxes) and not self._rung
            self._rung = self._rung or rings
        if rings:
            self._ring()

    def close(self) -> None:
        """Tell followers that the run is over, once they have all that was recorded; those who do not read are left."""
        self._ends = True
        self._ring()
        self._thread.join()

    def _ring(self) -> None:
        with suppress(OSError):  # full: it rings already
            self._bell.send(b"\0")

    def _serve(self) -> None:
        try:
            while not self._ends:
                self._turn()
            self._say_farewell()
        finally:
            with self._lock:
                self._outboxes = []
            for each in self._visitors:
                each.socket.close()
            for each in (self._listener, self._bell, self._rings):
                each.close()
            self._selector.close()

    def _say_farewell(self) -> None:
        end = time.monotonic() + self._limits.farewell_s
        while self._visitors and time.monotonic() < end:
            for visitor in self._visitors:
                if visitor.outbox is None and not visitor.leaves:
                    visitor.gone = True  # a newcomer
                elif not visitor.leaves and visitor.is_idle:
                    visitor.leave({"kind": "end"}, end)
            self._turn(0.05)

    def _turn(self, longest: float | None = None) -> None:
        """Wait until there is something to do, at most so long (s), and do it."""
        for visitor in self._visitors:
            writes = selectors.EVENT_WRITE if visitor.has_more else 0
            self._selector.modify(visitor.socket, selectors.EVENT_READ | writes, visitor)
        ends = [each.until for each in self._visitors if each.until is not None]
        if ends:
            left = max(0.0, min(ends) - time.monotonic())
            longest = left if longest is None else min(left, longest)
        for key, ready in self._selector.select(longest):
            if key.fileobj is self._listener:
                self._welcome()
            elif key.fileobj is self._rings:
                with suppress(OSError):
                    self._rings.recv(4096)
                time.sleep(_LATER)
            elif ready & selectors.EVENT_READ:
                for said in key.data.hear():
                    self._answer(key.data, said)
        self._hand_on()
        now = time.monotonic()
        for visitor in list(self._visitors):
            if visitor.gone or (visitor.until is not None and now >= visitor.until):
                self._dismiss(visitor)

    def _hand_on(self) -> None:
        """Send to each what waits for it."""
        with self._lock:
            self._rung = False
        for visitor in self._visitors:
            visitor.send()
            while True:
                with self._lock:
                    if visitor.outbox is not None and visitor.outbox.overflows:
                        visitor.gone = True
                    more = not visitor.gone and visitor.fill()
                if not more:
                    break
                visitor.send()

    def _welcome(self) -> None:
        try:
            connection = self._listener.accept()[0]
        except OSError:
            return
        newcomers = [each for each in self._visitors if each.outbox is None and not each.leaves]
        if len(newcomers) >= self._limits.newcomers:
            self._dismiss(newcomers[0])
        visitor = Visitor(connection, time.monotonic() + self._limits.token_s)
        self._visitors.append(visitor)
        self._selector.register(connection, selectors.EVENT_READ, visitor)

    def _dismiss(self, visitor: Visitor) -> None:
        self._visitors.remove(visitor)
        self._selector.unregister(visitor.socket)
        visitor.socket.close()
        with self._lock:
            self._outboxes = [each.outbox for each in self._visitors if each.outbox is not None]

    def _answer(self, visitor: Visitor, said: dict[str, Any]) -> None:
        if visitor.leaves:
            return
        if visitor.outbox is None:
            self._let_in(visitor, said)
            return
        try:
            want = Want(said.get("want"))
        except ValueError:
            words = f"expected one of {', '.join(each.value for each in Want)} as what is wanted"
            visitor.say({"kind": "not accepted", "words": words})
            return
        self._wishes.put(want, visitor.who)
        visitor.say({"kind": "accepted", "want": want.value, "confirmed_at_terminal": want.starts_motion})

    def _let_in(self, visitor: Visitor, said: dict[str, Any]) -> None:
        """Make a follower of a newcomer who has the token; another one is told that it has not."""
        words, token = "", said.get("token")
        if not isinstance(token, str) or not hmac.compare_digest(token.encode("utf-8", "replace"), self.token.encode()):
            words = "this is not the token of the run; it is in the file *.live.json beside the record"
        elif said.get("protocol") != PROTOCOL:
            words = f"the run speaks version {PROTOCOL} of the protocol; follow it with the same version of Hognose"
        elif len(self._outboxes) >= self._limits.followers:
            words = f"{self._limits.followers} programs follow this run already; end one of them"
        if words:
            visitor.leave({"kind": "refused", "words": words}, time.monotonic() + self._limits.farewell_s)
            return
        self._came += 1
        name = said.get("who")
        sound = isinstance(name, str) and len(name) <= _LONGEST_NAME and is_plain(name)
        # Never `terminal`: what makes the arm move is done at once if it comes from there.
        visitor.who = f"follower {self._came}" + (f" ({name})" if sound and name else "")
        visitor.until = None
        with self._lock:
            begun = sorted([*self._history, *self._latest.values()])
            visitor.outbox = Outbox(self._limits.waiting_bytes, self._limits.waiting_events, begun)
            self._outboxes = [*self._outboxes, visitor.outbox]
        visitor.say({"kind": "run", "protocol": PROTOCOL, **self._opening, "before": len(begun)})
