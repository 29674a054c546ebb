"""Moving the way-points of a spline until the arm has the most room (Levenberg–Marquardt on hinged residuals)."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from hognose.errors import HognoseError
from hognose.route.fit.objective import Judged, Objective, judge

Array = NDArray[np.float64]

# Lengths are in parts of half the width that the body needs with its margin.
#: A way-point moves at most so far at once.
STRIDE = 0.65
#: By how much more clearance is wanted than there is. Much is fast; little tells the tightest place from others.
MORE = (0.2, 0.05, 0.013)
#: Little more is wanted only where at most this is missing.
WORTHWHILE = 0.25
#: Rounds without the least gain after which less is wanted, at last nothing, and rounds at most.
PATIENCE, GAIN, ROUNDS = 4, 1.6e-3, 90
#: So much more than the margin is wanted at least: links do not keep quite what coarse steps show.
SPARE = 0.065
#: So much beyond what is enough is wanted, to get there.
AMPLE = 0.033


def improved(objective: Objective, way_points: Array, enough: float, goes_on: Callable[[], bool]) -> Iterator[Judged]:
    """Better and better splines, the first one the given; ends when nothing is gained or time is up.

    Parameters
    ----------
    objective
    way_points : (m, 3) m
    enough
        Clearance in m beyond which nothing is sought.
    goes_on
        Asked before each round.
    """
    now = judged_or_none(objective, way_points)
    if now is None:
        return
    yield now
    best, damping, strict, rounds = now.score, 1e-2, 1.0, 0
    half = objective.lengths.half
    enough = min(enough, objective.far)
    for push in (half * more for more in MORE):
        idle = 0
        while idle < PATIENCE and rounds < ROUNDS:
            if not goes_on() or (now.feasible and now.clearance >= enough):
                return
            rounds += 1
            # Where limits are exceeded they weigh more and more; where not, more room is wanted than there is.
            strict = max(1.0, strict / 2) if now.feasible else min(2 * strict, 100.0)
            more = now.clearance + (push if now.feasible else 0.0)
            wanted = max(objective.margin + min(SPARE * half, push), more)
            now, damping = _stepped(now, min(wanted, enough + AMPLE * half), strict, damping)
            idle += 1
            if now.score > best + GAIN * half:
                best, idle = now.score, 0
                yield now
        # Thick parts of a tapered body may lie so much deeper.
        if best < objective.margin - WORTHWHILE * half - (objective.lengths.body - half):
            return
        damping = 1e-2


def _stepped(now: Judged, wanted: float, strict: float, damping: float) -> tuple[Judged, float]:
    """One accepted step, or where it was with more damping."""
    merit = now.merit(wanted, strict)
    residuals, rows = now.residuals(wanted, strict)
    normal, slope = rows.T @ rows, rows.T @ residuals
    scale = np.maximum(np.diag(normal), 1e-3 * np.diag(normal).max() + 1e-12)
    free = np.flatnonzero(now.objective.free) + 1
    for _ in range(5):
        step = -np.linalg.solve(normal + damping * np.diag(scale), slope).reshape(-1, 3)
        longest = np.linalg.norm(step, axis=1).max(initial=0.0)
        way_points = now.way_points.copy()
        way_points[free] += step * min(1.0, STRIDE * now.objective.lengths.body / max(longest, 1e-12))
        then = judged_or_none(now.objective, way_points)
        if then is not None and then.merit(wanted, strict) < merit:
            return then, max(damping / 4, 1e-4)
        damping *= 4
    return now, min(damping, 1e3)


def judged_or_none(objective: Objective, way_points: Array) -> Judged | None:
    """What the arm makes of a spline; None where there is none or it cannot follow it."""
    try:
        return judge(objective, way_points)
    except HognoseError:
        return None
