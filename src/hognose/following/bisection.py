"""Bisection on the continuous curve (paper ref. 31, Andersson 2008).

The first place where the distance from the last joint reaches the link length is bracketed, then the bracket is
halved until it is narrower than a tolerance. Published, the bracket is found by walking along the curve in steps of
half a link; where distances swing within such a step a crossing can be missed, so the walk here strides by the missing
distance, which cannot pass one. Tuned, the bracket is laid round the last step's arc instead.

Cost a step: O(n log(bracket / tolerance)) evaluations of the curve: about 42 a link from half a link down to
the tolerance, fewer from a predicted bracket. Known weakness: linear convergence, so it costs several times what
Newton's method does and is less exact; cold, its time depends on how it brackets.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from hognose.following.exact import fastest_on_segments
from hognose.following.follower import Array, Follower
from hognose.path import Path

#: Where halving stops: width (m) of the bracket.
BRACKET = 1e-14
#: Half the width (m) that a predicted bracket has at first; it doubles until it holds the crossing.
_FIRST_BRACKET = 1e-6
#: A crossing within this many link lengths of arc is the first one where the arc turns by at most a right angle.
_REACH = 3.2
#: Smallest stride (m) of the walk.
_STRIDE = 1e-6


@njit(cache=True, nogil=True)
def _place(breaks: NDArray, coefficients: NDArray, u: float, out: NDArray) -> None:
    """The curve's point (3,) at a parameter."""
    segment = min(max(int(np.searchsorted(breaks, u, side="right")) - 1, 0), coefficients.shape[0] - 1)
    h = u - breaks[segment]
    for axis in range(3):
        value = 0.0
        for j in range(coefficients.shape[1] - 1, -1, -1):
            value = value * h + coefficients[segment, j, axis]
        out[axis] = value


@njit(cache=True, nogil=True)
def _short_of(
    breaks: NDArray, coefficients: NDArray, u: float, length: float, center: NDArray, point: NDArray
) -> float:
    """What the distance (m) from the centre to the curve at u lacks of the length."""
    _place(breaks, coefficients, u, point)
    return length - math.sqrt((point[0] - center[0]) ** 2 + (point[1] - center[1]) ** 2 + (point[2] - center[2]) ** 2)


@njit(cache=True, nogil=True)
def _walk(
    breaks: NDArray,
    coefficients: NDArray,
    fastest: NDArray,
    start: float,
    length: float,
    center: NDArray,
    point: NDArray,
) -> tuple[float, float]:
    """A bracket of the first crossing beyond `start`; NaN if the path ends before."""
    end = breaks[-1]
    inside, u, gap = start, start, length
    while True:
        segment = min(max(int(np.searchsorted(breaks, u, side="right")) - 1, 0), coefficients.shape[0] - 1)
        inside = u
        u += max(gap, _STRIDE) / fastest[segment]
        if segment + 1 < coefficients.shape[0]:
            u = min(u, breaks[segment + 1])
        if u >= end:
            u = end
        gap = _short_of(breaks, coefficients, u, length, center, point)
        if gap <= 0.0 or (u >= end and gap <= 1e-9):
            return inside, u
        if u >= end:
            return math.nan, math.nan


@njit(cache=True, nogil=True)
def _advance(
    breaks: NDArray,
    coefficients: NDArray,
    fastest: NDArray,
    lengths: NDArray,
    warm: bool,
    bases: NDArray,
    memory: NDArray,
    joints: NDArray,
) -> tuple[int, int]:
    """Place the joints from the base parameters (T,); `memory` (n,) holds each link's Δu, NaN before the first step."""
    center, point = np.empty(3), np.empty(3)
    top_speed = fastest.max()
    for t in range(bases.size):
        before = bases[t]
        _place(breaks, coefficients, before, center)
        joints[t, 0] = center
        for i in range(lengths.size):
            length = lengths[i]
            low, high, found = math.nan, math.nan, False
            if warm and not math.isnan(memory[i]):
                width = _FIRST_BRACKET
                while not found and width < length:
                    low, high = before + memory[i] - width, before + memory[i] + width
                    if low <= before or high > breaks[-1] or (high - before) * top_speed > _REACH * length:
                        break
                    found = (
                        _short_of(breaks, coefficients, low, length, center, point) > 0.0
                        and _short_of(breaks, coefficients, high, length, center, point) <= 0.0
                    )
                    width *= 8.0
            if not found:
                low, high = _walk(breaks, coefficients, fastest, before, length, center, point)
                if math.isnan(low):
                    memory[:] = math.nan
                    return t, i
            while high - low > BRACKET:
                middle = 0.5 * (low + high)
                if middle <= low or middle >= high:
                    break
                if _short_of(breaks, coefficients, middle, length, center, point) > 0.0:
                    low = middle
                else:
                    high = middle
            memory[i] = high - before
            before = high
            _place(breaks, coefficients, before, center)
            joints[t, i + 1] = center
    return -1, -1


class Bisection(Follower):
    """Bisection: the first crossing on the curve bracketed, then halved down to 1e-14 m.

    Parameters
    ----------
    path : Path
    link_lengths : (n,) m
    spacing : float, m
        Not used.
    as_published
        Bracket every link anew from its joint on, without the last step's arc.
    """

    name = "bisection"

    def __init__(
        self, path: Path, link_lengths: ArrayLike, spacing: float = 0.0005, as_published: bool = False
    ) -> None:
        super().__init__(path, link_lengths, spacing)
        self._fastest = fastest_on_segments(path)
        self._warm = self.tracks and not as_published
        self._memory = np.full(self.link_lengths.size, math.nan)

    @property
    def tolerance(self) -> float:
        """The last bracket, and rounding."""
        return 1e-12

    def _advance(self, feeds: Array, joints: Array) -> tuple[int, int]:
        path = self.path
        return _advance(
            path.breaks,
            path.coefficients,
            self._fastest,
            self.link_lengths,
            self._warm,
            path.parameter(feeds),
            self._memory,
            joints,
        )
