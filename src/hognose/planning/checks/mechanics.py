"""Criteria of what the cables must pull, and of buckling."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from hognose.mechanics import Held, Mechanics, why_unknown
from hognose.mechanics.remedies import (
    Poses,
    least_tension_held,
    pretension_allowed,
    rounded_up,
    softest,
    tension_needed,
    weight_borne,
)
from hognose.planning.checks.check import Check
from hognose.planning.checks.criterion import KINEMATICS, Criterion
from hognose.planning.checks.findings import least, most, not_judged, peak
from hognose.planning.checks.shared import Shared
from hognose.planning.columns import LARGEST_LOAD_FACTOR
from hognose.planning.motion import Motion
from hognose.planning.task import Task
from hognose.robot.base import straight_joints
from hognose.robot.tension import STIFFEST
from hognose.ties import first_largest, first_smallest

#: An arm that would have to be so much lighter has its masses in g, or nearly so.
_IN_GRAMS = 0.02
#: Tolerances that change tensions and load factors, but are taken off clearances only.
_OF_CABLES = {"cable_zero", "axial_stiffness_percent", "mass_percent"}


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
        yield peak(held.tensions, mechanics.tension_max, "cable", _for_exact(motion))
        return
    step, section = _not_held(held)
    beyond = np.flatnonzero(motion.robot.cable_sections >= section)  # those that pass the section
    cable = beyond[first_largest(held.tensions[step, beyond])]
    needed, said = _stronger(mechanics, _poses(motion, step), section)
    yield most(
        needed,
        mechanics.tension_max,
        False,
        step=step,
        section=section,
        cable=cable,
        detail=said + _for_exact(motion, said),
    )


def slack(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No cable is slack: none is pulled less than the robot demands, and all are pulled.

    Made for robots whose mechanics are known.
    """
    held, mechanics = motion.held, motion.task.mechanics
    if held is None or mechanics is None:
        return
    step, cable = first_smallest(held.tensions)
    lowest = held.tensions[step, cable]
    detail = "" if lowest > 0 else _tighter(motion, mechanics, held, step, cable)
    detail += _for_exact(motion, detail)
    yield least(lowest, mechanics.tension_min, step=step, cable=cable, detail=detail)


def buckling(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The arm does not buckle, even if all tensions and the weight grow by the load factor that the robot demands.

    Made for robots whose mechanics are known. At 1000 at most, it does not buckle at all. The section is the one that
    turns the most as the arm begins to buckle, the cable the one that pushes it most.
    """
    held, mechanics = motion.held, motion.task.mechanics
    if held is None or mechanics is None:
        return
    (step,) = first_smallest(held.load_factor)
    factor, poses = min(float(held.load_factor[step]), LARGEST_LOAD_FACTOR), _poses(motion, step)
    section, cable = softest(mechanics, held.tensions, poses)
    detail = "" if factor >= mechanics.load_factor_min else _remedy(mechanics, poses, section, factor)
    detail += _for_exact(motion, detail)
    yield least(factor, mechanics.load_factor_min, step=step, section=section, cable=cable, detail=detail)


def _for_exact(motion: Motion, said: str = "") -> str:
    """What tolerances do not enter, in words behind others; empty if there are none that would change it."""
    budget = motion.task.budget
    if budget is None or _OF_CABLES.isdisjoint(budget.given):
        return ""
    return f"{'; ' if said else ''}judged for exact cable zeros, EA and masses"


def why_it_cannot_begin(task: Task) -> str:
    """Why the arm does not stand where every plan begins, straight before the entrance, in words; empty if it does.

    Where mechanics are not known, or the arm does not lie straight there, nothing is said.
    """
    mechanics, base = task.mechanics, task.base
    if mechanics is None or not base.straight:
        return ""
    at, straight = (
        base.coordinates(np.zeros(1), straight_joints(base, task.robot)),
        np.zeros((1, task.robot.sections, 2)),
    )
    poses = Poses(straight, task.gravity(at), 0)
    held = mechanics.hold(straight, poses.gravity)
    if not held.is_held[0]:
        return _stronger(mechanics, poses, _not_held(held)[1])[1]
    factor = float(held.load_factor[0])
    if factor >= mechanics.load_factor_min:
        return ""
    return _remedy(mechanics, poses, softest(mechanics, held.tensions, poses)[0], factor)


def _not_held(held: Held) -> tuple[int, int]:
    """The step and the section (0-based) where most is left of the torques that tensions have to balance."""
    off = np.abs(held.left).reshape(len(held.left), -1, 2).max(axis=2)
    step, section = first_largest(np.where(held.is_held[:, None], -1.0, off))
    return step, section


def _stronger(mechanics: Mechanics, poses: Poses, section: int) -> tuple[float, str]:
    """The largest tension (N) that it takes, and what to change so that tensions hold a section."""
    needed, lighter = tension_needed(mechanics, poses), _lighter(mechanics, poses) or "give it more cables"
    more = (
        f"raise tension_max_N to {needed:g} N, or " if math.isfinite(needed) else "more tension_max_N does not help; "
    )
    return needed, f"no tensions hold section {section + 1}: {more}{lighter}"


def _poses(motion: Motion, worst: int) -> Poses:
    return Poses(motion.angles, motion.task.gravity(motion.at), worst)


def _remedy(mechanics: Mechanics, poses: Poses, section: int, factor: float) -> str:
    """What to change so that an arm stands."""
    limit, own = mechanics.load_factor_min, mechanics.robot.cable_sections == section
    said = f"section {section + 1} {'buckles' if factor < 1 else 'is too close to buckling'}"
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
    """EA that is so many times as large, in words; load factors are proportional to it."""
    stiff = mechanics.axial_stiffness
    if times * stiff.max() > STIFFEST:
        return "take stiffer cables than there are" if math.isfinite(times) else "give every joint cables that hold it"
    if np.ptp(stiff) > 0:
        return f"take {rounded_up(times):g} times the EA in all sections"
    return f"take EA ≥ {rounded_up(1e-3 * times * float(stiff[0])):g} kN"


def _lighter(mechanics: Mechanics, poses: Poses, factor: float = 0.0) -> str:
    """How much lighter the arm would have to be, in words; empty if that alone is not enough."""
    share = weight_borne(mechanics, poses, factor)
    unit = " (are they in kg?)" if share < _IN_GRAMS else ""
    return f"make links and tool lighter, to {100 * share:.3g} % of their masses{unit}" if share > 0 else ""


def _tighter(motion: Motion, mechanics: Mechanics, held: Held, step: int, cable: int) -> str:
    """What keeps all cables tensioned."""
    least_factor = float(held.load_factor.min())
    factor = mechanics.load_factor_min if least_factor >= mechanics.load_factor_min else 0.0
    tension = least_tension_held(mechanics, _poses(motion, step), factor)
    said = f"nothing keeps cable {cable + 1} tensioned"
    if not tension:
        return f"{said}: raise tension_min_N above 0, and pretension_N"
    also = " and pretension_N with it" if tension > mechanics.pretension.min() else ""
    return f"{said}: raise tension_min_N to {tension:g} N{also}"


CRITERIA = (
    Criterion("peak_tension", "largest tension", "N", peak_tension, KINEMATICS),
    Criterion("slack", "least tension", "N", slack, KINEMATICS),
    Criterion("buckling", "load factor of buckling", "1", buckling, KINEMATICS),
)
