"""What a task was before each edit, and what it was before that was undone."""

from __future__ import annotations

from hognose.planning import Task


class History:
    """Tasks one can go back to and forth again."""

    def __init__(self, first: Task) -> None:
        self._states, self._at, self._merge = [first], 0, ""

    @property
    def now(self) -> Task:
        """The one that counts."""
        return self._states[self._at]

    @property
    def can_undo(self) -> bool:
        """Whether there is one before."""
        return self.can_go(-1)

    @property
    def can_redo(self) -> bool:
        """Whether there is one that was undone."""
        return self.can_go(1)

    def push(self, task: Task, merge: str = "") -> None:
        """Go on to a new task; it takes the place of the present one if that came with the same `merge`."""
        first = self._at if merge and merge == self._merge else self._at + 1
        self._states[first:] = [task]
        self._at, self._merge = first, merge

    def can_go(self, by: int) -> bool:
        """Whether one can go back (-1) or forth (1)."""
        return 0 <= self._at + by < len(self._states)

    def go(self, by: int) -> None:
        """Go back (-1) or forth (1)."""
        self.seal()
        self._at += by

    def seal(self) -> None:
        """Let the next edit be a step of its own."""
        self._merge = ""
