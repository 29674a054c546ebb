"""What the host keeps of its talk with a board: which messages are still unanswered, and how many were damaged."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from hognose.drive.clock import Clock
from hognose.drive.serial_slider.framing import Decoder, Message, framed
from hognose.drive.serial_slider.line import Line
from hognose.drive.serial_slider.messages import BoardState, Kind, Result, Status, Welcome

#: More damaged or lost messages than this within a while (s) are too many, and so are some LATCHes in a row.
MOST_BAD, WHILE, IN_A_ROW = 3, 1.0, 2


class _Sent(NamedTuple):
    kind: Kind
    time: float
    order: int


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

    def __init__(self, line: Line, clock: Clock, patience: float) -> None:
        """Nothing is opened yet.

        Parameters
        ----------
        line
        clock
        patience : s
            An answer that takes longer no longer counts.
        """
        self.line, self._clock, self._patience = line, clock, patience
        self._number = self._order = 0
        self._forget()

    def _forget(self) -> None:
        self._decoder = Decoder()
        self._sent: dict[int, _Sent] = {}
        self._bad: deque[float] = deque()
        self._board_s: tuple[int, int] | None = None
        self._own_bad, self._missed, self._is_broken = 0, 0, False
        self.status: Status | None = None
        self.welcome: Welcome | None = None
        self.echoed = self.valid = 0

    def open(self) -> None:
        """Open the line anew; a `LineError` if it cannot be opened."""
        self.line.open()
        self._forget()

    @property
    def garbage(self) -> int:
        """How many bytes came that belong to no message."""
        return self._decoder.skipped

    def send(self, kind: Kind, payload: bytes = b"") -> int:
        """Send a message; its number. A `LineError` if the line does not take it."""
        self._number = (self._number + 1) % 256
        if kind is not Kind.TARGET:  # the answer to its LATCH says whether it came
            self._order += 1
            self._sent[self._number] = _Sent(kind, self._clock.now(), self._order)
        if kind is Kind.HELLO:
            self.welcome = None
        self.line.write(framed(Message(kind, self._number, payload)))
        return self._number

    def receive(self) -> list[tuple[Kind, Status]]:
        """The board's answers since, each with the kind of what it answers; a `LineError` if the line is gone."""
        now, found, unanswered, missing = self._clock.now(), [], 0, 0
        for message in self._decoder.feed(self.line.read(), now):
            if message.kind < Kind.WELCOME:
                self.echoed += 1
                continue
            self.valid += 1
            if message.number not in self._sent:
                continue  # an answer to somebody else, or too late
            unanswered += self._give_up_before(message.number)
            sent = self._sent.pop(message.number)
            if message.kind == Kind.WELCOME and sent.kind is Kind.HELLO:
                self.welcome = Welcome.of(message.payload)
            elif message.kind == Kind.STATUS and (status := Status.of(message.payload)) is not None:
                missing += self._note(sent.kind, status)
                found.append((sent.kind, status))
            else:
                unanswered += 1
        unanswered += self._give_up(lambda sent: now - sent.time > self._patience)
        damaged, self._own_bad = self._decoder.bad - self._own_bad, self._decoder.bad
        # What was damaged on its way is not answered either, and is missing at the other end: it is one message.
        self._bad.extend([now] * min(max(unanswered, missing, damaged), MOST_BAD + 1))
        while self._bad and now - self._bad[0] > WHILE:
            self._bad.popleft()
        return found

    def _note(self, kind: Kind, status: Status) -> int:
        """Keep what a board says; how many messages did not come to it since it said something before."""
        self.status, before = status, self._board_s
        self._board_s = (status.bad, status.lost)
        if kind is Kind.LATCH and status.state is BoardState.ENABLED:
            self._count_latch(status.result is not Result.NO_SUCH_TARGET)
        if before is None:
            return 0
        return max((status.bad - before[0]) % 65536, (status.lost - before[1]) % 65536)

    def _give_up_before(self, number: int) -> int:
        """Boards answer in order: what was sent before a message that is answered now, and was not, never will be."""
        first = self._sent[number]
        return self._give_up(lambda sent: sent.order < first.order)

    def _give_up(self, which: Callable[[_Sent], bool]) -> int:
        """Take messages for lost; how many."""
        lost = [number for number, sent in self._sent.items() if which(sent)]
        for number in lost:
            if self._sent.pop(number).kind is Kind.LATCH:
                self._count_latch(False)
        return len(lost)

    def _count_latch(self, came: bool) -> None:
        self._missed = 0 if came else self._missed + 1
        self._is_broken |= self._missed >= IN_A_ROW

    @property
    def is_bad(self) -> bool:
        """Whether too much was damaged or lost of late for the line to be trusted."""
        return len(self._bad) > MOST_BAD or self._is_broken

    def forgive(self) -> None:
        """Count damage anew: it was reported."""
        self._bad.clear()
        self._missed, self._is_broken = 0, False
