"""Distance of points to piecewise polynomials."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.path.polynomial import Pieces, evaluate, evaluate_at, segment_at

Array = NDArray[np.float64]


def distances(breaks: Array, coefficients: Array, samples: Array, places: Array, points: Array) -> Array:
    """Distance (q,) m of points (q, 3) m to the curve, searched among samples (k,) with their places (k, 3) m."""
    out = np.empty(len(points))
    _distances((breaks, coefficients), samples, places, points, out)
    return out


@kernel()
def _away(places: NDArray, k: int, x: float, y: float, z: float) -> float:
    return math.sqrt((places[k, 0] - x) ** 2 + (places[k, 1] - y) ** 2 + (places[k, 2] - z) ** 2)


@kernel()
def _refined(pieces: Pieces, low: float, u: float, high: float, x: float, y: float, z: float) -> float:
    """The smallest distance between two parameters: Newton's method on the slope, kept in its bracket."""
    breaks, coefficients = pieces
    smallest, close = math.inf, False
    for _ in range(60):
        px, py, pz, vx, vy, vz, ax, ay, az = evaluate_at(breaks, coefficients, u)
        px, py, pz = px - x, py - y, pz - z
        smallest = min(smallest, math.sqrt(px * px + py * py + pz * pz))
        if close:
            break
        slope = px * vx + py * vy + pz * vz
        bend = vx * vx + vy * vy + vz * vz + 2.0 * (px * ax + py * ay + pz * az)
        if slope > 0.0:
            high = u
        else:
            low = u
        guess = u - slope / bend if bend > 0.0 else 0.5 * (low + high)
        newton = bend > 0.0 and low <= guess <= high
        if not newton:  # as where the minimum is at an end of the bracket
            guess = 0.5 * (low + high)
        if guess == u:
            break
        # The step after one this small changes nothing: Newton's method squares what is missing. Halving does not.
        close = newton and abs(guess - u) <= 1e-9 * (1.0 + abs(u))
        u = guess
    return smallest


@kernel()
def _downhill(pieces: Pieces, u: float, x: float, y: float, z: float) -> int:
    """To which side of a parameter the curve comes closer: 1 beyond it, -1 before it, 0 if it may do so on both."""
    breaks, coefficients = pieces
    segment = segment_at(breaks, u)
    if not breaks[segment] < u < breaks[segment + 1]:
        return 0
    px, py, pz, vx, vy, vz, _, _, _ = evaluate(coefficients, segment, u - breaks[segment])
    slope = (px - x) * vx + (py - y) * vy + (pz - z) * vz
    return 1 if slope < 0.0 else -1 if slope > 0.0 else 0


@kernel()
def _distances(pieces: Pieces, samples: NDArray, places: NDArray, points: NDArray, out: NDArray) -> None:
    """Distance of each point to the curve: around every sample that may be next to the minimum, it is refined."""
    last = samples.size - 1
    stride = 0.0
    for k in range(last):
        stride = max(stride, _away(places, k, places[k + 1, 0], places[k + 1, 1], places[k + 1, 2]))
    nearest = 0
    for q in range(points.shape[0]):
        x, y, z = points[q, 0], points[q, 1], points[q, 2]
        # Neighbours in the list are mostly neighbours in space: the last answer is a good first bound.
        best = _away(places, nearest, x, y, z)
        k = 0
        while k <= last:
            here = _away(places, k, x, y, z)
            if here <= best + stride:
                before, after = max(k - 1, 0), min(k + 1, last)
                if here <= _away(places, before, x, y, z) and here <= _away(places, after, x, y, z):
                    # On both sides of a sample, which may be a kink, lies at most one minimum.
                    left, here_u, right = samples[before], samples[k], samples[after]
                    downhill, found = _downhill(pieces, here_u, x, y, z), math.inf
                    if downhill <= 0:
                        found = _refined(pieces, left, 0.5 * (left + here_u), here_u, x, y, z)
                    if downhill >= 0:
                        found = min(found, _refined(pieces, here_u, here_u, right, x, y, z))
                    if found < best:
                        best, nearest = found, k
            # Samples are at most a stride apart: those jumped over are more than a stride farther than the best.
            k += max(1, int((here - best) / stride) - 1)
        out[q] = best
