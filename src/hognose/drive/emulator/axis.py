"""How the motor of an emulated drive moves: records of position, velocity and time, cyclic positions, or a stop."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

#: The position loop of a motor follows what is demanded with this time constant (s) [assumed].
LAG = 2e-3
#: How many records are needed before an EPOS2 begins.
_TO_BEGIN = 2


class Record(NamedTuple):
    """Where to be (counts), how fast there (counts/s), and how long (s) until the next record; 0 ends the motion."""

    position: int
    velocity: float
    duration: float


class Axis:
    """The demanded and the actual position of a motor, in counts."""

    def __init__(self, start: int = 0) -> None:
        self.demanded, self.actual = float(start), float(start)
        self.velocity = 0.0
        self.records: deque[Record] = deque()
        self.interpolates, self.underflows = False, 0
        self.is_stuck = False
        self._since = 0.0
        self._to, self._left = float(start), 0.0
        self._stops = False
        self.deceleration = math.inf

    def hold(self) -> None:
        """Stay where the motor is."""
        self.demanded, self.velocity = self.actual, 0.0
        self.interpolates, self._stops = False, False
        self.records.clear()
        self._left = 0.0

    def begin(self) -> bool:
        """Begin to go through the records; False if there are too few."""
        self.interpolates, self._since = len(self.records) >= _TO_BEGIN, 0.0
        return self.interpolates

    def target(self, position: float, duration: float) -> None:
        """Go to a position within a duration (s), at a steady speed, as cyclic positions are meant."""
        self._to, self._left = float(position), max(duration, 1e-6)
        self.velocity = (self._to - self.demanded) / self._left
        self._stops = False

    def stop(self, deceleration: float) -> None:
        """Slow down with a deceleration (counts/s²) and hold."""
        self._stops, self.deceleration = True, max(deceleration, 1.0)
        self.interpolates, self._left = False, 0.0
        self.records.clear()

    def step(self, dt: float) -> bool:
        """Move on with power, by dt (s); False if the records ended without one that says so."""
        whole = True
        if self._stops:
            self._slow(dt)
        elif self.interpolates:
            whole = self._play(dt)
        elif self._left > 0.0:
            used = min(dt, self._left)
            self.demanded += self.velocity * used
            self._left -= used
            if self._left <= 1e-9:
                self.demanded, self._left, self.velocity = self._to, 0.0, 0.0
        if not self.is_stuck:
            self.actual += (self.demanded - self.actual) * (1.0 - math.exp(-dt / LAG))
        return whole

    def _slow(self, dt: float) -> None:
        less = self.deceleration * dt
        after = math.copysign(max(abs(self.velocity) - less, 0.0), self.velocity)
        self.demanded += 0.5 * (self.velocity + after) * dt
        self.velocity = after

    def _play(self, dt: float) -> bool:
        """Cubic motion from record to record, which meets positions and velocities."""
        self._since += dt
        while self.records:
            first = self.records[0]
            if first.duration <= 0.0:
                self.demanded, self.velocity = float(first.position), 0.0
                self.records.clear()
                self.interpolates = False
                return True
            if len(self.records) < 2:
                break
            if self._since < first.duration:
                self._between(first, self.records[1], self._since)
                return True
            self._since -= first.duration
            self.records.popleft()
        self.underflows += 1
        return False

    def _between(self, a: Record, b: Record, since: float) -> None:
        h = a.duration
        u = since / h
        self.demanded = (
            (1 + 2 * u) * (1 - u) ** 2 * a.position + u * (1 - u) ** 2 * h * a.velocity
            + u * u * (3 - 2 * u) * b.position + u * u * (u - 1) * h * b.velocity
        )  # fmt: skip
        self.velocity = (
            6 * u * (u - 1) * (a.position - b.position) / h
            + (1 - u) * (1 - 3 * u) * a.velocity + u * (3 * u - 2) * b.velocity
        )  # fmt: skip
