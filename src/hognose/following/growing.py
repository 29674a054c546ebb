"""Following with sections of any kinds on a curve that grows at its end, as where an arm is steered.

A `Follower` needs a whole path, of whose length and curvature it makes tables first. Here a pose is found on the pieces
of a curve as they are, for a place of the tip: the feed is found that puts the tip there, by the secant method.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InfeasibleError
from hognose.following.arc import arcs_advanced
from hognose.following.crossing import Traced
from hognose.following.recall import blank_memory
from hognose.following.sections import SectionFollower, arm_of, sections_advanced
from hognose.robot.sections import MixedSections

Array = NDArray[np.float64]

#: A tip so close (m) to its place is there, far above the rounding of places and far below what anything measures.
_THERE = 1e-11
#: The secant method needs some four rounds: where it takes more, sections cannot follow.
_MOST_ROUNDS = 25


class GrowingSections:
    """Places sections on a curve that begins with a straight run, on which the base stays.

    Parameters
    ----------
    model
        The sections.
    link_lengths : (n,) m
        Their own.
    method
        One that `grows`, of `hognose.following.OF_SECTIONS`.
    axes : (3, 3)
        Of the base, in columns.
    speed
        No piece of the curve goes faster than this by its parameter.
    """

    def __init__(
        self, model: MixedSections, link_lengths: Array, method: type[SectionFollower], axes: Array, speed: float
    ) -> None:
        self._arm = arm_of(model, link_lengths, method.aim)
        self._lengths, self._axes, self._speed = link_lengths, np.ascontiguousarray(axes.T[None]), speed
        self._advance = arcs_advanced if self._arm[-1].all() else sections_advanced
        sections = link_lengths.size
        self._parameters = np.empty((1, sections + 1))
        self._memory = np.stack([blank_memory(sections)] * 3), np.zeros(sections, np.int64), self._parameters
        self._evaluations = np.zeros(1, np.int64)

    def reach(self, breaks: Array, coefficients: Array, feed: float) -> tuple[float, Array]:
        """The feed (m) at which the tip is at the end of a curve, from a guess of it, and joints (n+1, 3) m there.

        Parameters
        ----------
        breaks, coefficients : (S+1,), (S, k+1, 3)
            Of the curve, whose parameter is its arc length but for rounding of the feed; see `hognose.Path`.
        feed : m
            A guess that is off by less than the last section is long.

        Raises
        ------
        InfeasibleError
            A section that does not reach the curve.
        """
        curve, end = self._with_end(breaks, coefficients), float(breaks[-1])
        before, last = feed, 0.0
        for rounds in range(_MOST_ROUNDS):
            joints, off = self._posed(curve, feed, end)
            if abs(off) <= _THERE:
                return feed, joints
            slope = (off - last) / (feed - before) if rounds and feed != before else 1.0
            # The tip goes about as far as the feed: what is far from that is no slope to go by.
            before, last, feed = feed, off, max(feed - off / (slope if 0.2 < slope < 5.0 else 1.0), 0.0)
        raise InfeasibleError("no feed brings the tip to the end of the path")

    def _posed(self, curve: Traced, feed: float, end: float) -> tuple[Array, float]:
        """Joints (n+1, 3) m at a feed (m), and how far the tip is beyond a parameter of the curve."""
        joints = np.empty((1, self._lengths.size + 1, 3))
        feeds = np.array([feed])
        failed = self._advance(curve, self._arm, True, curve[0][0] + feeds, self._axes, feeds, self._memory, joints)
        if failed[0] >= 0:
            raise InfeasibleError(f"section {failed[1] + 1} does not reach the path from where the one before it ends")
        return joints[0], float(self._parameters[0, -1]) - end

    def _with_end(self, breaks: Array, coefficients: Array) -> Traced:
        """The curve with a straight end on which the tip may be while the feed is sought, and of which aims are taken.

        As long as the longest section: an aim looks half a section ahead.
        """
        length = float(self._lengths.max())
        way, last = np.zeros((1, *coefficients.shape[1:])), breaks[-1] - breaks[-2]
        powers = np.arange(coefficients.shape[1])
        way[0, 0] = (coefficients[-1] * last ** powers[:, None]).sum(axis=0)
        slope = (coefficients[-1, 1:] * (powers[1:] * last ** powers[:-1])[:, None]).sum(axis=0)
        way[0, 1] = slope / np.linalg.norm(slope)
        longer = np.append(breaks, breaks[-1] + length)
        return longer, np.concatenate([coefficients, way]), np.full(len(breaks), self._speed), self._evaluations
