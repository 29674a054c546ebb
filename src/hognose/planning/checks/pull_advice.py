"""Limits of tension with which tolerances leave enough; what is returned has been tried on the whole motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from hognose.mechanics import Held, Mechanics
from hognose.mechanics.remedies import rounded_up, with_pretension
from hognose.planning.motion import Motion
from hognose.planning.tolerance.pulls import PullAllowance
from hognose.robot.tension import LARGEST_STRAIN

#: How often a value is sought anew.
_MOST_ROUNDS = 6
#: What is left of a tension (N) must be above zero.
_ABOVE_ZERO = 1e-3


def tension_min_that_is_enough(motion: Motion, mechanics: Mechanics) -> float:
    """A `tension_min` (N) with which tolerances leave all cables tensioned, and the arm stands; 0 if none was found.

    A pretension below it is raised with it.
    """

    def tighter(least: float) -> Mechanics | None:
        return with_pretension(replace(mechanics, tension_min=least), 1.0) if least < mechanics.tension_max else None

    def missing(arm: Mechanics, held: Held, pulls: PullAllowance) -> float:
        return _ABOVE_ZERO - float((held.tensions - pulls.taken).min())

    return _sought(motion, mechanics.tension_min, tighter, missing)


def tension_max_that_is_enough(motion: Motion, mechanics: Mechanics) -> float:
    """A `tension_max` (N) that tensions and tolerances keep; 0 if none was found that cables bear."""
    most = LARGEST_STRAIN * float(mechanics.axial_stiffness.min())

    def weaker(largest: float) -> Mechanics | None:
        return replace(mechanics, tension_max=largest) if largest <= most else None

    def missing(arm: Mechanics, held: Held, pulls: PullAllowance) -> float:
        return float((held.tensions + pulls.taken).max()) - arm.tension_max

    return _sought(motion, mechanics.tension_max, weaker, missing)


def _sought(
    motion: Motion,
    value: float,
    varied: Callable[[float], Mechanics | None],
    missing: Callable[[Mechanics, Held, PullAllowance], float],
) -> float:
    """A value above another with which nothing is missing, and with which the arm stands; 0 if none was found."""
    budget, angles, gravity = motion.task.budget, motion.angles, motion.task.gravity(motion.at)
    for _ in range(_MOST_ROUNDS):
        arm = varied(value)
        held = None if arm is None else arm.hold(angles, gravity)
        if arm is None or held is None or not held.is_held.all():
            return 0.0
        pulls = PullAllowance.of(budget, arm, angles, held, gravity)
        if pulls is None:
            return 0.0
        off = missing(arm, held, pulls)
        if off <= 0:
            stands = pulls.left(held.load_factor) >= arm.load_factor_min
            fits = held.tensions + pulls.taken <= arm.tension_max
            return value if stands.all() and fits.all() else 0.0
        value = rounded_up(value + off)
    return 0.0
