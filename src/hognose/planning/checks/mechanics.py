"""Criteria of what the cables must pull, and of buckling."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from hognose.mechanics import Held, Mechanics, why_unknown
from hognose.mechanics.remedies import pretension_allowed, softest_section, tension_needed
from hognose.planning.checks.check import Check
from hognose.planning.checks.criterion import KINEMATICS, Criterion
from hognose.planning.checks.findings import least, most, not_judged, peak
from hognose.planning.checks.shared import Shared
from hognose.planning.columns import LARGEST_LOAD_FACTOR
from hognose.planning.motion import Motion
from hognose.ties import first_largest, first_smallest


def peak_tension(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No cable is pulled more than the robot allows.

    Where no tensions within the limits hold the arm, what the limit would have to be at least. Not judged for robots
    whose mechanics are not known.
    """
    held, mechanics = motion.held, motion.task.mechanics
    if held is None or mechanics is None:
        yield not_judged(f"mechanics are not known: {why_unknown(motion.robot)}")
        return
    if held.is_held.all():
        yield peak(held.tensions, mechanics.tension_max, "cable")
        return
    off = np.abs(held.left).reshape(len(held.left), -1, 2).max(axis=2)
    step, section = first_largest(np.where(held.is_held[:, None], -1.0, off))
    part = slice(step, step + 1)
    needed = tension_needed(mechanics, motion.angles[part], motion.task.gravity(motion.at[part]))
    todo = (
        f"raise tension_max_N to {_up(needed)} N, or make links and tool lighter"
        if math.isfinite(needed)
        else "not even larger ones do: give it more cables"
    )
    said = f"no tensions hold section {section + 1}: {todo}"
    yield most(needed, mechanics.tension_max, False, step=step, section=section, detail=said)


def slack(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No cable is slack: none is pulled less than the robot demands, and all are pulled.

    Made for robots whose mechanics are known.
    """
    held, mechanics = motion.held, motion.task.mechanics
    if held is None or mechanics is None:
        return
    step, cable = first_smallest(held.tensions)
    lowest = held.tensions[step, cable]
    detail = "" if lowest > 0 else "raise tension_min_N above 0"
    yield least(lowest, mechanics.tension_min, step=step, cable=cable, detail=detail)


def buckling(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The arm does not buckle, even if all tensions and the weight grow by the load factor that the robot demands.

    Made for robots whose mechanics are known. At 1000 at most, it does not buckle at all.
    """
    held, mechanics = motion.held, motion.task.mechanics
    if held is None or mechanics is None:
        return
    (step,) = first_smallest(held.load_factor)
    factor = min(float(held.load_factor[step]), LARGEST_LOAD_FACTOR)
    section = _softest(motion, mechanics, held, step)
    detail = "" if factor >= mechanics.load_factor_min else _remedy(motion, mechanics, step, section, factor)
    yield least(factor, mechanics.load_factor_min, step=step, section=section, detail=detail)


def _softest(motion: Motion, mechanics: Mechanics, held: Held, step: int) -> int:
    part = slice(step, step + 1)
    return softest_section(mechanics, motion.angles[part], held.tensions[part], motion.task.gravity(motion.at[part]))


def _remedy(motion: Motion, mechanics: Mechanics, step: int, section: int, factor: float) -> str:
    """What to change so that an arm stands."""
    part, limit = slice(step, step + 1), mechanics.load_factor_min
    own = int(np.searchsorted(motion.robot.cable_sections, section))
    stiff = mechanics.axial_stiffness[own] * limit / factor if factor > 0 else math.inf
    allowed = pretension_allowed(mechanics, motion.angles[part], motion.task.gravity(motion.at[part]), limit)
    said = "buckles" if factor < 1 else "is too close to buckling"
    take = f"take EA ≥ {_up(1e-3 * stiff)} kN" if math.isfinite(stiff) else "the cables do not hold every joint"
    if allowed is None:
        return f"section {section + 1} {said} under the weight: {take}, or make links and tool lighter"
    return (
        f"section {section + 1} {said}: pretension {mechanics.pretension[own]:g} N is above "
        f"{_down(allowed[own])} N; lower it, or {take}"
    )


def _up(value: float) -> str:
    """A value rounded up to three digits."""
    digit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return f"{math.ceil(value / digit * (1 - 1e-9)) * digit:g}"


def _down(value: float) -> str:
    """A value rounded down to three digits."""
    if value <= 0:
        return "0"
    digit = 10.0 ** (math.floor(math.log10(value)) - 2)
    return f"{math.floor(value / digit * (1 + 1e-9)) * digit:g}"


CRITERIA = (
    Criterion("peak_tension", "largest tension", "N", peak_tension, KINEMATICS),
    Criterion("slack", "least tension", "N", slack, KINEMATICS),
    Criterion("buckling", "load factor of buckling", "1", buckling, KINEMATICS),
)
