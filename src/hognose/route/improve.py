"""Moving the way-points of a spline until the arm has the most room (Levenberg–Marquardt on hinged residuals)."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from hognose.errors import HognoseError
from hognose.route.score import FAR, Brief, Judged, judge

Array = NDArray[np.float64]

#: A way-point moves at most so far (m) at once.
STRIDE = 0.02
#: By how much (m) more clearance is wanted than there is. Much is fast; little tells the tightest place from others.
MORE = (0.006, 0.0015, 0.0004)
#: Little more is wanted only where at most this (m) is missing.
WORTHWHILE = 0.002
#: Rounds without the least gain (m) after which less is wanted, at last nothing, and rounds at most.
PATIENCE, GAIN, ROUNDS = 4, 5e-5, 90


def improved(brief: Brief, way_points: Array, enough: float, goes_on: Callable[[], bool]) -> Iterator[Judged]:
    """Better and better splines, the first one the given; ends when nothing is gained or time is up.

    Parameters
    ----------
    brief
    way_points : (m, 3) m
    enough
        Clearance in m beyond which nothing is sought.
    goes_on
        Asked before each round.
    """
    now = _judged(brief, way_points)
    if now is None:
        return
    yield now
    best, damping, strict, rounds = now.score, 1e-2, 1.0, 0
    enough = min(enough, FAR)
    for push in MORE:
        idle = 0
        while idle < PATIENCE and rounds < ROUNDS:
            if not goes_on() or (now.feasible and now.clearance >= enough):
                return
            rounds += 1
            # Where limits are exceeded they weigh more and more; where not, more room is wanted than there is.
            strict = max(1.0, strict / 2) if now.feasible else min(2 * strict, 100.0)
            more = now.clearance + (push if now.feasible else 0.0)
            wanted = max(brief.margin + min(0.002, push), more)
            now, damping = _stepped(now, min(wanted, enough + 1e-3), strict, damping)
            idle += 1
            if now.score > best + GAIN:
                best, idle = now.score, 0
                yield now
        if best < brief.margin - WORTHWHILE:
            return
        damping = 1e-2


def _stepped(now: Judged, wanted: float, strict: float, damping: float) -> tuple[Judged, float]:
    """One accepted step, or where it was with more damping."""
    merit = now.merit(wanted, strict)
    residuals, rows = now.residuals(wanted, strict)
    normal, slope = rows.T @ rows, rows.T @ residuals
    scale = np.maximum(np.diag(normal), 1e-3 * np.diag(normal).max() + 1e-12)
    free = np.flatnonzero(now.brief.free) + 1
    for _ in range(5):
        step = -np.linalg.solve(normal + damping * np.diag(scale), slope).reshape(-1, 3)
        longest = np.linalg.norm(step, axis=1).max(initial=0.0)
        way_points = now.way_points.copy()
        way_points[free] += step * min(1.0, STRIDE / max(longest, 1e-12))
        then = _judged(now.brief, way_points)
        if then is not None and then.merit(wanted, strict) < merit:
            return then, max(damping / 4, 1e-4)
        damping *= 4
    return now, min(damping, 1e3)


def _judged(brief: Brief, way_points: Array) -> Judged | None:
    try:
        return judge(brief, way_points)
    except HognoseError:
        return None
