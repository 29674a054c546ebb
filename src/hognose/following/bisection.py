"""Bisection on the continuous curve (paper ref. 31, Andersson 2008).

The first place where the distance from the last joint reaches the link length is bracketed, then the bracket is
halved until it is narrower than a tolerance. Published, the bracket is found by walking along the curve in steps of
half a link; where distances swing within such a step a crossing can be missed, so the walk here strides by the missing
distance, which cannot pass one. Tuned, the bracket is laid round the arc that the last two steps predict instead.

Cost a step: O(n log(bracket / tolerance)) evaluations of the curve: about 42 a link from half a link down to the
tolerance, about 27 from a predicted bracket. Known weakness: linear convergence, so it costs many times what Newton's
method does.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.following.crossing import REACH, bracketed, fastest_on_segments, halved, lacking
from hognose.following.follower import Array, Follower
from hognose.kernels import kernel
from hognose.path import Path
from hognose.path.polynomial import evaluate, segment_at

#: Where halving stops: width (m) of the bracket.
BRACKET = 1e-14
#: Half the width (m) that a predicted bracket has at first; it grows until it holds the crossing.
_FIRST_BRACKET = 1e-7


@kernel(fastmath={"contract"})
def _predicted(
    breaks: NDArray,
    coefficients: NDArray,
    top_speed: float,
    before: float,
    delta: float,
    x: float,
    y: float,
    z: float,
    length: float,
    evaluations: NDArray,
) -> tuple[float, float]:
    """A bracket round before + delta, or NaN if it does not certainly hold the first crossing only."""
    width = _FIRST_BRACKET
    while width < length:
        low, high = before + delta - width, before + delta + width
        if low <= before or high > breaks[-1] or (high - before) * top_speed > REACH * length:
            break
        evaluations[0] += 2
        short = lacking(breaks, coefficients, segment_at(breaks, low), low, x, y, z, length)
        beyond = lacking(breaks, coefficients, segment_at(breaks, high), high, x, y, z, length)
        if short > 0.0 and beyond <= 0.0:
            return low, high
        width *= 8.0
    return math.nan, math.nan


@kernel(fastmath={"contract"})
def _advance(
    breaks: NDArray,
    coefficients: NDArray,
    fastest: NDArray,
    lengths: NDArray,
    warm: bool,
    bases: NDArray,
    feeds: NDArray,
    memory: NDArray,
    evaluations: NDArray,
    joints: NDArray,
) -> tuple[int, int]:
    """Place the joints for every feed; `memory` holds Δu, its rate, and the last feed (NaN before the first)."""
    links = lengths.size
    top_speed = fastest.max()
    for t in range(feeds.size):
        change = feeds[t] - memory[0, links]
        remembers = warm and not math.isnan(change)
        per_feed = 1.0 / change if remembers and abs(change) > 1e-9 else 0.0
        before = bases[t]
        segment = segment_at(breaks, before)
        x, y, z, _, _, _, _, _, _ = evaluate(coefficients, segment, before - breaks[segment])
        joints[t, 0, 0], joints[t, 0, 1], joints[t, 0, 2] = x, y, z
        for i in range(links):
            length, low, high = lengths[i], math.nan, math.nan
            if remembers:
                delta = memory[0, i] + memory[1, i] * change
                low, high = _predicted(breaks, coefficients, top_speed, before, delta, x, y, z, length, evaluations)
            if math.isnan(low):
                low, high = bracketed(breaks, coefficients, fastest, before, x, y, z, length, evaluations)
                if math.isnan(low):
                    memory[0, links] = math.nan
                    return t, i
            u = halved(breaks, coefficients, low, high, BRACKET, x, y, z, length, evaluations)
            memory[1, i] = (u - before - memory[0, i]) * per_feed
            memory[0, i] = u - before
            before = u
            segment = segment_at(breaks, u)
            x, y, z, _, _, _, _, _, _ = evaluate(coefficients, segment, u - breaks[segment])
            joints[t, i + 1, 0], joints[t, i + 1, 1], joints[t, i + 1, 2] = x, y, z
        memory[0, links] = feeds[t]
    return -1, -1


class Bisection(Follower):
    """Bisection: the first crossing on the curve bracketed, then halved down to 1e-14 m.

    Parameters
    ----------
    path : Path
    link_lengths : (n,) m
    spacing : float, m
        Not used.
    bend_limits : rad
        Not used.
    as_published
        Bracket every link anew from its joint on, without what the last steps predict.
    """

    name = "bisection"

    def __init__(
        self,
        path: Path,
        link_lengths: ArrayLike,
        spacing: float = 0.0005,
        bend_limits: ArrayLike | None = None,
        as_published: bool = False,
    ) -> None:
        super().__init__(path, link_lengths, spacing, bend_limits)
        self._fastest = fastest_on_segments(path)
        self._warm = self.tracks and not as_published
        self._memory = np.zeros((2, self.link_lengths.size + 1))
        self._memory[0, -1] = math.nan

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
            feeds,
            self._memory,
            self._evaluations,
            joints,
        )
