"""What a budget of tolerances, and friction, take of the tensions of cables and of the load factor of buckling."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.mechanics import Held, Mechanics
from hognose.mechanics.pulls import pulls
from hognose.mechanics.remedies import rounded_down
from hognose.mechanics.rubbing import rubbing
from hognose.planning.tolerance.budget import COVERAGE, PLURAL, WORDS, Budget
from hognose.planning.tolerance.left_over import EVEN, ways_of
from hognose.robot.tension import is_assumed

Array = NDArray[np.float64]

#: The parts that are tolerances, and what the budget calls their deviations.
_PARTS = {"cable_zero": "zero", "mass_percent": "mass", "axial_stiffness_percent": "stiffness"}
#: To know something better than by this share of how it is known is no advice.
_LEAST_SHARE = 0.02


@dataclass(frozen=True, eq=False)
class PullAllowance:
    """The budget of cables along a motion of T steps.

    Attributes
    ----------
    mechanics
    budget
        None without tolerances: then friction alone takes something.
    tensions : dict of (T, c) N
        What each part alone takes, by its key; those that are given.
    factors : dict of (T,)
        What each part alone adds to 1 / load factor.
    """

    mechanics: Mechanics
    budget: Budget | None
    tensions: dict[str, Array]
    factors: dict[str, Array]

    @classmethod
    def of(
        cls, budget: Budget | None, mechanics: Mechanics | None, angles: Array, held: Held | None, gravity: Array
    ) -> PullAllowance | None:
        """The allowance of angles (T, n, 2) rad that are held so, in gravity (T, 3) m/s²; None if nothing is taken."""
        if mechanics is None or held is None:
            return None
        tensions, factors = {}, {}
        given = [] if budget is None else [name for name in _PARTS if name in budget.given]
        if budget is not None and given:
            found = pulls(mechanics, angles, held, gravity, (budget.zero, budget.mass, budget.stiffness), COVERAGE)
            of_tensions = dict(zip(_PARTS, (found.zeros, found.masses, found.stiffness), strict=True))
            of_factors = (found.buckling_zeros, found.buckling_masses, found.buckling_stiffness)
            tensions = {name: COVERAGE * of_tensions[name] for name in given}
            factors = {name: part for name, part in zip(_PARTS, of_factors, strict=True) if name in given}
        if mechanics.friction:
            rubbed, factor = rubbing(mechanics, angles, held, gravity, ways_of(held.commanded_lengths))
            tensions["friction"], factors["friction"] = COVERAGE * EVEN * rubbed, COVERAGE * EVEN * factor
        return cls(mechanics, budget, tensions, factors) if tensions else None

    @property
    def taken(self) -> Array:
        """What is taken (T, c) N of every tension, either way."""
        return np.linalg.norm(list(self.tensions.values()), axis=0)

    def left(self, load_factor: Array) -> Array:
        """What is left (T,) of load factors (T,)."""
        with np.errstate(divide="ignore"):
            return 1.0 / (1.0 / load_factor + np.linalg.norm(list(self.factors.values()), axis=0))

    def words(self, step: int, cable: int) -> str:
        """What is taken of a tension (0-based), and which part is the largest, in words; empty if nothing is."""
        if not self.taken[step, cable]:
            return ""
        parts = {name: float(part[step, cable]) for name, part in self.tensions.items()}
        worst = max(parts, key=lambda name: parts[name])
        said, plural = self._label(worst), worst in PLURAL
        if len(parts) == 1:
            return f"{said} {'take' if plural else 'takes'} {parts[worst]:.1f} N"
        whole = float(self.taken[step, cable])
        return f"{said} {'are' if plural else 'is'} {parts[worst]:.1f} of the {whole:.1f} N that tolerances take"

    def words_of_factor(self, step: int, taken: float) -> str:
        """What is taken of the load factor at a step, and which part takes most, in words; empty if nothing is."""
        if not taken > 0:
            return ""
        worst = max(self.factors, key=lambda name: self.factors[name][step])
        if len(self.factors) == 1:
            return f"{self._label(worst)} {'take' if worst in PLURAL else 'takes'} {taken:.2g}"
        return f"of the {taken:.2g} that tolerances take, most is due to {self._label(worst)}"

    def if_known_better(self, room: Array, parts: dict[str, Array], at: tuple[int, ...]) -> str:
        """How exactly what takes most at a place has to be known to fit into the room (...) everywhere, in words.

        Empty if that alone is not enough, or if nobody could know it so well.
        """
        worst = max(parts, key=lambda name: parts[name][at])
        if self.budget is None or worst not in _PARTS:
            return ""
        others = sum(part**2 for name, part in parts.items() if name != worst)
        left = np.sqrt(np.maximum(room, 0.0) ** 2 - np.minimum(others, np.maximum(room, 0.0) ** 2))
        with np.errstate(divide="ignore", invalid="ignore"):
            share = rounded_down(0.99 * float(np.nanmin(np.where(parts[worst] > 0, left / parts[worst], np.inf))))
        if share < _LEAST_SHARE:
            return ""
        key = _PARTS[worst]
        known = dataclasses.replace(self.budget, **{key: share * getattr(self.budget, key)}, assumed=frozenset())
        return f"know {WORDS[worst]} to {known.size_words(worst)} (1σ)"

    def _label(self, name: str) -> str:
        if self.budget is not None and name in _PARTS:
            return self.budget.label(name)
        assumed = " (assumed)" if is_assumed("cables.friction", self.mechanics.robot.assumed) else ""
        return f"friction {self.mechanics.friction:g}{assumed}"
