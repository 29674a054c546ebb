"""One board that does not stand where it was planned: when the arm meets it, how hard, and what becomes of the tip."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

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
        To the end, or where the arm failed.
    held
        The same with a stop at contact; None where nothing was touched, or if none was asked for.
    """

    shift: float
    done: Simulated
    held: Simulated | None = None


def shifted_runs(
    plan: Plan,
    obstacle: str,
    direction: tuple[float, float, float],
    shifts: Iterable[float],
    limit: float | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[Shifted]:
    """Simulate a plan with one obstacle that stands elsewhere, for every shift (m) along a unit vector.

    Where it is touched, once more with motors that hold as soon as it presses a link with more than a limit (N).
    """
    shifts, found = list(shifts), []
    for k, shift in enumerate(shifts):
        x, y, z = (shift * part for part in direction)
        changes = Changes(shifted={obstacle: (x, y, z)})
        done = simulate(plan, changes)
        held = simulate(plan, changes, stop_at_contact=limit) if limit and done.touches else None
        found.append(Shifted(shift, done, held))
        progress(k + 1, len(shifts))
    return found
