"""Marching along the path: from each joint onwards, by the distance that is missing to the link length.

The distance to a point of the path is at most the arc to it. So a stride of the missing distance never passes the first
point at the link length, and the strides converge to it, whatever the path. The method needs only points of the path,
and treats all steps of a motion at once.

Cost per step: O(n), four to eight distances per link. Known weakness: slow where the path runs at right angles to the
link, where the distance hardly grows. Source: sphere tracing, after Hart (1996), on the arc length of a curve.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.following import Follower

#: What a link may lack of its length (m), and the marches after which it is given up.
CLOSE, MARCHES = 1e-11, 100_000


class Marching(Follower):
    """Marching along the path by the distance that is missing to the link length."""

    name = "marching"

    @property
    def tolerance(self) -> float:
        """Where marching ends."""
        return 2 * CLOSE

    def _advance(self, feeds: NDArray[np.float64], joints: NDArray[np.float64]) -> tuple[int, int]:
        joints[:, 0] = self.path.point(feeds)
        arcs, failed = feeds.copy(), (-1, -1)
        for link, length in enumerate(self.link_lengths):
            arcs = arcs + length
            joint = self._march(arcs, joints[: len(arcs), link], length)
            lost = np.flatnonzero(~np.isfinite(arcs))
            if lost.size:  # of the steps before, each may still fail at a later link
                failed = int(lost[0]), link
                arcs, joint = arcs[: lost[0]], joint[: lost[0]]
            joints[: len(arcs), link + 1] = joint
        return failed

    def _march(self, arcs: NDArray[np.float64], joints: NDArray[np.float64], length: float) -> NDArray[np.float64]:
        """Move arcs (T,) on to where the path is at the length from joints (T, 3); the points (T, 3) there.

        What finds no such place becomes NaN.
        """
        points = np.full_like(joints, np.nan)
        under_way = np.arange(len(arcs))
        for _ in range(MARCHES):
            arcs[arcs > self.path.length + CLOSE] = np.nan
            np.minimum(arcs, self.path.length, out=arcs)
            under_way = under_way[np.isfinite(arcs[under_way])]
            points[under_way] = self.path.point(arcs[under_way])
            self._evaluations += len(under_way)
            lacking = length - np.linalg.norm(points[under_way] - joints[under_way], axis=1)
            under_way, lacking = under_way[lacking > CLOSE], lacking[lacking > CLOSE]
            if not under_way.size:
                return points
            arcs[under_way] += lacking
        arcs[under_way] = np.nan
        return points
