"""What a budget of tolerances takes of the tensions of cables, and of the load factor of buckling."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.mechanics import Held, Mechanics
from hognose.mechanics.pulls import pulls
from hognose.mechanics.remedies import rounded_down
from hognose.planning.tolerance.budget import COVERAGE, WORDS, Budget

Array = NDArray[np.float64]

#: The parts that change tensions, and what the budget calls their deviations.
_PARTS = {"cable_zero": "zero", "mass_percent": "mass", "axial_stiffness_percent": "stiffness"}


@dataclass(frozen=True, eq=False)
class PullAllowance:
    """The budget of cables along a motion of T steps.

    Attributes
    ----------
    budget
    tensions : dict of (T, c) N
        What each part alone takes, by its key; those that are given.
    factors : dict of (T,)
        What each part alone adds to 1 / load factor.
    """

    budget: Budget
    tensions: dict[str, Array]
    factors: dict[str, Array]

    @classmethod
    def of(
        cls, budget: Budget | None, mechanics: Mechanics, angles: Array, held: Held, gravity: Array
    ) -> PullAllowance | None:
        """The allowance of angles (T, n, 2) rad that are held so, in gravity (T, 3) m/s²; None if nothing is taken."""
        if budget is None or not (budget.zero or budget.mass or budget.stiffness):
            return None
        found = pulls(mechanics, angles, held, gravity, (budget.zero, budget.mass, budget.stiffness), COVERAGE)
        given = [name for name in _PARTS if name in budget.given]
        tensions = dict(zip(_PARTS, (found.zeros, found.masses, found.stiffness), strict=True))
        factors = (found.buckling_zeros, found.buckling_masses, found.buckling_stiffness)
        by_name = dict(zip(_PARTS, factors, strict=True))
        return cls(budget, {name: COVERAGE * tensions[name] for name in given}, {name: by_name[name] for name in given})

    @property
    def taken(self) -> Array:
        """What is taken (T, c) N of every tension, either way."""
        return np.linalg.norm(list(self.tensions.values()), axis=0)

    def left(self, load_factor: Array) -> Array:
        """What is left (T,) of load factors (T,)."""
        with np.errstate(divide="ignore"):
            return 1.0 / (1.0 / load_factor + np.linalg.norm(list(self.factors.values()), axis=0))

    def words(self, step: int, cable: int) -> str:
        """What is taken of a tension (0-based), and which part is the largest, in words."""
        parts = {name: float(part[step, cable]) for name, part in self.tensions.items()}
        return self.budget.words(float(self.taken[step, cable]), parts, 1.0, "N")

    def words_of_factor(self, step: int, taken: float) -> str:
        """What is taken of the load factor at a step, and which part takes most of it, in words."""
        worst = max(self.factors, key=lambda name: self.factors[name][step])
        return f"{self.budget.label(worst)} takes most of the {taken:.2g} that tolerances take"

    def if_known_better(self, room: Array, parts: dict[str, Array], at: tuple[int, ...]) -> str:
        """How exactly what takes most at a place has to be known to fit into the room (...) everywhere, in words.

        Empty if that alone is not enough.
        """
        worst = max(parts, key=lambda name: parts[name][at])
        others = sum(part**2 for name, part in parts.items() if name != worst)
        left = np.sqrt(np.maximum(room, 0.0) ** 2 - np.minimum(others, np.maximum(room, 0.0) ** 2))
        with np.errstate(divide="ignore", invalid="ignore"):
            share = rounded_down(0.99 * float(np.nanmin(np.where(parts[worst] > 0, left / parts[worst], np.inf))))
        if not share:
            return ""
        key = _PARTS[worst]
        known = dataclasses.replace(self.budget, **{key: share * getattr(self.budget, key)}, assumed=frozenset())
        return f"know {WORDS[worst]} to {known.size_words(worst)} (1σ)"
