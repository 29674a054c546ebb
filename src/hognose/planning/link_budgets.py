"""What tolerances take of the clearance of every link of a motion, part by part, for people."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.planning.certificate import certify_passing, interpolated_motion, outlined
from hognose.planning.checks.shared import Shared
from hognose.planning.drawn_arms import DRAWS, Draws, draw
from hognose.planning.motion import Motion
from hognose.planning.penetration import per_section
from hognose.planning.tolerance.budget import COVERAGE, Budget
from hognose.planning.tolerance.sections import refuse_unknown_sections
from hognose.scene.obstacle import titles
from hognose.ties import first_largest, first_smallest
from hognose.wording import at_least_mm, at_most, mm

#: Shares of drawn arms whose clearance is said.
SHARES = (0.01, 0.05, 0.5)
#: How the parts of a table make the whole, in words.
SUMS = "Bounds (CAD, sag) add; of the others, each at 2σ, the squares add."
#: What a sign in the last column means.
BEYOND = " ≥: farther is not measured."


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
        The smallest clearance of the link that tolerances leave at any step.
    left_is_lower_bound : bool
        Whether more than that may be left: its distance is beyond the horizon, and not measured.
    """

    link: int
    step: int
    parts: dict[str, float]
    taken: float
    left: float
    left_is_lower_bound: bool = False


@dataclass(frozen=True)
class Timing:
    """What it takes of the clearance to a moving obstacle that it may be early or late.

    Attributes
    ----------
    obstacle : str
    timing : s
    without : m
        The clearance certified to it if it were on time, all other tolerances taken off; at most the horizon.
    left : m
        The clearance certified to it.
    horizon : m
    assumed
        Whether nobody measured it.
    """

    obstacle: str
    timing: float
    without: float
    left: float
    horizon: float
    assumed: bool

    @property
    def taken(self) -> float:
        """What is taken (m) where the arm is closest; all of what there is where it may touch."""
        return min(self.without - self.left, max(self.without, 0.0))

    @property
    def words(self) -> str:
        """The same, in words."""
        given = f"{self.obstacle}: timing {self.timing:g} s{' (assumed)' if self.assumed else ''}"
        if self.left >= self.horizon:
            return f"{given} takes nothing: it stays farther away than {1e3 * self.horizon:g} mm."
        if self.left <= 0:
            return f"{given} takes all of the {mm(max(self.without, 0.0))} certified to it."
        taken, left = at_most(1e3 * self.taken), at_least_mm(self.left)
        return f"{given} takes {taken} mm of the clearance certified to it; {left} mm are left."


@dataclass(frozen=True, eq=False)
class Tolerances:
    """The budget of a motion.

    Attributes
    ----------
    budget
        None if only obstacles that move may be early or late: then there are no links and no draws.
    links
        One entry for every link.
    draws
    timings
        One entry for every moving obstacle that may be early or late.
    taken_for_exact
        What is not in the budget although it could be, in words; empty if there is nothing.
    of_tensions
        What is taken of tensions where they leave least, in words; empty if nothing is.
    """

    budget: Budget | None
    links: tuple[LinkBudget, ...] = ()
    draws: Draws | None = None
    timings: tuple[Timing, ...] = ()
    taken_for_exact: str = ""
    of_tensions: str = ""

    @property
    def assumed(self) -> frozenset[str]:
        """The keys of what nobody measured."""
        if self.budget is not None:
            return self.budget.assumed
        return frozenset({"timing_s"} if any(each.assumed for each in self.timings) else ())

    @property
    def sentences(self) -> tuple[str, ...]:
        """All there is to say besides the table of links."""
        told = (
            self.headline,
            self.of_tensions,
            self.taken_for_exact,
            *(each.words for each in self.timings),
            self.chances,
        )
        return tuple(filter(None, told))

    @property
    def sums(self) -> str:
        """How to read the table of links, in words."""
        return f"{SUMS}{BEYOND if any(link.left_is_lower_bound for link in self.links) else ''}"

    @property
    def headline(self) -> str:
        """The tip's budget and what dominates it, in words; empty without a budget."""
        if self.budget is None:
            return ""
        last = self.links[-1]
        return f"At the tip {self.budget.words(last.taken, last.parts)}."

    @property
    def chances(self) -> str:
        """How likely the margin is lost, in words; empty where no arms were drawn."""
        drawn = self.draws
        if drawn is None:
            return ""
        closer = _closer(drawn)
        on_time = " Moving obstacles are on time in these." if self.timings else ""
        return (
            f"Of {len(drawn.clearance):,} drawn arms {drawn.loses:.2%} come closer than the margin of "
            f"{1e3 * drawn.margin:g} mm, {drawn.touches:.2%} touch; {closer}.{on_time}"
        )

    @property
    def headings(self) -> tuple[str, ...]:
        """Of a table of all links."""
        if self.budget is None:
            return ()
        return ("link", *(self.budget.label(name) for name in self.budget.given), "together", "step", "leaves")

    @property
    def rows(self) -> list[list[str]]:
        """Of that table, in mm."""
        return [
            [
                str(link.link),
                *(at_most(1e3 * part) for part in link.parts.values()),
                at_most(1e3 * link.taken),
                str(link.step),
                f"{'≥ ' if link.left_is_lower_bound else ''}{at_least_mm(link.left)}",
            ]
            for link in self.links
        ]


def _closer(drawn: Draws) -> str:
    """How much smaller shares of drawn arms come closer than, in words; the last may be known only in part."""
    known = [share for share in SHARES if not drawn.is_lower_bound(share)]
    told = [f"{share:.0%} closer than {mm(drawn.quantile(share))}" for share in known]
    if len(known) < len(SHARES):
        share = SHARES[len(known)]
        told.append(f"{1 - share:.0%} stay ≥ {at_least_mm(drawn.ceiling)} mm away (farther is not measured)")
    return ", ".join(told)


def timings(motion: Motion) -> tuple[Timing, ...]:
    """What the timing of moving obstacles takes of clearances, while feed and angles go linearly."""
    shared, task = Shared(motion, motion.clearance), motion.task
    moving = outlined(interpolated_motion(motion.robot, task.base, motion.at, motion.angles), motion.robot, task.base)
    obstacles = zip(titles(task.spec.obstacle), task.spec.obstacle, strict=True)
    said, found = {name for name, item in obstacles if item.timing_s is not None}, []
    for each, proof in zip(task.moving, shared.passing_interpolated, strict=True):
        if not each.timing:
            continue
        on_time = dataclasses.replace(each, timing=0.0)
        rest = (motion.clock, motion.outline, motion.horizon, task.margin, shared.allowance)
        without = certify_passing(moving, motion.robot, on_time, *rest).clearance
        assumed = each.name not in said and "timing_s" in task.spec.tolerance.assumed
        found.append(Timing(each.name, each.timing, without, proof.clearance, motion.horizon, assumed))
    return tuple(found)


def clearance_left(motion: Motion) -> NDArray[np.float64]:
    """The clearance (T, n) m of every link that tolerances leave at the steps."""
    return Shared(motion, motion.clearance).left


def at_the_tip(motion: Motion) -> str:
    """What tolerances take at the tip where they take most, and what of it dominates, in words; empty without them."""
    allowance, line = Shared(motion).allowance, motion.outline
    if allowance is None:
        return ""
    link = motion.robot.sections - 1
    taken = per_section(motion.robot.outline.sections, allowance.at_steps(line), np.maximum)
    (step,) = first_largest(taken[:, -1])
    return f"At the tip {allowance.words(line, step, link)}."


def tolerances(motion: Motion, count: int = DRAWS, seed: int = 0) -> Tolerances:
    """The budget of a motion, and what comes of drawn arms; `count` and `seed` as of `draw`.

    Raises
    ------
    InputError
        There are no tolerances in the task, nor in its robot, and none of its obstacles may be early or late.
    """
    budget, late = motion.task.budget, timings(motion)
    if budget is not None:
        shared = Shared(motion)
        drawn = draw(motion, budget, shared.taken, count, seed)
        return Tolerances(
            budget, _of_links(shared), drawn, late, _taken_for_exact(motion, budget), _of_tensions(shared)
        )
    if late:
        return Tolerances(None, timings=late)
    refuse_unknown_sections(motion.robot, zeros=False)  # before tolerances are advised
    moving = ", or timing_s = 0.1, as obstacles move" if motion.task.moving else ""
    none = " timing_s is that of obstacles that move, and none does." if motion.task.spec.tolerance.timing_s else ""
    raise InputError(
        f"{motion.task.name}: neither the task nor its robot has tolerances.{none} Give them in a table [tolerance], "
        f"such as calibration_deg = 0.1 and registration_deg = 0.05{moving}; docs/tolerances.md lists them"
    )


def _taken_for_exact(motion: Motion, budget: Budget) -> str:
    """What errors of EA and masses would take at the tip if they were given, in words; empty if they are."""
    mechanics = motion.task.mechanics
    if mechanics is None or budget.stiffness or budget.mass:
        return ""
    off = dataclasses.replace(budget, mechanics=mechanics, stiffness=0.01, friction=0.0)
    left = off.left_over(motion.task.base, motion.angles, motion.at, motion.body, motion.held)
    taken = COVERAGE * float(left["axial_stiffness_percent"][:, -1].max())
    return (
        f"EA and masses are taken for exact; each per cent (1σ) of either would take {at_most(1e3 * taken)} mm at the "
        "tip: axial_stiffness_percent, mass_percent."
    )


def _of_tensions(shared: Shared) -> str:
    """What is taken of tensions where they leave least, in words; empty if nothing is."""
    held, pulls = shared.motion.held, shared.pulls
    if held is None or pulls is None:
        return ""
    left = held.tensions - pulls.taken
    step, cable = first_smallest(left)
    said, value = pulls.words(step, cable), float(left[step, cable])
    rest = f"{value:.1f} N are left" if value > 0 else f"{-value:.1f} N are lacking"
    return f"Of cable {cable + 1} at step {step}, {said}; {rest}." if said else ""


def _of_links(shared: Shared) -> tuple[LinkBudget, ...]:
    """What is taken of each link of a motion with tolerances."""
    motion, allowance = shared.motion, shared.allowance
    assert allowance is not None
    parts, taken, left = allowance.parts(motion.outline), shared.taken, shared.left
    whole = allowance.at_steps(motion.outline)
    links = []
    for link in range(motion.robot.sections):
        (step,), (least,) = first_largest(taken[:, link]), first_smallest(left[:, link])
        chords = np.flatnonzero(motion.robot.outline.sections == link)
        chord = chords[first_largest(whole[step, chords])]
        each = {name: float(part[step, chord]) for name, part in parts.items()}
        beyond = bool(shared.clearance[least, link] >= motion.horizon)
        links.append(LinkBudget(link + 1, step, each, float(taken[step, link]), float(left[least, link]), beyond))
    return tuple(links)
