"""The first point of a curve that is a link's length away: bracketed by sphere tracing (Hart 1996), then halved."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hognose.following.follower import Array
from hognose.kernels import kernel
from hognose.path import Path
from hognose.path.polynomial import evaluate, segment_at

#: A curve as kernels take it: breaks, coefficients, `fastest_on_segments`, and the count (1,) of distances measured.
#: A plain tuple, as whatever is passed from Python: numba takes 0.5 µs longer to recognise a named one.
Traced = tuple[NDArray, NDArray, NDArray, NDArray]

#: How far (m) the path may be used beyond its end, so that a tip on the target does not fail by rounding.
OVERRUN = 1e-9
#: A crossing within this many link lengths of arc is the first one where the arc turns by at most a right angle.
REACH = 3.2
#: Smallest stride (m) of the search for the first crossing.
_STRIDE = 1e-6


class Sphere(NamedTuple):
    """Where the next joint lies: round the joint before it, with the link's length as its radius; all in m."""

    x: float
    y: float
    z: float
    radius: float


# Inlined, or the references to the arrays of the curve would be counted in every call.
@kernel(fastmath={"contract"}, inline="always")
def lacking(curve: Traced, segment: int, u: float, sphere: Sphere) -> float:
    """How far (m) inside a sphere the curve is at u, which is on the segment."""
    breaks, coefficients, _, evaluations = curve
    evaluations[0] += 1
    x, y, z, _, _, _, _, _, _ = evaluate(coefficients, segment, u - breaks[segment])
    return sphere.radius - math.sqrt((x - sphere.x) ** 2 + (y - sphere.y) ** 2 + (z - sphere.z) ** 2)


@kernel(fastmath={"contract"})
def bracketed(curve: Traced, start: float, sphere: Sphere) -> tuple[float, float]:
    """A bracket of the first u > start at which the curve leaves a sphere, or NaN.

    The distance grows at most as fast as the arc, so a stride of the missing distance cannot pass a crossing.
    Both ends are the path's end where the crossing is within rounding of it.
    """
    breaks, coefficients, fastest, _ = curve
    last = coefficients.shape[0] - 1
    segment = segment_at(breaks, start)
    u, inside = start, start
    while True:
        gap = lacking(curve, segment, u, sphere)
        if gap <= 0.0:
            return inside, u
        inside = u
        if u >= breaks[last + 1]:
            return (u, u) if gap <= OVERRUN else (math.nan, math.nan)
        u += max(gap, _STRIDE) / fastest[segment]
        if u >= breaks[segment + 1]:
            u = breaks[segment + 1]
            segment = min(segment + 1, last)


@kernel(fastmath={"contract"})
def halved(curve: Traced, low: float, high: float, width: float, sphere: Sphere) -> float:
    """The far end of a bracket, halved until it is no wider than `width`, or no number is left in it."""
    breaks = curve[0]
    first, last = segment_at(breaks, low), segment_at(breaks, high)
    while high - low > width:
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        segment = first if first == last else segment_at(breaks, middle)
        if lacking(curve, segment, middle, sphere) > 0.0:
            low, first = middle, segment
        else:
            high, last = middle, segment
    return high


def traced(path: Path, evaluations: NDArray[np.int64]) -> Traced:
    """A path as kernels take it; `evaluations` (1,) is their count of distances measured."""
    return path.breaks, path.coefficients, fastest_on_segments(path), evaluations


def fastest_on_segments(path: Path) -> Array:
    """An upper bound (S,) of ‖r′(u)‖ on every segment: the largest Bernstein coefficient of r′."""
    spans = np.diff(path.breaks)
    powers = np.arange(1, path.degree + 1)
    derivative = path.coefficients[:, 1:] * (powers * spans[:, None] ** (powers - 1))[..., None]
    degree = path.degree - 1
    to_bernstein = np.array(
        [[math.comb(i, j) / math.comb(degree, j) for j in range(degree + 1)] for i in range(degree + 1)]
    )
    return np.linalg.norm(np.einsum("ij,sjx->six", to_bernstein, derivative), axis=2).max(axis=1)
