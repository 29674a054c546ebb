"""What methods have in common that improve the posture of the last step."""

from __future__ import annotations

import abc
import itertools
import math

import numpy as np
from numpy.typing import ArrayLike

from hognose.following.chain import base_frames, laid_along
from hognose.following.follower import SOLVED, Array, Follower
from hognose.path import Path


class WarmStarted(Follower):
    """Starts from the last step's posture; after a jump of the feed, from the arm laid along the path.

    A jump is a change of more than half the shortest link: from there the last posture is no guide.
    """

    def __init__(
        self, path: Path, link_lengths: ArrayLike, spacing: float = 0.0005, bend_limits: ArrayLike | None = None
    ) -> None:
        super().__init__(path, link_lengths, spacing, bend_limits)
        self._feed = math.nan
        #: Joints of the last step, m, and their change with the feed, zero after a jump.
        self._memory = np.zeros((2, self.link_lengths.size + 1, 3))

    @abc.abstractmethod
    def _continue(self, feeds: Array, bases: Array, frames: Array, joints: Array) -> tuple[int, int]:
        """Fill joints (T, n+1, 3) for feeds (T,) without jumps, from and into the memory; as `_advance`."""

    def _begin(self, feed: float) -> None:
        self._memory[0] = laid_along(self.path, self.link_lengths, feed)
        self._memory[1] = 0.0
        self._feed = feed

    def _advance(self, feeds: Array, joints: Array) -> tuple[int, int]:
        if not feeds.size:
            return SOLVED
        bases, frames = self.path.point(feeds), base_frames(self.path, feeds)
        jump = 0.5 * float(self.link_lengths.min())
        before = np.append(self._feed, feeds[:-1])
        starts = np.flatnonzero(~(np.abs(feeds - before) <= jump))
        edges = np.unique(np.concatenate([[0], starts, [feeds.size]]))
        for start, end in itertools.pairwise(edges):
            if start in starts:
                self._begin(float(feeds[start]))
            part = slice(start, end)
            step, link = self._continue(feeds[part], bases[part], frames[part], joints[part])
            if step >= 0:
                self._feed = math.nan
                return int(start) + step, link
            self._feed = float(feeds[end - 1])
        return SOLVED
