"""One board that does not stand where it was planned: when the arm meets it, how hard, and what becomes of the tip."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from hognose.planning import Plan
from hognose.sim import Changes, Simulated, simulate


@dataclass(frozen=True, eq=False)
class Shifted:
    """A run with an obstacle that stands elsewhere.

    Attributes
    ----------
    shift : m
        How far it stands from where it was planned.
    done
    changes
        With which it was simulated.
    """

    shift: float
    done: Simulated
    changes: Changes

    @property
    def first_contact(self) -> float | None:
        """When (s) it was first touched: the end of that period; None if it never was."""
        touched = np.flatnonzero(self.done.contact.max(axis=1) > 0)
        return float(self.done.plan.time[touched[0]]) if len(touched) else None


def shifted_runs(
    plan: Plan,
    obstacle: str,
    direction: tuple[float, float, float],
    shifts: Iterable[float],
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[Shifted]:
    """Simulate a plan with one obstacle that stands elsewhere, once for every shift (m) along a unit vector."""
    shifts, found = list(shifts), []
    for k, shift in enumerate(shifts):
        x, y, z = (shift * part for part in direction)
        changes = Changes(shifted={obstacle: (x, y, z)})
        found.append(Shifted(shift, simulate(plan, changes), changes))
        progress(k + 1, len(shifts))
    return found
