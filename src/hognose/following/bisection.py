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

from numpy.typing import NDArray

from hognose.following.crossing import REACH, Sphere, Traced, bracketed, halved, lacking, traced
from hognose.following.follower import Array
from hognose.following.published import Tuned
from hognose.following.recall import blank_memory, recalled, remember
from hognose.kernels import kernel
from hognose.path.polynomial import evaluate_at, segment_at

#: Where halving stops: width (m) of the bracket.
BRACKET = 1e-14
#: Half the width (m) that a predicted bracket has at first; it grows until it holds the crossing.
_FIRST_BRACKET = 1e-7


@kernel(fastmath={"contract"})
def _predicted(curve: Traced, top_speed: float, before: float, delta: float, sphere: Sphere) -> tuple[float, float]:
    """A bracket round before + delta, or NaN if it does not certainly hold the first crossing only."""
    breaks, width = curve[0], _FIRST_BRACKET
    while width < sphere.radius:
        low, high = before + delta - width, before + delta + width
        if low <= before or high > breaks[-1] or (high - before) * top_speed > REACH * sphere.radius:
            break
        short = lacking(curve, segment_at(breaks, low), low, sphere)
        beyond = lacking(curve, segment_at(breaks, high), high, sphere)
        if short > 0.0 and beyond <= 0.0:
            return low, high
        width *= 8.0
    return math.nan, math.nan


@kernel(fastmath={"contract"})
def _advance(
    curve: Traced, lengths: NDArray, warm: bool, bases: NDArray, feeds: NDArray, memory: NDArray, joints: NDArray
) -> tuple[int, int]:
    """Place the joints for every feed; `memory` as `recalled` takes it."""
    breaks, coefficients, top_speed = curve[0], curve[1], curve[2].max()
    for t in range(feeds.size):
        remembers, change, per_feed = recalled(memory, feeds[t], warm)
        before = bases[t]
        x, y, z, _, _, _, _, _, _ = evaluate_at(breaks, coefficients, before)
        joints[t, 0, 0], joints[t, 0, 1], joints[t, 0, 2] = x, y, z
        for i in range(lengths.size):
            sphere, low, high = Sphere(x, y, z, lengths[i]), math.nan, math.nan
            if remembers:
                low, high = _predicted(curve, top_speed, before, memory[0, i] + memory[1, i] * change, sphere)
            if math.isnan(low):
                low, high = bracketed(curve, before, sphere)
                if math.isnan(low):
                    memory[0, lengths.size] = math.nan
                    return t, i
            u = halved(curve, low, high, BRACKET, sphere)
            remember(memory, i, u - before, per_feed)
            before = u
            x, y, z, _, _, _, _, _, _ = evaluate_at(breaks, coefficients, u)
            joints[t, i + 1, 0], joints[t, i + 1, 1], joints[t, i + 1, 2] = x, y, z
        memory[0, lengths.size] = feeds[t]
    return -1, -1


class Bisection(Tuned):
    """Bisection: the first crossing on the curve bracketed, then halved down to 1e-14 m.

    Parameters
    ----------
    path, link_lengths, spacing, bend_limits
        As in `Follower`; the last two are not used.
    as_published
        Bracket every link anew from its joint on, without what the last steps predict.
    """

    name = "bisection"

    def _prepare(self) -> None:
        self._traced = traced(self.path, self._evaluations)
        self._warm = self.tracks and not self.as_published
        self._memory = blank_memory(self.link_lengths.size)

    @property
    def tolerance(self) -> float:
        """The last bracket, and rounding."""
        return 1e-12

    def _advance(self, feeds: Array, joints: Array) -> tuple[int, int]:
        bases = self.path.parameter(feeds)
        return _advance(self._traced, self.link_lengths, self._warm, bases, feeds, self._memory, joints)
