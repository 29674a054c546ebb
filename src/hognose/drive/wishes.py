"""What people want of a run while it goes on, from whichever terminal or program they say it."""

from __future__ import annotations

import threading
from collections import deque
from enum import Enum
from typing import NamedTuple


class Want(Enum):
    """What can be wanted."""

    PAUSE = "pause"
    STOP = "stop"
    GO_ON = "go on"
    STEP = "step"
    RETRACT = "retract"
    END = "end"

    @property
    def starts_motion(self) -> bool:
        """Whether the arm moves for it, so that somebody at the terminal of the run has to confirm it."""
        return self in (Want.GO_ON, Want.STEP, Want.RETRACT)


class Wish(NamedTuple):
    """Something that is wanted, and by whom: `terminal`, or what else it came through."""

    want: Want
    who: str


class Wishes:
    """Takes wishes from any thread, and gives them in their order; who repeats one that waits adds nothing."""

    def __init__(self) -> None:
        self._waiting: deque[Wish] = deque()
        self._lock = threading.RLock()  # a signal may come while a wish is taken, and adds one

    def put(self, want: Want, who: str) -> None:
        """Add a wish; never waits for anybody to take it."""
        wish = Wish(want, who)
        with self._lock:
            if wish not in self._waiting:
                self._waiting.append(wish)

    def take(self) -> Wish | None:
        """A stop if there is one, or else the first that was not taken yet; None if there is none. Never waits."""
        with self._lock:
            stop = next((wish for wish in self._waiting if wish.want is Want.STOP), None)
            if stop is not None:
                self._waiting.remove(stop)
                return stop
            return self._waiting.popleft() if self._waiting else None
