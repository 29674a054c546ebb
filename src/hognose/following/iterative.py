"""Iterative search (paper ref. 32, Wang et al. 2018): step through the points until the distance reaches the link.

From each joint's point on, the index rises until the distance reaches the link length; of the last two points the
closer one is taken. One thing goes beyond the published search and does not change its answer: the index jumps by the
missing distance, which cannot pass a crossing, because chords are no longer than arcs. The idea starts every link
anew, so nothing of the last step is used.

Cost a step: a few distances a link here; L / sd a link as published. Known weakness: joints snap to points, as in
prediction lookup. As published the time grows with the number of points and the length of the links.
"""

from __future__ import annotations

from numpy.typing import NDArray

from hognose.following.crossing import Sphere
from hognose.following.follower import Array
from hognose.following.lookup import Lookup, lookup_points, point_lacking
from hognose.following.published import Tuned
from hognose.kernels import kernel


@kernel()
def _stepped(lookup: Lookup, start: int, sphere: Sphere) -> int:
    """The first index beyond the start that is not inside the sphere, point by point; the last index if none is."""
    points, _, evaluations = lookup
    wanted = sphere.radius * sphere.radius
    for index in range(start + 1, points.shape[0]):
        dx, dy, dz = points[index, 0] - sphere.x, points[index, 1] - sphere.y, points[index, 2] - sphere.z
        if dx * dx + dy * dy + dz * dz >= wanted:
            evaluations[0] += index - start
            return index
    evaluations[0] += points.shape[0] - 1 - start
    return points.shape[0] - 1


@kernel()
def _jumped(lookup: Lookup, start: int, sphere: Sphere) -> int:
    """The same in jumps of the missing distance. A jump that crosses the length spans one point only."""
    points, spacing, evaluations = lookup
    index, gap = start, sphere.radius
    while gap > 0.0 and index < points.shape[0] - 1:
        index = min(index + max(1, int(gap / spacing)), points.shape[0] - 1)
        gap = point_lacking(points, index, sphere)
        evaluations[0] += 1
    return index


@kernel()
def _advance(lookup: Lookup, lengths: NDArray, single: bool, feeds: NDArray, joints: NDArray) -> tuple[int, int]:
    """Place the joints for every feed; `single` goes point by point."""
    points, spacing, _ = lookup
    last = points.shape[0] - 1
    for t in range(feeds.size):
        index = min(int(feeds[t] / spacing + 0.5), last)
        x, y, z = points[index, 0], points[index, 1], points[index, 2]
        joints[t, 0, 0], joints[t, 0, 1], joints[t, 0, 2] = x, y, z
        for i in range(lengths.size):
            sphere = Sphere(x, y, z, lengths[i])
            index = _stepped(lookup, index, sphere) if single else _jumped(lookup, index, sphere)
            gap = point_lacking(points, index, sphere)
            if gap > 1e-9:
                return t, i
            if point_lacking(points, index - 1, sphere) < -gap:
                index -= 1
            x, y, z = points[index, 0], points[index, 1], points[index, 2]
            joints[t, i + 1, 0], joints[t, i + 1, 1], joints[t, i + 1, 2] = x, y, z
    return -1, -1


class Iterative(Tuned):
    """Iterative search: the first point of the path that is a link away, or the one before if it is closer.

    Parameters
    ----------
    path, link_lengths, spacing, bend_limits
        As in `Follower`; the limits are not used.
    as_published
        Go point by point, as ref. 32 does, instead of in jumps.
    """

    name = "iterative"

    def _prepare(self) -> None:
        points = lookup_points(self.path, self.spacing, self.link_lengths.size + 1)
        self._lookup: Lookup = points, self.spacing, self._evaluations

    @property
    def tolerance(self) -> float:
        """Half a point."""
        return 0.5 * self.spacing * (1 + 1e-9)

    def _advance(self, feeds: Array, joints: Array) -> tuple[int, int]:
        return _advance(self._lookup, self.link_lengths, self.as_published, feeds, joints)
