"""Prediction lookup (paper section 3.2, eqs. 4–10, figure 4): joints among equal-distance points of the path.

The index of each joint is predicted from the last moment, In(i, t+1) + ΔIn(i, t), and moved to the neighbour
whose distance is closest to the link length. Two things go beyond the paper. A prediction that is off by
several points is corrected in one jump by its missing distance, so the time does not grow as the spacing
shrinks. And neighbours are looked at only where one of them can be closer, on the side of the missing distance.

Cost a step: O(n), mostly one distance a link. Known weakness: joints snap to points, so links are off by up to half a
spacing and the tip by the sum of that (interpolation removes it).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.following.crossing import Sphere
from hognose.following.follower import Array, Follower
from hognose.following.lookup import Lookup, lookup_points, point_lacking
from hognose.kernels import kernel

#: Lengths (n,) m of the links, and ΔIn (n,) of each (eq. 5), below 0 before the first step.
Arm = tuple[NDArray, NDArray]


@kernel()
def _first_crossing(lookup: Lookup, start: int, sphere: Sphere) -> int:
    """The last index before the first point that is not inside the sphere, or -1.

    Chords are no longer than arcs, so a jump of the missing distance cannot pass a crossing.
    """
    points, spacing, evaluations = lookup
    index = start
    jump = index + 1
    while jump < points.shape[0]:
        evaluations[0] += 1
        gap = point_lacking(points, jump, sphere)
        if gap <= 0.0:
            return index
        index = jump
        jump = index + max(1, int(gap / spacing))
    return -1


@kernel()
def _walk(lookup: Lookup, base: int, found: int, missing: float, sphere: Sphere) -> tuple[int, float]:
    """Eqs. 9–10: one jump of the missing distance, then single points while |missing| falls; index -1 at the end."""
    points, spacing, evaluations = lookup
    last = points.shape[0] - 1
    if abs(missing) > 1.5 * spacing:
        found = min(max(found + round(missing / spacing), base + 1), last)
        evaluations[0] += 1
        missing = point_lacking(points, found, sphere)
    while True:
        beside = found + (1 if missing > 0.0 else -1)
        if beside > last:
            return (found, missing) if missing <= 1e-9 else (-1, missing)
        if beside <= base:
            return found, missing
        evaluations[0] += 1
        other = point_lacking(points, beside, sphere)
        if abs(other) >= abs(missing):
            return found, missing
        found, missing = beside, other


@kernel()
def _advance(
    lookup: Lookup, arm: Arm, tracks: bool, interpolates: bool, sure: float, end: float, feeds: NDArray, joints: NDArray
) -> tuple[int, int]:
    """Place the joints for every feed.

    A point that misses the length by no more than `sure` is the closest one: the distance changes by at least
    2 `sure` and at most a spacing from point to point. For the same reason its neighbour is the closest one if it
    misses by more than half a spacing and less than 3 `sure`. No interpolated joint may lie behind index `end`.
    """
    points, spacing, evaluations = lookup
    lengths, delta = arm
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
            sphere = Sphere(x, y, z, lengths[i])
            found = -1
            if tracks and delta[i] > 0:
                found = min(index + delta[i], last)
            else:
                found = _first_crossing(lookup, index, sphere)
                if found < 0:
                    delta[i:] = -1
                    return t, i
            missing = point_lacking(points, found, sphere)
            evaluations[0] += 1
            if abs(missing) > sure:
                if 0.5 * spacing < abs(missing) < 3.0 * sure and not interpolates and index + 1 < found < last:
                    found += 1 if missing > 0.0 else -1
                else:
                    found, missing = _walk(lookup, index, found, missing, sphere)
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
                    near, far = point_lacking(points, found, sphere), missing
                else:
                    far = point_lacking(points, beside, sphere)
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

    def _prepare(self) -> None:
        links = self.link_lengths.size
        self._lookup: Lookup = lookup_points(self.path, self.spacing, links + 1), self.spacing, self._evaluations
        self._arm: Arm = self.link_lengths, np.full(links, -1, np.int64)
        # Neighbours differ in distance by spacing x cos(tangent, chord), whose angle is at most asin(κL/2).
        steepest = min(1.0, self.path.sharpest[0] * float(self.link_lengths.max()) / 2)
        self._sure = 0.49 * self.spacing * math.sqrt(1.0 - steepest**2) if self.tracks else 0.0
        # Interpolated joints drift off exact ones by no more than the method's tolerance a link.
        self._end = (self.path.length + links * self.tolerance) / self.spacing

    @property
    def tolerance(self) -> float:
        """Half a point."""
        return 0.5 * self.spacing * (1 + 1e-9)

    def _advance(self, feeds: Array, joints: Array) -> tuple[int, int]:
        sure, end = self._sure, self._end
        return _advance(self._lookup, self._arm, self.tracks, self._interpolates, sure, end, feeds, joints)
