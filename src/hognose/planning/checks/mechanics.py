"""Criteria of what the cables must pull, and of buckling."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hognose.mechanics import Held, Mechanics, why_unknown
from hognose.mechanics.advice import stiffer_or_looser, stronger, where_it_is_not_held, why_it_does_not_stand
from hognose.mechanics.remedies import Poses, least_tension_held, where_it_buckles
from hognose.planning.checks.check import Check
from hognose.planning.checks.criterion import KINEMATICS, Criterion
from hognose.planning.checks.findings import least, most, not_judged, peak
from hognose.planning.checks.pull_advice import tension_max_that_is_enough, tension_min_that_is_enough
from hognose.planning.checks.shared import Shared
from hognose.planning.columns import LARGEST_LOAD_FACTOR
from hognose.planning.motion import Motion
from hognose.planning.task import Task
from hognose.planning.tolerance.pulls import PullAllowance
from hognose.robot.base import straight_joints
from hognose.robot.tension import AT_LIMIT
from hognose.ties import first_largest, first_smallest

#: What is said of tensions that are good at the steps, and not between them.
_BETWEEN = "on the way from this step to the next; take smaller steps (motion.step)"


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
    step, section = where_it_is_not_held(held)
    beyond = np.flatnonzero(motion.robot.cable_sections >= section)  # those that pass the section
    cable = beyond[first_largest(held.tensions[step, beyond])]
    needed, said = stronger(mechanics, _poses(motion, step), section)
    said += _exact(shared.pulls)
    yield most(needed, mechanics.tension_max, False, step=step, section=section, cable=cable, detail=said)


def _largest(motion: Motion, shared: Shared, held: Held, mechanics: Mechanics) -> Check:
    between, limit, pulls = shared.between, mechanics.tension_max, shared.pulls
    found = held.tensions if pulls is None else held.tensions + pulls.taken
    if found.max() <= limit and between.largest > AT_LIMIT * limit:
        step, cable = between.largest_at
        return most(between.largest, limit, step=step, cable=cable, detail=_BETWEEN)
    if pulls is None:
        return peak(held.tensions, limit, "cable")
    step, cable = first_largest(found)
    detail = pulls.words(step, cable)
    if found[step, cable] > limit:
        enough = tension_max_that_is_enough(motion, mechanics)
        better = pulls.if_known_better(limit - held.tensions, pulls.tensions, (step, cable))
        detail = _advice(detail, f"raise tension_max_N to {enough:g} N" if enough else "", better)
    return most(found[step, cable], limit, step=step, cable=cable, detail=detail)


def slack(motion: Motion, shared: Shared) -> Iterator[Check]:
    """No cable is slack: none is pulled less than the robot demands, and tolerances leave all of them tensioned.

    Made for robots whose mechanics are known.
    """
    held, mechanics, pulls = motion.held, motion.task.mechanics, shared.pulls
    if held is None or mechanics is None:
        return
    step, cable = first_smallest(held.tensions)
    lowest, between = held.tensions[step, cable], shared.between
    left = held.tensions if pulls is None else held.tensions - pulls.taken
    if lowest < mechanics.tension_min or lowest <= 0:
        detail = "" if lowest > 0 else _tighter(motion, mechanics, held, step, cable) + _exact(pulls)
        yield least(lowest, mechanics.tension_min, step=step, cable=cable, detail=detail)
    elif left.min() > 0 >= between.least:
        step, cable = between.least_at
        yield least(between.least, 0.0, step=step, cable=cable, detail=_BETWEEN)
    elif pulls is None:
        yield least(lowest, mechanics.tension_min, step=step, cable=cable)
    else:
        yield _left(motion, held, mechanics, pulls)


def _left(motion: Motion, held: Held, mechanics: Mechanics, pulls: PullAllowance) -> Check:
    """What tolerances leave of the least tension."""
    left = held.tensions - pulls.taken
    step, cable = first_smallest(left)
    detail = pulls.words(step, cable)
    if left[step, cable] <= 0:
        enough = tension_min_that_is_enough(motion, mechanics)
        also = " and pretension_N with it" if enough > mechanics.pretension.min() else ""
        better = pulls.if_known_better(held.tensions, pulls.tensions, (step, cable))
        detail = _advice(detail, f"raise tension_min_N to {enough:g} N{also}" if enough else "", better)
    return least(left[step, cable], 0.0, step=step, cable=cable, detail=detail)


def buckling(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The arm does not buckle, even if all tensions and the weight grow by the load factor that the robot demands.

    Made for robots whose mechanics are known. At 1000 at most, it does not buckle at all. What tolerances take is taken
    off. The section is the one that turns the most as the arm begins to buckle, the cable the one that pushes it most.
    """
    held, mechanics, pulls = motion.held, motion.task.mechanics, shared.pulls
    if held is None or mechanics is None:
        return
    limit, exact = mechanics.load_factor_min, held.load_factor
    factors = exact if pulls is None or exact.min() < limit else pulls.left(exact)
    (step,) = first_smallest(factors)
    factor, poses = min(float(factors[step]), LARGEST_LOAD_FACTOR), _poses(motion, step)
    section, cable = where_it_buckles(mechanics, held.tensions, poses)
    detail = ""
    if exact[step] < limit:
        detail = stiffer_or_looser(mechanics, poses, section, factor) + _exact(pulls)
    elif pulls is not None:
        detail = pulls.words_of_factor(step, min(float(exact[step]), LARGEST_LOAD_FACTOR) - factor)
        if factor < limit:
            better = pulls.if_known_better(1.0 / limit - 1.0 / exact, pulls.factors, (step,))
            detail = _advice(detail, better or "take more EA, or less pretension")
    yield least(factor, limit, step=step, section=section, cable=cable, detail=detail)


def _advice(said: str, *ways: str) -> str:
    """What is said, and behind it what to do, one or another."""
    return "; ".join(filter(None, (said, ", or ".join(filter(None, ways)))))


def _exact(pulls: PullAllowance | None) -> str:
    """What is said behind advice that does not take tolerances into account."""
    return "" if pulls is None else " (before tolerances)"


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
    return why_it_does_not_stand(mechanics, Poses(straight, task.gravity(at), 0))


def _poses(motion: Motion, worst: int) -> Poses:
    return Poses(motion.postures, motion.task.gravity(motion.at), worst)


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
