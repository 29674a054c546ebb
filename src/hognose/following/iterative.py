"""Iterative search (paper ref. 32, Wang et al. 2018): step through the points until the distance reaches the link.

From each joint's point on, the index rises until the distance reaches the link length; of the last two points the
closer one is taken. One thing goes beyond the published search and does not change its answer: the index jumps by the
missing distance, which cannot pass a crossing, because chords are no longer than arcs. The idea starts every link
anew, so nothing of the last step is used.

Cost a step: a few distances a link here; L / sd a link as published. Known weakness: joints snap to points, as in
prediction lookup. As published the time grows with the number of points and the length of the links.
"""

from __future__ import annotations

import math

from numpy.typing import ArrayLike, NDArray

from hognose.following.follower import Array, Follower
from hognose.following.prediction import lookup_points
from hognose.kernels import kernel
from hognose.path import Path


@kernel()
def _lacking(points: NDArray, index: int, x: float, y: float, z: float, length: float) -> float:
    dx, dy, dz = points[index, 0] - x, points[index, 1] - y, points[index, 2] - z
    return length - math.sqrt(dx * dx + dy * dy + dz * dz)


@kernel()
def _stepped(points: NDArray, start: int, x: float, y: float, z: float, length: float, evaluations: NDArray) -> int:
    """The first index beyond the start that is the length away, point by point; the last index if none is."""
    wanted = length * length
    for index in range(start + 1, points.shape[0]):
        dx, dy, dz = points[index, 0] - x, points[index, 1] - y, points[index, 2] - z
        if dx * dx + dy * dy + dz * dz >= wanted:
            evaluations[0] += index - start
            return index
    evaluations[0] += points.shape[0] - 1 - start
    return points.shape[0] - 1


@kernel()
def _jumped(
    points: NDArray,
    spacing: float,
    start: int,
    x: float,
    y: float,
    z: float,
    length: float,
    evaluations: NDArray,
) -> int:
    """The same in jumps of the missing distance. A jump that crosses the length spans one point only."""
    index, gap = start, length
    while gap > 0.0 and index < points.shape[0] - 1:
        index = min(index + max(1, int(gap / spacing)), points.shape[0] - 1)
        gap = _lacking(points, index, x, y, z, length)
        evaluations[0] += 1
    return index


@kernel()
def _advance(
    points: NDArray,
    spacing: float,
    lengths: NDArray,
    single: bool,
    feeds: NDArray,
    evaluations: NDArray,
    joints: NDArray,
) -> tuple[int, int]:
    """Place the joints for every feed; `single` goes point by point."""
    last = points.shape[0] - 1
    for t in range(feeds.size):
        index = min(int(feeds[t] / spacing + 0.5), last)
        x, y, z = points[index, 0], points[index, 1], points[index, 2]
        joints[t, 0, 0], joints[t, 0, 1], joints[t, 0, 2] = x, y, z
        for i in range(lengths.size):
            length = lengths[i]
            if single:
                index = _stepped(points, index, x, y, z, length, evaluations)
            else:
                index = _jumped(points, spacing, index, x, y, z, length, evaluations)
            gap = _lacking(points, index, x, y, z, length)
            if gap > 1e-9:
                return t, i
            if _lacking(points, index - 1, x, y, z, length) < -gap:
                index -= 1
            x, y, z = points[index, 0], points[index, 1], points[index, 2]
            joints[t, i + 1, 0], joints[t, i + 1, 1], joints[t, i + 1, 2] = x, y, z
    return -1, -1


class Iterative(Follower):
    """Iterative search: the first point of the path that is a link away, or the one before if it is closer.

    Parameters
    ----------
    path : Path
    link_lengths : (n,) m
    spacing : float, m
        Distance sd of the points M(In).
    bend_limits : rad
        Not used.
    as_published
        Go point by point, as ref. 32 does, instead of in jumps.
    """

    name = "iterative"

    def __init__(
        self,
        path: Path,
        link_lengths: ArrayLike,
        spacing: float = 0.0005,
        bend_limits: ArrayLike | None = None,
        as_published: bool = False,
    ) -> None:
        super().__init__(path, link_lengths, spacing, bend_limits)
        self._points = lookup_points(path, spacing, self.link_lengths.size + 1)
        self._single = as_published

    @property
    def tolerance(self) -> float:
        """Half a point."""
        return 0.5 * self.spacing * (1 + 1e-9)

    def _advance(self, feeds: Array, joints: Array) -> tuple[int, int]:
        return _advance(self._points, self.spacing, self.link_lengths, self._single, feeds, self._evaluations, joints)
