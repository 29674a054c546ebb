"""What drives do between set-points a period apart, if they go from one to the next on cubics from rest to rest.

The cubics of a spline have the smallest mean square acceleration of all curves through the set-points. With zero speed
at both ends a spline goes on as its mirror image there, so that its accelerations at the set-points are a filter of the
second differences: (M[k-1] + 4 M[k] + M[k+1]) / 6 = D[k]. The filter's weights fall by 0.27 a set-point.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: How far the filter reaches: weights beyond are below 1e-12.
_REACH = 22
_RATIO = math.sqrt(3.0) - 2.0
_WEIGHTS = math.sqrt(3.0) * _RATIO ** np.abs(np.arange(-_REACH, _REACH + 1))
#: How many times as large as the largest second difference an acceleration of the spline can be.
_AMPLIFIES = 3.0
#: In so many places from one set-point to the next the speed of a vector is looked at.
_LOOKS = 9


def second_differences(values: Array, period: float) -> Array:
    """Second differences (T, k) of set-points (T, k) a period (s) apart, which go on as mirror images at both ends."""
    steps = np.diff(np.concatenate([values[:1], values, values[-1:]]), axis=0) / period
    changes = np.diff(steps, axis=0) / period
    changes[[0, -1]] *= 2  # the step before the first set-point is the mirror image of the one after it
    return changes


def overruns(values: Array, period: float, fastest: float, hardest: float) -> tuple[float, float]:
    """The largest speed and acceleration of set-points, and of cubics between them, as parts of limits.

    Parameters
    ----------
    values : (T, k)
        At least two set-points from rest to rest, of k quantities.
    period : s
    fastest, hardest
        Limits of speed and acceleration; infinite if there is none.

    Returns
    -------
    tuple
        Parts of the limits that are used; above 1 they are exceeded.
    """
    speeds = np.abs(np.diff(values, axis=0)).max(axis=0) / period
    changes = second_differences(values, period)
    hard = np.abs(changes).max(axis=0)
    # Only what may come near a limit is looked at closely.
    near = (_AMPLIFIES * hard > hardest) | (speeds + _AMPLIFIES * hard * period / 3 > fastest)
    parts = float(speeds.max()) / fastest, float(hard.max()) / hardest
    if not near.any():
        return parts
    accelerations = _filtered(changes[:, near])
    peaks = _peak_speeds(values[:, near], accelerations, period)
    return max(parts[0], peaks / fastest), max(parts[1], float(np.abs(accelerations).max()) / hardest)


def overruns_in_space(values: Array, period: float, fastest: float, hardest: float) -> tuple[float, float]:
    """As `overruns`, of one quantity with three components (T, 3), whose length the limits are about."""
    accelerations = _filtered(second_differences(values, period))
    before, after = accelerations[:-1], accelerations[1:]
    first = np.diff(values, axis=0) / period - period * (2 * before + after) / 6
    speeds = [
        np.linalg.norm(first + period * part * (before + part / 2 * (after - before)), axis=1)
        for part in np.linspace(0.0, 1.0, _LOOKS)
    ]
    # Between set-points the acceleration changes linearly, so that it is largest at one of them.
    return float(np.max(speeds)) / fastest, float(np.linalg.norm(accelerations, axis=1).max()) / hardest


def _filtered(changes: Array) -> Array:
    """The spline's accelerations (T, k) at the set-points."""
    padded, count = _mirrored(changes), len(changes)
    return sum((weight * padded[k : k + count] for k, weight in enumerate(_WEIGHTS)), np.zeros_like(changes))


def _mirrored(changes: Array) -> Array:
    """Rows, mirrored at both ends, and again where they are few."""
    period = 2 * (len(changes) - 1)
    rows = np.abs(np.arange(-_REACH, len(changes) + _REACH)) % period
    return changes[np.minimum(rows, period - rows)]


def _peak_speeds(values: Array, accelerations: Array, period: float) -> float:
    """The largest speed of a spline: at a set-point, or between two where its acceleration changes its sign."""
    before, after = accelerations[:-1], accelerations[1:]
    first = np.diff(values, axis=0) / period - period * (2 * before + after) / 6
    change = before - after
    turns = before * after < 0
    turned = np.where(turns, first + period * before**2 / (2 * np.where(turns, change, 1.0)), 0.0)
    last = first + period * (before + after) / 2
    return float(max(np.abs(first).max(), np.abs(turned).max(), np.abs(last).max()))
