"""Letting drives hold, or be without power, as long as people think; all are heard and watched meanwhile."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hognose.drive.axes import Axes
from hognose.drive.motions import SetPoint
from hognose.drive.stream import Cycle
from hognose.drive.watch import Trouble, Watch

Said = Callable[[str, str, int | None], None]


class Holding:
    """Exchanges heartbeats and statuses in cycles.

    Parameters
    ----------
    axes
    cycle : s
    seen
        Called with every cycle.
    said
        Called with what goes wrong; see `hognose.drive.executor.Executor`.
    """

    def __init__(self, axes: Axes, cycle: float, seen: Callable[[Cycle], None], said: Said) -> None:
        self._axes, self._cycle, self._seen, self._said = axes, cycle, seen, said

    def until(
        self, done: Callable[[], bool], at: SetPoint, powered: int, planned: NDArray[np.float64] | None
    ) -> Trouble | None:
        """Hold until something is done; what went wrong meanwhile, or None.

        A tension that gets out of its band is said once: an arm that holds cannot stop for it.

        Parameters
        ----------
        done
        at
            Where it holds.
        powered
            So many axes have to hold their positions, from the first one on.
        planned : (c,) N
            What cables are to pull; None where it may be anything.
        """
        watch, is_said = Watch(self._axes, self._cycle), planned is None
        if planned is not None:
            watch.forgive(planned)
        while not done():
            now = self._axes.clock.now()
            self._axes.sync()
            self._axes.wait(now + self._cycle)
            self._seen(Cycle(now, at, 0.0))
            trouble = watch.look(self._axes.clock.now(), None, powered)
            if trouble is not None:
                self._said("trouble", trouble.words, trouble.axis)
                return trouble
            if not is_said and (out := watch.band(planned)) is not None:
                is_said = True
                self._said("trouble", out.words, out.axis)
        return None
