"""Prediction lookup (paper section 3.2, eqs. 4–10, figure 4): joints among equal-distance points of the path.

The index of each joint is predicted from the last moment, In(i, t+1) + ΔIn(i, t), and walked to the neighbour
whose distance is closest to the link length. Two things go beyond the paper. A prediction that is off by
several points is corrected in one jump by its missing distance, so the time does not grow as the spacing
shrinks. And neighbours are looked at only where one of them can be closer, on the side of the missing distance.

Cost a step: O(n), mostly one distance a link. Known weakness: joints snap to points, so links are off by up to half a
spacing and the tip by the sum of that (interpolation removes it).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.following.follower import Array, Follower
from hognose.kernels import kernel
from hognose.path import Path


@kernel()
def _first_crossing(
    points: NDArray,
    spacing: float,
    start: int,
    x: float,
    y: float,
    z: float,
    length: float,
    evaluations: NDArray,
) -> int:
    """The last index before the first crossing of the length, or -1.

    Chords are no longer than arcs, so a jump of the missing distance cannot pass a crossing.
    """
    index = start
    while True:
        jump = index + 1
        while True:
            if jump >= points.shape[0]:
                return -1
            evaluations[0] += 1
            gap = length - math.sqrt(
                (points[jump, 0] - x) ** 2 + (points[jump, 1] - y) ** 2 + (points[jump, 2] - z) ** 2
            )
            if gap <= 0.0:
                return index
            index = jump
            jump = index + max(1, int(gap / spacing))


@kernel()
def _walk(
    points: NDArray,
    spacing: float,
    base: int,
    found: int,
    missing: float,
    x: float,
    y: float,
    z: float,
    length: float,
    evaluations: NDArray,
) -> tuple[int, float]:
    """Eqs. 9–10: one jump of the missing distance, then single points while |missing| falls; index -1 at the end."""
    last = points.shape[0] - 1
    if abs(missing) > 1.5 * spacing:
        found = min(max(found + round(missing / spacing), base + 1), last)
        evaluations[0] += 1
        dx, dy, dz = points[found, 0] - x, points[found, 1] - y, points[found, 2] - z
        missing = length - math.sqrt(dx * dx + dy * dy + dz * dz)
    while True:
        beside = found + (1 if missing > 0.0 else -1)
        if beside > last:
            return (found, missing) if missing <= 1e-9 else (-1, missing)
        if beside <= base:
            return found, missing
        dx, dy, dz = points[beside, 0] - x, points[beside, 1] - y, points[beside, 2] - z
        evaluations[0] += 1
        other = length - math.sqrt(dx * dx + dy * dy + dz * dz)
        if abs(other) >= abs(missing):
            return found, missing
        found, missing = beside, other


@kernel()
def _advance(
    points: NDArray,
    spacing: float,
    lengths: NDArray,
    tracks: bool,
    interpolates: bool,
    sure: float,
    end: float,
    feeds: NDArray,
    delta: NDArray,
    evaluations: NDArray,
    joints: NDArray,
) -> tuple[int, int]:
    """Place the joints for every feed; `delta` holds ΔIn of each link (eq. 5), below 0 before the first step.

    A point that misses the length by no more than `sure` is the closest one: the distance changes by at least
    2 `sure` and at most a spacing from point to point. For the same reason its neighbour is the closest one if it
    misses by more than half a spacing and less than 3 `sure`. No interpolated joint may lie behind index `end`.
    """
    last = points.shape[0] - 1
    for t in range(feeds.size):
        position = feeds[t] / spacing
        index = min(int(position), last - 1) if interpolates else min(int(position + 0.5), last)
        x, y, z = points[index, 0], points[index, 1], points[index, 2]
        if interpolates:
            part = position - index
            x += part * (points[index + 1, 0] - x)
            y += part * (points[index + 1, 1] - y)
            z += part * (points[index + 1, 2] - z)
        joints[t, 0, 0], joints[t, 0, 1], joints[t, 0, 2] = x, y, z
        for i in range(lengths.size):
            length = lengths[i]
            found = -1
            if tracks and delta[i] > 0:
                found = min(index + delta[i], last)
            else:
                found = _first_crossing(points, spacing, index, x, y, z, length, evaluations)
                if found < 0:
                    delta[i:] = -1
                    return t, i
            dx, dy, dz = points[found, 0] - x, points[found, 1] - y, points[found, 2] - z
            missing = length - math.sqrt(dx * dx + dy * dy + dz * dz)
            evaluations[0] += 1
            if abs(missing) > sure:
                if 0.5 * spacing < abs(missing) < 3.0 * sure and not interpolates and index + 1 < found < last:
                    found += 1 if missing > 0.0 else -1
                else:
                    found, missing = _walk(points, spacing, index, found, missing, x, y, z, length, evaluations)
                    if found < 0:
                        delta[i:] = -1
                        return t, i
            if interpolates:
                found -= missing < 0.0
                near, far = missing, 0.0
                before_x, before_y, before_z = points[found, 0], points[found, 1], points[found, 2]
                beside = min(found + 1, last)
                evaluations[0] += 1
                if missing < 0.0:
                    dx, dy, dz = before_x - x, before_y - y, before_z - z
                    near, far = length - math.sqrt(dx * dx + dy * dy + dz * dz), missing
                else:
                    dx, dy, dz = points[beside, 0] - x, points[beside, 1] - y, points[beside, 2] - z
                    far = length - math.sqrt(dx * dx + dy * dy + dz * dz)
                part = near / (near - far) if near > far else 0.0
                if found + part > end:
                    delta[i:] = -1
                    return t, i
                x = before_x + part * (points[beside, 0] - before_x)
                y = before_y + part * (points[beside, 1] - before_y)
                z = before_z + part * (points[beside, 2] - before_z)
            else:
                x, y, z = points[found, 0], points[found, 1], points[found, 2]
            delta[i] = found - index
            index = found
            joints[t, i + 1, 0], joints[t, i + 1, 1], joints[t, i + 1, 2] = x, y, z
    return -1, -1


class Prediction(Follower):
    """Prediction lookup: each joint on the point whose distance is closest to the link length."""

    name = "prediction"
    _interpolates = False

    def __init__(
        self, path: Path, link_lengths: ArrayLike, spacing: float = 0.0005, bend_limits: ArrayLike | None = None
    ) -> None:
        super().__init__(path, link_lengths, spacing, bend_limits)
        self._points = lookup_points(path, spacing, self.link_lengths.size + 1)
        # Neighbours differ in distance by spacing x cos(tangent, chord), whose angle is at most asin(κL/2).
        steepest = min(1.0, path.sharpest[0] * float(self.link_lengths.max()) / 2)
        self._sure = 0.49 * spacing * math.sqrt(1.0 - steepest**2) if self.tracks else 0.0
        # Interpolated joints drift off exact ones by no more than the method's tolerance a link.
        slack = self.link_lengths.size * self.tolerance
        self._end = (path.length + slack) / spacing
        self._delta = np.full(self.link_lengths.size, -1, np.int64)

    @property
    def tolerance(self) -> float:
        """Half a point."""
        return 0.5 * self.spacing * (1 + 1e-9)

    def _advance(self, feeds: Array, joints: Array) -> tuple[int, int]:
        return _advance(
            self._points,
            self.spacing,
            self.link_lengths,
            self.tracks,
            self._interpolates,
            self._sure,
            self._end,
            feeds,
            self._delta,
            self._evaluations,
            joints,
        )


def lookup_points(path: Path, spacing: float, beyond: int = 0) -> Array:
    """The points M(In) (N, 3) m of a path, and `beyond` more on its last tangent.

    Snapped joints drift by up to half a point a link, so at the end of the path the tip needs points behind it.
    """
    points = path.equal_distance_points(spacing)
    rest = path.length - spacing * (len(points) - 1)
    distances = spacing * np.arange(1, beyond + 1) - rest
    return np.concatenate([points, path.point(path.length) + distances[:, None] * path.tangent(path.length)])
