"""What to change so that an arm stands, in words; values are those of `remedies`, which have been tried."""

from __future__ import annotations

import math

import numpy as np

from hognose.mechanics.mechanics import Mechanics
from hognose.mechanics.remedies import (
    Poses,
    bending_borne,
    pretension_allowed,
    rounded_up,
    stiffness_needed,
    tension_needed,
    weight_borne,
    where_it_buckles,
)
from hognose.mechanics.states import Held
from hognose.robot.tension import STIFFEST
from hognose.ties import first_largest

#: An arm that would have to be so much lighter has its masses in g, or nearly so.
_IN_GRAMS = 0.02


def why_it_does_not_stand(mechanics: Mechanics, poses: Poses) -> str:
    """Why an arm does not stand in the only pose there is, and what to change, in words; empty if it stands."""
    held = mechanics.hold(poses.angles, poses.gravity)
    if not held.is_held[0]:
        return stronger(mechanics, poses, where_it_is_not_held(held)[1])[1]
    factor = float(held.load_factor[0])
    if factor >= mechanics.load_factor_min:
        return ""
    return stiffer_or_looser(mechanics, poses, where_it_buckles(mechanics, held.tensions, poses)[0], factor)


def where_it_is_not_held(held: Held) -> tuple[int, int]:
    """The step and the section (0-based) where most is left of the torques that tensions have to balance."""
    off = np.abs(held.left).reshape(len(held.left), -1, 2).max(axis=2)
    step, section = first_largest(np.where(held.is_held[:, None], -1.0, off))
    return step, section


def stronger(mechanics: Mechanics, poses: Poses, section: int) -> tuple[float, str]:
    """The largest tension (N) that it takes, and what to change so that tensions hold a section (0-based)."""
    needed = tension_needed(mechanics, poses)
    lighter = _lighter(mechanics, poses) or _softer(mechanics, poses) or "give it more cables"
    more = (
        f"raise tension_max_N to {needed:g} N, or " if math.isfinite(needed) else "more tension_max_N does not help; "
    )
    return needed, f"no tensions hold section {section + 1}: {more}{lighter}"


def stiffer_or_looser(mechanics: Mechanics, poses: Poses, section: int, factor: float) -> str:
    """What to change so that an arm stands whose section (0-based) buckles, or nearly so, with a load factor."""
    limit, own = mechanics.load_factor_min, mechanics.robot.cable_sections == section
    said = f"section {section + 1} {'buckles' if factor < 1 else 'is too close to buckling'}"
    if mechanics.springs.any():
        stiffer = _stiffer(mechanics, stiffness_needed(mechanics, poses, limit))
    else:
        stiffer = _stiffer(mechanics, limit / factor if factor > 0 else math.inf)
    share = pretension_allowed(mechanics, poses, limit)
    if share is None:
        lighter = _lighter(mechanics, poses, limit)
        if lighter:
            return f"{said} under the weight: {stiffer}, or {lighter}"
        return f"{said} even with all cables at tension_min_N, {mechanics.tension_min:g} N: {stiffer}"
    given = float(mechanics.pretension[own].max())
    if np.ptp(mechanics.pretension) > 0:
        floor = f", but none below tension_min_N of {mechanics.tension_min:g} N"
        return f"{said}: pretensions are too high; lower all to {100 * share:.3g} % of themselves{floor}, or {stiffer}"
    return f"{said}: pretension {given:g} N is above {share * given:.4g} N; lower it, or {stiffer}"


def _stiffer(mechanics: Mechanics, times: float) -> str:
    """EA that is so many times as large, in words."""
    stiff = mechanics.axial_stiffness
    if times * stiff.max() > STIFFEST * (1.0 + 1e-9):
        if mechanics.springs.any():
            return "take stiffer cables than there are, or a stiffer backbone"
        return "take stiffer cables than there are" if math.isfinite(times) else "give every joint cables that hold it"
    if np.ptp(stiff) > 0:
        return f"take {rounded_up(times):g} times the EA in all sections"
    return f"take EA ≥ {rounded_up(1e-3 * times * float(stiff[0])):g} kN"


def _lighter(mechanics: Mechanics, poses: Poses, factor: float = 0.0) -> str:
    """How much lighter the arm would have to be, in words; empty if that alone is not enough."""
    share = weight_borne(mechanics, poses, factor)
    unit = " (are they in kg?)" if share < _IN_GRAMS else ""
    return f"make links and tool lighter, to {100 * share:.3g} % of their masses{unit}" if share > 0 else ""


def _softer(mechanics: Mechanics, poses: Poses) -> str:
    """How much softer the sections would have to be, in words; empty if that alone is not enough."""
    share = bending_borne(mechanics, poses) if mechanics.springs.any() else 0.0
    return f"lower bending_stiffness_N_m2, to {100 * share:.3g} % of it" if share > 0 else ""
