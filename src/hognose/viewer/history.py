"""What a task was before each edit, and what it was before that was undone."""

from __future__ import annotations

from dataclasses import dataclass

from hognose.planning import Task
from hognose.planning.task import PathSpec


@dataclass(frozen=True, eq=False)
class State:
    """A task at one time.

    Attributes
    ----------
    wished
        What was asked of the search that its way-points come from, or None.
    """

    task: Task
    wished: PathSpec | None = None


class History:
    """States one can go back to and forth again."""

    def __init__(self, first: State) -> None:
        self._states, self._at, self._merge = [first], 0, ""

    @property
    def now(self) -> State:
        """The state that counts."""
        return self._states[self._at]

    @property
    def can_undo(self) -> bool:
        """Whether there is a state before."""
        return self._at > 0

    @property
    def can_redo(self) -> bool:
        """Whether there is one that was undone."""
        return self._at < len(self._states) - 1

    def push(self, state: State, merge: str = "") -> None:
        """Go on to a new state; it takes the place of the present one if that came with the same `merge`."""
        first = self._at if merge and merge == self._merge else self._at + 1
        self._states[first:] = [state]
        self._at, self._merge = first, merge

    def go(self, by: int) -> bool:
        """Go back (-1) or forth (1); whether that was possible."""
        self.seal()
        if not 0 <= self._at + by < len(self._states):
            return False
        self._at += by
        return True

    def seal(self) -> None:
        """Let the next edit be a step of its own."""
        self._merge = ""
