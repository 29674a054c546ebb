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
        watch = Watch(self._axes, self._cycle)
        trouble, out = watch.look(self._axes.clock.now(), None), watch.band(planned)
        if trouble is None and out is None:
            return f", tensions within {np.abs(self._axes.tensions - planned).max():.1f} N of it"
        if trouble is None and out is not None and may_be_out:
            return f", but {out.words}; {_BACK}"
        words = " and ".join(each.words for each in (trouble, out) if each is not None)
        raise InfeasibleError(f"at step {place:g} of the plan: {words}")

    def closes(self, place: float) -> Trouble | None:
        """Why the way in is closed at a place (steps): a cable is out of its band there; None if none is."""
        out = Watch(self._axes, self._cycle).band(self.tensions(place))
        return None if out is None else Trouble(Stop.ALONG_PATH, out.axis, f"{out.words}; {_BACK}")
