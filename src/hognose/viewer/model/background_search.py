"""A search for a route in a thread of its own, that can be stopped."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from dataclasses import dataclass

from hognose.errors import HognoseError
from hognose.planning import Plan, Task
from hognose.route.search.search import Search
from hognose.route.search_stages import search_route
from hognose.route.why.diagnosis import explained
from hognose.wording import at_least_mm


def _never() -> bool:
    return False


@dataclass(eq=False)
class _Stoppable(Search):
    """A search that also ends when it is told to."""

    stopped: Callable[[], bool] = _never

    def goes_on(self) -> bool:
        return not self.stopped() and super().goes_on()

    def asks_on(self) -> bool:
        return not self.stopped() and super().asks_on()


class Finding:
    """A search at work; it begins at once.

    Parameters
    ----------
    task
        With a target.
    number
        Of the version of the task.
    seconds
        How long to search.
    found
        Called by the search's thread with itself and each plan that is better than those before.

    Attributes
    ----------
    said
        How it goes, or how it went, in words.
    number
        Of the version that this is about: the one that was searched, then the one that its last route made.
    """

    def __init__(self, task: Task, number: int, seconds: float, found: Callable[[Finding, Plan], None]) -> None:
        self.said, self.number = "searching", number
        self._found = found
        self._stop, self._ended = threading.Event(), False
        self._shown: Plan | None = None
        self._task, self._seconds = task, seconds
        self._search = self._begin(task)
        self._thread = threading.Thread(target=self._work, name="hognose-search", daemon=True)
        self._thread.start()

    @property
    def active(self) -> bool:
        """Whether it still searches, or finds out why there is no route, and nobody has stopped it."""
        return not (self._ended or self._stop.is_set())

    def stop(self) -> None:
        """Let it end soon; what it finds from now on is not told any more."""
        self._stop.set()

    def close(self) -> None:
        """Stop it and wait until it has ended."""
        self.stop()
        if self._thread is not threading.current_thread():
            self._thread.join()

    def _work(self) -> None:
        try:
            self.said = self._outcome()
        except HognoseError as error:
            self.said = str(error)
        except Exception as error:  # a fault of ours is said, not lost with the thread
            logging.getLogger(__name__).exception("the search failed")
            self.said = f"the search failed because of a fault in Hognose: {error!r}"
        finally:
            self._ended = True

    def _begin(self, task: Task) -> Search:
        self._search = _Stoppable(task, self._seconds, 0, self._progress, stopped=self._stop.is_set)
        return self._search

    def _outcome(self) -> str:
        search, made = search_route(self._task, self._begin)
        error = None if made is not None or self._stop.is_set() else explained(search)
        self._show()
        made = search.best.plan if made is None and search.best is not None else made
        if made is not None:
            count = f"{len(search.found)} route{'s' if len(search.found) > 1 else ''}"
            ended = "stopped after" if self._stop.is_set() else "searched"
            proven = at_least_mm(made.certified_clearance or 0.0, 1)
            return f"{proven} mm certified, the best of {count}; {ended} {search.spent:.1f} s"
        return f"stopped after {search.spent:.1f} s; no route yet" if self._stop.is_set() else str(error)

    def _progress(self, stage: str) -> None:
        best = self._search.best
        self.said = stage if best is None else f"{stage}; best so far {at_least_mm(best.clearance, 1)} mm certified"
        self._show()

    def _show(self) -> None:
        """Hand over the best route, if that is a new one and nobody has stopped the search."""
        best = self._search.best
        if best is not None and best.plan is not self._shown and not self._stop.is_set():
            self._shown = best.plan
            self._found(self, best.plan)
