"""The first point of a curve that is a link's length away: bracketed by sphere tracing (Hart 1996), then halved."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.following.follower import Array
from hognose.kernels import kernel
from hognose.path import Path
from hognose.path.polynomial import evaluate, segment_at

#: How far (m) beyond its end the path may be used, to let rounding put the tip on the target.
OVERRUN = 1e-9
#: A crossing within this many link lengths of arc is the first one where the arc turns by at most a right angle.
REACH = 3.2
#: Smallest stride (m) of the search for the first crossing.
_STRIDE = 1e-6


@kernel(fastmath={"contract"})
def lacking(
    breaks: NDArray, coefficients: NDArray, segment: int, u: float, x: float, y: float, z: float, length: float
) -> float:
    """What the distance (m) from (x, y, z) to the curve at u, which is on the segment, lacks of the length."""
    px, py, pz, _, _, _, _, _, _ = evaluate(coefficients, segment, u - breaks[segment])
    return length - math.sqrt((px - x) ** 2 + (py - y) ** 2 + (pz - z) ** 2)


@kernel(fastmath={"contract"})
def bracketed(
    breaks: NDArray,
    coefficients: NDArray,
    fastest: NDArray,
    start: float,
    x: float,
    y: float,
    z: float,
    length: float,
    evaluations: NDArray,
) -> tuple[float, float]:
    """A bracket of the first u > start at the length from (x, y, z), or NaN.

    The distance grows at most as fast as the arc, so a stride of the missing distance cannot pass a crossing.
    Both ends are the path's end where the crossing is within rounding of it.
    """
    last = coefficients.shape[0] - 1
    segment = segment_at(breaks, start)
    u, inside = start, start
    while True:
        gap = lacking(breaks, coefficients, segment, u, x, y, z, length)
        evaluations[0] += 1
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
def halved(
    breaks: NDArray,
    coefficients: NDArray,
    low: float,
    high: float,
    width: float,
    x: float,
    y: float,
    z: float,
    length: float,
    evaluations: NDArray,
) -> float:
    """The far end of a bracket, halved until it is no wider than `width`, or no number is left in it."""
    first, last = segment_at(breaks, low), segment_at(breaks, high)
    while high - low > width:
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        segment = first if first == last else segment_at(breaks, middle)
        evaluations[0] += 1
        if lacking(breaks, coefficients, segment, middle, x, y, z, length) > 0.0:
            low, first = middle, segment
        else:
            high, last = middle, segment
    return high


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
