"""Bringing drives from state to state, one at a time, and waiting until they say that they are there."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hognose.drive import cia402
from hognose.drive.axes import Axes
from hognose.drive.cia402 import State
from hognose.drive.watch import Trouble
from hognose.errors import InfeasibleError

#: So long (s) drives may take to say their first status and heartbeat, and to change their state.
_PATIENCE = 3.0
#: An axis that rests goes on by so many counts at most from status to status.
_STILL = 2


class Switching:
    """Switches the drives of axes on and off; every wait raises an InfeasibleError that names who is not there."""

    def __init__(self, axes: Axes) -> None:
        self._axes, self._clock = axes, axes.clock

    def enable(self, axis: int, look: Callable[[], Trouble | None]) -> None:
        """Enable a drive where it stands, and look meanwhile whether anything goes wrong with others."""
        self.until(lambda: self._enabled(axis), f"is enabled: {self._axes.network.axis_name(axis)}", look)

    def take_power(self, axis: int) -> None:
        """Let a drive be without power."""
        self.until(lambda: self._without_power(axis), f"is without power: {self._axes.network.axis_name(axis)}")

    def all_heard(self) -> str:
        """The axes that were not heard yet, in words."""
        axes = self._axes
        silent = np.flatnonzero(~(np.isfinite(axes.heard) & np.isfinite(axes.beaten)) | axes.dropped)
        return ", ".join(self._axes.network.axis_name(int(axis)) for axis in silent[:3])

    def until(self, left: Callable[[], str], wanted: str, look: Callable[[], Trouble | None] = lambda: None) -> None:
        """Ask for the status of all until nothing waited for is left; an error at trouble, or if that lasts."""
        end = self._clock.now() + _PATIENCE
        while words := left():
            if (trouble := look()) is not None:
                raise InfeasibleError(trouble.words)
            if self._clock.now() > end:
                raise InfeasibleError(f"waited {_PATIENCE:g} s until every drive {wanted}; still: {words}")
            self._axes.ask()

    def rest(self) -> None:
        """Wait until no axis moves any more."""
        before, heard = np.full(len(self._axes), np.iinfo(np.int64).max), self._axes.heard.copy()

        def moving() -> str:
            nonlocal before, heard
            moved, is_old = np.abs(self._axes.position - before) > _STILL, self._axes.heard <= heard
            axes = np.flatnonzero(moved | is_old)
            before, heard = self._axes.position.copy(), self._axes.heard.copy()
            return ", ".join(self._axes.network.axis_name(int(axis)) for axis in axes[:3])

        self.until(moving, "rests")

    def _enabled(self, axis: int) -> str:
        """What an axis is still, in words, after it was sent what brings it on; empty if it is enabled."""
        state = self._axes.states()[axis]
        if state is State.OPERATION_ENABLED:
            return ""
        word = cia402.ENABLE if state is State.QUICK_STOP_ACTIVE else cia402.towards_enabled(state)
        if word is not None:
            self._axes.control(axis, word)
        return state.words

    def _without_power(self, axis: int) -> str:
        """What an axis is still, in words, after it was told to have no power; empty if it has none."""
        state = self._axes.states()[axis]
        if not state.has_power:
            return ""
        self._axes.control(axis, cia402.SHUTDOWN)
        return state.words
