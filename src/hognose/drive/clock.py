"""The time that a run goes by: real, or simulated so that a run takes no longer than its computation."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

#: The sleep of an operating system ends up to so much (s) late; what is left is waited for without sleeping.
_SPIN = 2e-4


class Clock(Protocol):
    """Tells the time, and lets it pass."""

    def now(self) -> float:
        """Seconds since some beginning."""
        ...

    def wait(self, until: float) -> None:
        """Return at a time (s), or as little later as can be; at once if it has passed."""
        ...


class RealClock:
    """The time of the machine, which nobody sets back."""

    def now(self) -> float:
        """See `Clock.now`."""
        return time.monotonic()

    def wait(self, until: float) -> None:
        """See `Clock.wait`."""
        left = until - time.monotonic()
        if left > _SPIN:
            time.sleep(left - _SPIN)
        while time.monotonic() < until:
            pass


class SimulatedClock:
    """Time that passes only where it is waited for; what goes on meanwhile is called after every tick."""

    def __init__(self, tick: float = 1e-3) -> None:
        self._now, self._tick = 0.0, tick
        self._others: list[Callable[[float], None]] = []

    def attach(self, other: Callable[[float], None]) -> None:
        """Call something with the time (s) after every tick, in the order in which it was attached."""
        self._others.append(other)

    def now(self) -> float:
        """See `Clock.now`."""
        return self._now

    def wait(self, until: float) -> None:
        """See `Clock.wait`; exact."""
        while self._now < until:
            self._now = min(self._now + self._tick, until)
            for other in self._others:
                other(self._now)
