"""Where on a plan's time line the page is, and how it moves on."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Clock:
    """A place on the rows of a plan, and how it plays.

    Attributes
    ----------
    rows
        How many rows the plan has, 1 or more.
    row
        Where it is, 0 to rows - 1; a fraction while it plays.
    playing
    speed
        Times as fast as the arm.
    outwards
        Whether it plays from the target back to the entrance: the same set-points backwards.
    """

    rows: int
    row: float = 0.0
    playing: bool = False
    speed: float = 1.0
    outwards: bool = False

    @property
    def shown(self) -> int:
        """The row to show."""
        return round(self.row)

    @property
    def at_end(self) -> bool:
        """Whether there is nothing left to play in its direction."""
        return self.row <= 0 if self.outwards else self.row >= self.rows - 1

    def over(self, rows: int) -> Clock:
        """The same place, in parts of the whole, on a plan of other length."""
        if rows == self.rows:
            return self
        part = self.row / max(self.rows - 1, 1)
        return replace(self, rows=rows, row=part * (rows - 1))

    def to(self, row: float) -> Clock:
        """At another row; one beyond an end is that end."""
        return replace(self, row=min(max(row, 0.0), float(self.rows - 1)))

    def stepped(self, by: int) -> Clock:
        """Stopped, some rows further."""
        return replace(self.to(self.shown + by), playing=False)

    def toggled(self) -> Clock:
        """Playing if it was stopped, from the other end if nothing was left; stopped if it played."""
        if self.playing:
            return replace(self, playing=False, row=float(self.shown))
        start = (self.rows - 1 if self.outwards else 0) if self.at_end else self.row
        return replace(self.to(start), playing=True)

    def after(self, seconds: float, period: float) -> Clock:
        """What it is after some time, with a row each `period` s at speed 1; it stops at the end."""
        if not self.playing or not math.isfinite(seconds):
            return self
        rows = self.speed * seconds / period
        moved = self.to(self.row - rows if self.outwards else self.row + rows)
        return replace(moved, playing=not moved.at_end)
