"""What tolerances take of the clearance of every link of a motion, part by part, for people."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hognose.errors import InputError
from hognose.planning.checks.shared import Shared
from hognose.planning.drawn_arms import DRAWS, Draws, draw
from hognose.planning.motion import Motion
from hognose.planning.tolerance.budget import Budget
from hognose.wording import at_least_mm, at_most, mm

#: Shares of drawn arms whose clearance is said.
SHARES = (0.01, 0.05, 0.5)
#: How the parts of a table make the whole, in words.
SUMS = "Bounds (CAD, sag) add; of the others, each at 2σ, the squares add."


@dataclass(frozen=True)
class LinkBudget:
    """What tolerances take of a link's clearance where they take most.

    Attributes
    ----------
    link : int
        From 1.
    step : int
        Where most is taken.
    parts : dict
        What each part alone takes (m), by its key. Bounded parts add; of random ones the squares do.
    taken : m
        All parts together.
    left : m
        The smallest clearance of the link that tolerances leave at any step; at the horizon a lower bound.
    """

    link: int
    step: int
    parts: dict[str, float]
    taken: float
    left: float


@dataclass(frozen=True, eq=False)
class Tolerances:
    """The budget of a motion.

    Attributes
    ----------
    budget
    links
        One entry for every link.
    draws
    """

    budget: Budget
    links: tuple[LinkBudget, ...]
    draws: Draws

    @property
    def headline(self) -> str:
        """The tip's budget and what dominates it, in words."""
        last = self.links[-1]
        return f"At the tip {self.budget.words(last.taken, last.parts)}."

    @property
    def chances(self) -> str:
        """How likely the margin is lost, in words."""
        drawn = self.draws
        closer = ", ".join(f"{share:.0%} closer than {mm(drawn.quantile(share))}" for share in SHARES)
        return (
            f"Of {len(drawn.clearance):,} drawn arms {drawn.loses:.2%} come closer than the margin of "
            f"{1e3 * drawn.margin:g} mm, {drawn.touches:.2%} touch; {closer}."
        )

    @property
    def headings(self) -> tuple[str, ...]:
        """Of a table of all links."""
        return ("link", *(self.budget.label(name) for name in self.budget.given), "together", "step", "leaves")

    @property
    def rows(self) -> list[list[str]]:
        """Of that table, in mm."""
        return [
            [
                str(link.link),
                *(at_most(1e3 * link.parts[name]) for name in self.budget.given),
                at_most(1e3 * link.taken),
                str(link.step),
                at_least_mm(link.left),
            ]
            for link in self.links
        ]


def at_the_tip(motion: Motion) -> str:
    """What tolerances take at the tip where they take most, and what of it dominates, in words; empty without them."""
    allowance, line = Shared(motion).allowance, motion.centre_line
    if allowance is None:
        return ""
    link = motion.robot.sections - 1
    step = int(np.argmax(allowance.at_steps(line)[:, -1]))
    return f"At the tip {allowance.words(line, step, link)}."


def tolerances(motion: Motion, count: int = DRAWS, seed: int = 0) -> Tolerances:
    """The budget of a motion, and what comes of drawn arms; `count` and `seed` as of `draw`.

    Raises
    ------
    InputError
        There are no tolerances in the task, nor in its robot.
    """
    shared, budget = Shared(motion), motion.task.budget
    if budget is None or shared.allowance is None:
        raise InputError(
            f"{motion.task.name}: neither the task nor its robot has tolerances. Give them in a table [tolerance], "
            "such as calibration_deg = 0.1 and registration_deg = 0.05; docs/tolerances.md lists them"
        )
    parts, taken = shared.allowance.parts(motion.centre_line), shared.taken
    whole = shared.allowance.at_steps(motion.centre_line)
    links = []
    for link in range(motion.robot.sections):
        step = int(np.argmax(taken[:, link]))
        chords = np.flatnonzero(motion.robot.chord_sections == link)
        chord = chords[np.argmax(whole[step, chords])]
        each = {name: float(part[step, chord]) for name, part in parts.items()}
        links.append(LinkBudget(link + 1, step, each, float(taken[step, link]), float(shared.left[:, link].min())))
    return Tolerances(budget, tuple(links), draw(motion, budget, taken, count, seed))
