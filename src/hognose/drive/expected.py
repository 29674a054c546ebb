"""What cables are expected to pull along a plan, and what follows where they do not."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.drive.axes import Axes
from hognose.drive.watch import Stop, Trouble, Watch
from hognose.errors import InfeasibleError
from hognose.planning import Plan

Array = NDArray[np.float64]
_BACK = "only the way back is open"


class Expected:
    """The tensions of a plan, beside those that drives say.

    Parameters
    ----------
    plan
    axes
    cycle : s
    is_watched
        Whether they are looked at; not where nothing hangs on the motors.
    """

    def __init__(self, plan: Plan, axes: Axes, cycle: float, is_watched: bool) -> None:
        self._axes, self._cycle = axes, cycle
        self._tensions = None if plan.held is None or not is_watched else plan.held.tensions

    def tensions(self, place: float) -> Array | None:
        """Tensions (c,) N that are planned at a place (steps); None where they may be anything."""
        if self._tensions is None:
            return None
        low = min(int(place), len(self._tensions) - 1)
        high = min(low + 1, len(self._tensions) - 1)
        return self._tensions[low] + (place - low) * (self._tensions[high] - self._tensions[low])

    def in_words(self, place: float, may_be_out: bool) -> str:
        """How far tensions are from what is planned at a place (steps).

        Raises
        ------
        InfeasibleError
            Something is wrong, or a cable is out of its band and may not be.
        """
        planned = self.tensions(place)
        if planned is None:
            return "; tensions are not watched"
        trouble = self._look(planned)
        if trouble is None:
            return f", tensions within {np.abs(self._axes.tensions - planned).max():.1f} N of it"
        if may_be_out and trouble.stop is Stop.ALONG_PATH:
            return f", but {trouble.words}; {_BACK}"
        raise InfeasibleError(f"at step {place:g} of the plan: {trouble.words}")

    def closes(self, place: float) -> Trouble | None:
        """Why the way in is closed at a place (steps): a cable is out of its band there; None if none is."""
        planned = self.tensions(place)
        trouble = None if planned is None else self._look(planned)
        if trouble is None or trouble.stop is Stop.AT_ONCE:  # which is found, and done, where a motion begins
            return None
        return Trouble(trouble.stop, trouble.axis, f"{trouble.words}; {_BACK}")

    def _look(self, planned: Array) -> Trouble | None:
        return Watch(self._axes, self._cycle).look(self._axes.clock.now(), planned)
