"""What a budget of tolerances takes of the clearances of a motion: at its steps, and between them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hognose.cached import cached_property
from hognose.mechanics import Held
from hognose.planning.tolerance.budget import COVERAGE, Budget, along_chords
from hognose.planning.tolerance.jacobian import by_zeros, joint_axes, largest
from hognose.planning.tolerance.perturbed import bulges_of_both
from hognose.robot.base import Base
from hognose.robot.cable_gains import angles_per_length

Array = NDArray[np.float64]
Steps = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Allowance:
    """The budget along a motion of T steps.

    Attributes
    ----------
    budget
    zeros : (T, p) m
        Spread of each chord at the steps by the zeros of cables.
    left_over : dict of (T, p) m
        The same by what is left although the weight is made up for, part by part.
    bulge, growth : (T-1, p+1) m
        How far ends of chords leave straight lines from each step to the next, and how much farther if cables are off.
    """

    budget: Budget
    zeros: Array
    left_over: dict[str, Array]
    bulge: Array
    growth: Array

    @classmethod
    def of(
        cls, budget: Budget, base: Base, angles: Array, at: Array, joints: Array, held: Held | None = None
    ) -> Allowance:
        """The allowance of angles (T, n, 2) rad on a base at (T, k), with joints (T, n+1, 3) m.

        `held` is how cables hold the arm there, if it is known.
        """
        robot, sections = budget.robot, budget.robot.outline.sections
        left = budget.left_over(base, angles, at, joints, held)
        left = {name: along_chords(part)[:, sections] for name, part in left.items()}
        if budget.zero == 0.0:
            none = np.zeros((len(angles), len(sections) + 1))
            bulge = none[1:]
            if left:
                spin, swing = base.spin(at[:-1], at[1:]), base.swing(at[:-1], at[1:])
                low, high = np.ascontiguousarray(angles[:-1]), np.ascontiguousarray(angles[1:])
                bulge = robot.model.bulges(low, high, robot.link_lengths, spin, swing)
            return cls(budget, none[:, 1:], left, bulge, none[1:])
        axes, gains = joint_axes(base, angles, at), angles_per_length(budget.robot, angles)
        zeros = budget.zero * along_chords(largest(by_zeros(axes, joints, gains)))
        bulges = bulges_of_both(budget.robot, base, at, angles, axes, gains, COVERAGE * budget.zero)
        return cls(budget, zeros[:, sections], left, *bulges)

    def with_bulge(self, bulge: Array) -> Allowance:
        """The same for a motion between these steps that leaves straight lines by up to (T-1, p+1) m."""
        return replace(self, bulge=bulge) if self.budget.zero or self.left_over else self

    @cached_property
    def zeros_between(self) -> Array:
        """Spread (T-1, p) m of each chord by zeros of cables, and what is left over, from each step to the next.

        A displacement is the difference of two places, with errors and without. Either leaves its straight line by no
        more than its bulge, and of the lines the difference is largest at an end.
        """
        away = along_chords(2.0 * self.bulge + self.growth) / COVERAGE
        found = np.maximum(self.zeros[:-1], self.zeros[1:]) + away if self.budget.zero else self.zeros[1:]
        if not self.left_over:
            return found
        left = self._left
        farthest = 2.0 * self.bulge.max(axis=1, keepdims=True) / COVERAGE  # what is left depends on the whole arm
        return np.hypot(found, np.maximum(left[:-1], left[1:]) + farthest)

    @cached_property
    def _left(self) -> Array:
        """Spread (T, p) m by all parts that are left over."""
        return np.linalg.norm(list(self.left_over.values()), axis=0)

    @property
    def _at_steps(self) -> Array:
        """Spread (T, p) m at the steps by all that depends on the pose in other ways than by places alone."""
        return np.hypot(self.zeros, self._left) if self.left_over else self.zeros

    def parts(self, vertices: Array) -> dict[str, Array]:
        """What each part alone takes (T, p) m at all steps, by its key; those that are given."""
        budget = self.budget
        shape = self.zeros.shape
        found = {
            "cad": np.full(shape, budget.cad),
            "sag": np.broadcast_to(budget.sag[budget.robot.outline.sections], shape),
            "registration": np.full(shape, COVERAGE * budget.shift),
            "registration_deg": COVERAGE * along_chords(budget.turned(vertices)),
            "calibration_deg": COVERAGE * along_chords(budget.bent(vertices)),
            "cable_zero": COVERAGE * self.zeros,
            **{name: COVERAGE * part for name, part in self.left_over.items()},
        }
        return {name: found[name] for name in budget.given}

    def words(self, vertices: Array, step: int, link: int) -> str:
        """What is taken of the clearance of a link (0-based) at a step, and which part is the largest, in words."""
        row = slice(step, step + 1)
        left = {name: part[row] for name, part in self.left_over.items()}
        here, vertices = replace(self, zeros=self.zeros[row], left_over=left), vertices[row]
        taken = here.at_steps(vertices)[0]
        chords = np.flatnonzero(self.budget.robot.outline.sections == link)
        chord = chords[np.argmax(taken[chords])]
        parts = {name: float(part[0, chord]) for name, part in here.parts(vertices).items()}
        return self.budget.words(float(taken[chord]), parts)

    def at_steps(self, vertices: Array) -> Array:
        """What is taken (T, p) m at all steps, where chords end at vertices (T, p+1, 3) m."""
        return self._taken(along_chords(self.budget.spread(vertices)), self._at_steps)

    def within(self, vertices: Array, steps: Steps) -> Array:
        """What is taken (m, p) m at places between steps (m,) and the next, chords ending at (m, p+1, 3) m."""
        return self._taken(along_chords(self.budget.spread(vertices)), self.zeros_between[steps])

    def between(self, low: Array, high: Array, steps: Steps, motion: Array | None, bulge: Array) -> Array:
        """What is taken (m, p) m at most in intervals of the steps (m,).

        Vertices go from `low` to `high` (m, p+1, 3) m along straight lines at a steady speed, but for a bulge (m, p+1)
        m; or, if `motion` (m, p+1) m is given, along lines that are no longer than that. The spread is a convex
        function of places: on the straight lines it is no more than the larger of those at the ends, in their middles
        than half the sum. From the middle, vertices are half of their way at most.
        """
        first, second = self.budget.spread(low), self.budget.spread(high)
        if motion is None:
            spread = np.maximum(first, second) + self.budget.change(bulge)
        else:
            spread = 0.5 * (first + second) + self.budget.change(0.5 * motion + bulge)
        return self._taken(along_chords(spread), self.zeros_between[steps])

    def _taken(self, spread: Array, zeros: Array) -> Array:
        return self.budget.bounded + COVERAGE * np.hypot(spread, zeros)


@dataclass(frozen=True, eq=False)
class OnBase:
    """What the budget takes of the clearance of what is fixed to the base, such as the mount; as of `Allowance`."""

    budget: Budget

    def with_bulge(self, bulge: Array) -> OnBase:
        """See `Allowance.with_bulge`: no cable moves it."""
        return self

    def at_steps(self, vertices: Array) -> Array:
        """See `Allowance.at_steps`."""
        return along_chords(self.budget.of_base(vertices))

    def within(self, vertices: Array, steps: Steps) -> Array:
        """See `Allowance.within`."""
        return self.at_steps(vertices)

    def between(self, low: Array, high: Array, steps: Steps, motion: Array | None, bulge: Array) -> Array:
        """See `Allowance.between`."""
        if motion is None:
            most = np.maximum(self.budget.of_base(low, bulge), self.budget.of_base(high, bulge))
        else:
            most = self.budget.of_base(0.5 * (low + high), 0.5 * motion + bulge)
        return along_chords(most)
