"""Criteria of what the cables must pull, and of buckling."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hognose.mechanics import Held, Mechanics, why_unknown
from hognose.mechanics.remedies import (
    Poses,
    least_tension_held,
    pretension_allowed,
    rounded_up,
    tension_needed,
    weight_borne,
    where_it_buckles,
    with_pretension,
)
from hognose.planning.checks.between_steps import tensions_between
from hognose.planning.checks.check import Check
from hognose.planning.checks.criterion import KINEMATICS, Criterion
from hognose.planning.checks.findings import least, most, not_judged, peak
from hognose.planning.checks.shared import Shared
from hognose.planning.columns import LARGEST_LOAD_FACTOR
from hognose.planning.motion import Motion
from hognose.planning.task import Task
from hognose.planning.tolerance.pulls import PullAllowance
from hognose.robot.base import straight_joints
from hognose.robot.tension import AT_LIMIT, STIFFEST
from hognose.ties import first_largest, first_smallest

#: An arm that would have to be so much lighter has its masses in g, or nearly so.
_IN_GRAMS = 0.02
#: What is said of tensions that are good at the steps, and not between them.
_BETWEEN = "on the way from this step to the next; take smaller steps (motion.step)"
#: How often a tension that tolerances leave above 0 is sought anew.
_MOST_ROUNDS = 4


def peak_tension(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No cable is pulled more than the robot allows, tolerances taken into account.

    Where no tensions within the limits hold the arm, what the limit would have to be at least. Not judged for robots
    whose mechanics are not known.
    """
    held, mechanics = motion.held, motion.task.mechanics
    if held is None or mechanics is None:
        yield not_judged(f"mechanics are not known: {why_unknown(motion.robot)}")
        return
    if held.is_held.all():
        yield _largest(motion, shared, held, mechanics)
        return
    step, section = _not_held(held)
    beyond = np.flatnonzero(motion.robot.cable_sections >= section)  # those that pass the section
    cable = beyond[first_largest(held.tensions[step, beyond])]
    needed, said = _stronger(mechanics, _poses(motion, step), section)
    yield most(needed, mechanics.tension_max, False, step=step, section=section, cable=cable, detail=said)


def _largest(motion: Motion, shared: Shared, held: Held, mechanics: Mechanics) -> Check:
    between, limit, pulls = tensions_between(motion), mechanics.tension_max, shared.pulls
    if between.largest > AT_LIMIT * limit:
        step, cable = between.largest_at
        return most(between.largest, limit, step=step, cable=cable, detail=_BETWEEN)
    if pulls is None:
        return peak(held.tensions, limit, "cable")
    found = held.tensions + pulls.taken
    step, cable = first_largest(found)
    detail = pulls.words(step, cable)
    if found[step, cable] > limit:
        better = pulls.if_known_better(limit - held.tensions, pulls.tensions, (step, cable))
        detail += f"; raise tension_max_N to {rounded_up(found[step, cable]):g} N{better and f', or {better}'}"
    return most(found[step, cable], limit, step=step, cable=cable, detail=detail)


def slack(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No cable is slack: none is pulled less than the robot demands, and tolerances leave all of them tensioned.

    Made for robots whose mechanics are known.
    """
    held, mechanics, pulls = motion.held, motion.task.mechanics, shared.pulls
    if held is None or mechanics is None:
        return
    step, cable = first_smallest(held.tensions)
    lowest, between = held.tensions[step, cable], tensions_between(motion)
    if lowest < mechanics.tension_min or lowest <= 0 or (pulls is None and between.least > 0):
        detail = "" if lowest > 0 else _tighter(motion, mechanics, held, step, cable)
        yield least(lowest, mechanics.tension_min, step=step, cable=cable, detail=detail)
    elif between.least <= 0 or pulls is None:
        step, cable = between.least_at
        yield least(between.least, mechanics.tension_min, step=step, cable=cable, detail=_BETWEEN)
    else:
        left = held.tensions - pulls.taken
        step, cable = first_smallest(left)
        detail = pulls.words(step, cable)
        if left[step, cable] <= 0:
            better = pulls.if_known_better(held.tensions, pulls.tensions, (step, cable))
            enough = _tension_for_tolerances(motion, mechanics, -left[step, cable])
            what = [f"raise tension_min_N to {enough:g} N" if enough else "", better]
            detail += f"; {', or '.join(filter(None, what))}" if any(what) else ""
        yield least(left[step, cable], 0.0, step=step, cable=cable, detail=detail)


def buckling(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The arm does not buckle, even if all tensions and the weight grow by the load factor that the robot demands.

    Made for robots whose mechanics are known. At 1000 at most, it does not buckle at all. What tolerances take is taken
    off. The section is the one that turns the most as the arm begins to buckle, the cable the one that pushes it most.
    """
    held, mechanics, pulls = motion.held, motion.task.mechanics, shared.pulls
    if held is None or mechanics is None:
        return
    factors = held.load_factor if pulls is None else pulls.left(held.load_factor)
    (step,) = first_smallest(factors)
    factor, limit = min(float(factors[step]), LARGEST_LOAD_FACTOR), mechanics.load_factor_min
    poses = _poses(motion, step)
    section, cable = where_it_buckles(mechanics, held.tensions, poses)
    exact, detail = float(held.load_factor[step]), ""
    if exact < limit:
        detail = _remedy(mechanics, poses, section, exact)
    elif pulls is not None:
        detail = pulls.words_of_factor(step, min(exact, LARGEST_LOAD_FACTOR) - factor)
        if factor < limit:
            better = pulls.if_known_better(1.0 / limit - 1.0 / held.load_factor, pulls.factors, (step,))
            detail += f"; {better or 'take more EA, or less pretension'}"
    yield least(factor, limit, step=step, section=section, cable=cable, detail=detail)


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
    return _remedy(mechanics, poses, where_it_buckles(mechanics, held.tensions, poses)[0], factor)


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


def _tension_for_tolerances(motion: Motion, mechanics: Mechanics, missing: float) -> float:
    """A `tension_min` (N) with which tolerances leave all cables tensioned, and the arm stands; 0 if none was found."""
    budget, poses = motion.task.budget, _poses(motion, 0)
    tension = mechanics.tension_min
    for _ in range(_MOST_ROUNDS):
        tension = rounded_up(tension + missing)
        if not tension < mechanics.tension_max:
            break
        tighter = with_pretension(replace(mechanics, tension_min=tension), 1.0)
        held = tighter.hold(poses.angles, poses.gravity)
        pulls = PullAllowance.of(budget, tighter, poses.angles, held, poses.gravity)
        if pulls is None or not held.is_held.all():
            break
        missing = -float((held.tensions - pulls.taken).min())
        if missing < 0:
            stands = bool((pulls.left(held.load_factor) >= mechanics.load_factor_min).all())
            most_left = float((held.tensions + pulls.taken).max())
            return tension if stands and most_left <= mechanics.tension_max else 0.0
        missing += 0.1
    return 0.0


CRITERIA = (
    Criterion("peak_tension", "largest tension", "N", peak_tension, KINEMATICS),
    Criterion("slack", "least tension", "N", slack, KINEMATICS),
    Criterion("buckling", "load factor of buckling", "1", buckling, KINEMATICS),
)
