"""What waits for one follower: bounded, and whoever puts something in never waits."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from hognose.drive.live.frames import Message

#: The topic of events, which are never left out; and the one that a cycle begins with.
EVENTS, CYCLE, PICTURES = "/events", "/state", "/tip_camera"


class Numbered(NamedTuple):
    """A message, with its number in the record."""

    number: int
    message: Message


class Outbox:
    """Messages for a follower, in order; of one that is slow, the oldest cycles and pictures are left out.

    Not for several threads at a time.

    Attributes
    ----------
    left_out
        Pictures, and cycles whose state was left out, since that was last told.
    overflows
        Whether more events wait than are kept; whoever does not read them is not a follower any more.
    """

    def __init__(self, most_bytes: int, most_events: int, begun: list[Numbered]) -> None:
        """What waits at first is given; at most so many bytes of cycles and pictures wait, and so many events."""
        self._most_bytes, self._most_events = most_bytes, most_events
        self._events: deque[Numbered] = deque(each for each in begun if each.message.topic == EVENTS)
        self._others: deque[Numbered] = deque(each for each in begun if each.message.topic != EVENTS)
        self._bytes = sum(len(each.message.data) for each in self._others)
        self.left_out = {"cycles": 0, "pictures": 0}
        self.overflows = False

    def put(self, one: Numbered) -> None:
        """Add a message."""
        if self.overflows:
            return
        if one.message.topic == EVENTS:
            self._events.append(one)
            self.overflows = len(self._events) > self._most_events
            return
        self._others.append(one)
        self._bytes += len(one.message.data)
        while self._bytes > self._most_bytes and len(self._others) > 1:
            self._leave_out()

    def take(self, most: int) -> list[Numbered]:
        """At most so many messages, in order; they wait no more."""
        found: list[Numbered] = []
        while len(found) < most and (self._events or self._others):
            events_next = not self._others or (self._events and self._events[0].number < self._others[0].number)
            if events_next:
                found.append(self._events.popleft())
            else:
                found.append(self._others.popleft())
                self._bytes -= len(found[-1].message.data)
        return found

    def told(self) -> dict[str, int]:
        """What was left out since this was asked before."""
        found, self.left_out = self.left_out, {"cycles": 0, "pictures": 0}
        return found

    def __len__(self) -> int:
        return len(self._events) + len(self._others)

    def _leave_out(self) -> None:
        """Leave out the oldest picture, or the oldest cycle with all its messages."""
        first = self._drop()
        if first.topic in (PICTURES, CYCLE):  # else the rest of a cycle whose state was sent
            self.left_out["pictures" if first.topic == PICTURES else "cycles"] += 1
        while first.topic != PICTURES and self._others and self._others[0].message.topic not in (CYCLE, PICTURES):
            self._drop()

    def _drop(self) -> Message:
        message = self._others.popleft().message
        self._bytes -= len(message.data)
        return message
