"""Distance of points to piecewise polynomials."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]


def distances(breaks: Array, coefficients: Array, samples: Array, places: Array, points: Array) -> Array:
    """Distance (q,) m of points (q, 3) m to the curve, searched among samples (k,) with their places (k, 3) m."""
    out = np.empty(len(points))
    _distances(breaks, coefficients, samples, places, points, out)
    return out


@njit(cache=True, nogil=True)
def _distances(
    breaks: NDArray, coefficients: NDArray, samples: NDArray, places: NDArray, points: NDArray, out: NDArray
) -> None:
    """Distance of each point to the curve: the closest sample, then Newton's method between its neighbours."""
    last = samples.size - 1
    stride = 0.0
    for k in range(last):
        gap = 0.0
        for axis in range(3):
            gap += (places[k + 1, axis] - places[k, axis]) ** 2
        stride = max(stride, math.sqrt(gap))
    nearest = 0
    for q in range(points.shape[0]):
        # Neighbours in the list are mostly neighbours in space: the last answer is a good first bound.
        best, k = 0.0, 0
        for axis in range(3):
            best += (places[nearest, axis] - points[q, axis]) ** 2
        best = math.sqrt(best)
        while k <= last:
            squared = 0.0
            for axis in range(3):
                squared += (places[k, axis] - points[q, axis]) ** 2
            here = math.sqrt(squared)
            if here < best:
                best, nearest = here, k
            # Samples are at most a stride apart, so none before this one can be closer than the best.
            k += max(1, int((here - best) / stride))
        low, high = samples[max(nearest - 1, 0)], samples[min(nearest + 1, last)]
        u = samples[nearest]
        out[q] = best
        for _ in range(30):
            segment = min(max(np.searchsorted(breaks, u, side="right") - 1, 0), coefficients.shape[0] - 1)
            h = u - breaks[segment]
            squared, slope, bend = 0.0, 0.0, 0.0
            for axis in range(3):
                value, first, second = 0.0, 0.0, 0.0
                for j in range(coefficients.shape[1] - 1, -1, -1):
                    second = second * h + 2.0 * first
                    first = first * h + value
                    value = value * h + coefficients[segment, j, axis]
                away = value - points[q, axis]
                squared += away * away
                slope += away * first
                bend += first * first + away * second
            out[q] = min(out[q], math.sqrt(squared))
            if slope > 0.0:
                high = u
            else:
                low = u
            guess = u - slope / bend if bend > 0.0 else 0.5 * (low + high)
            if not low <= guess <= high:
                guess = 0.5 * (low + high)
            if abs(guess - u) <= 1e-16 * (1.0 + abs(u)):
                break
            u = guess
