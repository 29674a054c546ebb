"""What the host keeps of its talk with a board: which messages are still unanswered, and how many were damaged."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from hognose.drive.clock import Clock
from hognose.drive.serial_slider.framing import Decoder, Message, framed
from hognose.drive.serial_slider.line import Line
from hognose.drive.serial_slider.messages import BoardState, Kind, Result, Status, Welcome

#: A board answers within this (s), or its answer no longer counts.
ANSWER = 0.06
#: More damaged or lost messages than this within a while (s) are too many, and so are some LATCHes in a row.
MOST_BAD, WHILE, IN_A_ROW = 3, 1.0, 2


class _Sent(NamedTuple):
    kind: Kind
    time: float


class Link:
    """The host's end of the line.

    Attributes
    ----------
    status
        What the board said last; None before it said anything.
    welcome
        Its answer to the last HELLO; None until it comes.
    echoed
        How many of the host's own messages came back.
    valid
        How many messages of the board were whole.
    """

    def __init__(self, line: Line, clock: Clock) -> None:
        self.line, self._clock = line, clock
        self._number = 0
        self._open()

    def _open(self) -> None:
        self._decoder = Decoder()
        self._sent: dict[int, _Sent] = {}
        self._bad: deque[float] = deque()
        self._before: tuple[int, int] | None = None
        self._missed, self._seen_bad = 0, 0
        self.status: Status | None = None
        self.welcome: Welcome | None = None
        self.echoed = self.valid = 0

    def open(self) -> None:
        """Open the line anew; a `LineError` if it cannot be opened."""
        self.line.open()
        self._open()

    @property
    def garbage(self) -> int:
        """How many bytes came that belong to no message."""
        return self._decoder.skipped

    def send(self, kind: Kind, payload: bytes = b"") -> int:
        """Send a message; its number. A `LineError` if the line does not take it."""
        self._number = (self._number + 1) % 256
        if kind is not Kind.TARGET:  # the answer to its LATCH says whether it came
            self._sent[self._number] = _Sent(kind, self._clock.now())
        if kind is Kind.HELLO:
            self.welcome = None
        self.line.write(framed(Message(kind, self._number, payload)))
        return self._number

    def receive(self) -> list[tuple[Kind, Status]]:
        """The board's answers since, each with the kind of what it answers; a `LineError` if the line is gone."""
        now, found = self._clock.now(), []
        for message in self._decoder.feed(self.line.read(), now):
            if message.kind < Kind.WELCOME:
                self.echoed += 1
                continue
            self.valid += 1
            sent = self._sent.get(message.number)
            if sent is None:
                continue  # an answer to somebody else, or too late
            if message.kind == Kind.WELCOME and sent.kind is Kind.HELLO:
                self.welcome = Welcome.of(message.payload)
                del self._sent[message.number]
            elif message.kind == Kind.STATUS and (status := Status.of(message.payload)) is not None:
                del self._sent[message.number]
                self._note(sent.kind, status, now)
                found.append((sent.kind, status))
        self._note_damage(now)
        return found

    def _note(self, kind: Kind, status: Status, now: float) -> None:
        """Keep what an answer says of the line."""
        self.status = status
        if self._before is not None:
            fresh = (status.bad - self._before[0]) % 65536 + (status.lost - self._before[1]) % 65536
            self._bad.extend([now] * min(fresh, MOST_BAD + 1))
        self._before = (status.bad, status.lost)
        if kind is Kind.LATCH and status.state is BoardState.ENABLED:
            lost = status.result is Result.NO_SUCH_TARGET
            self._missed = self._missed + 1 if lost else 0

    def _note_damage(self, now: float) -> None:
        """Keep what was damaged on its way here, and what was not answered in time."""
        fresh, self._seen_bad = self._decoder.bad - self._seen_bad, self._decoder.bad
        late = [number for number, sent in self._sent.items() if now - sent.time > ANSWER]
        for number in late:
            self._missed += self._sent.pop(number).kind is Kind.LATCH
        self._bad.extend([now] * min(fresh + len(late), MOST_BAD + 1))
        while self._bad and now - self._bad[0] > WHILE:
            self._bad.popleft()

    @property
    def is_bad(self) -> bool:
        """Whether too much was damaged or lost of late for the line to be trusted."""
        return len(self._bad) > MOST_BAD or self._missed >= IN_A_ROW

    def forgive(self) -> None:
        """Count damage anew: it was reported."""
        self._bad.clear()
        self._missed = 0
