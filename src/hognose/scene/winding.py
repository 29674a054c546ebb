"""Which solid a point is in: the generalised winding number, in groups of triangles.

The winding number of a mesh round a point is the sum of its triangles' solid angles (van Oosterom & Strackee
1983) over 4 π: one inside, zero outside, little upset by missing triangles. A group of triangles far from the point
is seen as a single small plate with their common area vector (Barill et al. 2018, first order). Where that leaves
doubt about which side of one half the sum is on, all triangles are summed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_GROUP_SIZE = 64
# A group is far if the point is this many of its radii away …
_FAR = 4.0
# … which leaves a sum of winding numbers within 0.01 of the true one; this close to one half it is worked out exactly.
_DOUBT = 0.05


@dataclass(frozen=True, eq=False)
class Groups:
    """Triangles near each other, in groups; obstacle after obstacle.

    Attributes
    ----------
    order : (m,) int64
        The triangles, group after group.
    start : (g + 1,) int64
        Where in `order` each group begins.
    obstacle : (obstacles + 1,) int64
        The first group of each obstacle.
    plates : (g, 7)
        Middle, area vector (m²) and squared radius of each group; -1 if it has no area.
    """

    order: Ints
    start: Ints
    obstacle: Ints
    plates: Floats


def grouped(triangles: Floats, owner: NDArray[np.int32], nearby: NDArray[np.int32], obstacles: int) -> Groups:
    """Return triangles (m, 3, 3) in groups, given an order of all that keeps neighbours together, and their owners."""
    order = nearby[np.argsort(owner[nearby], kind="stable")].astype(np.int64)
    counts = np.bincount(owner, minlength=obstacles)
    groups = -(-counts // _GROUP_SIZE)
    first = np.append(0, np.cumsum(groups))
    within = np.arange(first[-1]) - np.repeat(first[:-1], groups)
    begins = np.append(0, np.cumsum(counts))[:-1]
    start = np.append(np.repeat(begins, groups) + _GROUP_SIZE * within, len(order))

    corners = triangles[order]
    area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    weight = np.linalg.norm(area, axis=1) + np.finfo(np.float64).tiny
    total = np.add.reduceat(weight, start[:-1])[:, None]
    middle = np.add.reduceat(weight[:, None] * corners.mean(axis=1), start[:-1]) / total
    off = corners - np.repeat(middle, np.diff(start), axis=0)[:, None]
    radius2 = np.maximum.reduceat(np.einsum("mci,mci->mc", off, off).max(axis=1), start[:-1])
    # Groups without area, of points, count for nothing: they are far from everywhere.
    radius2[total[:, 0] < _GROUP_SIZE * 2 * np.finfo(np.float64).tiny] = -1.0
    plates = np.concatenate([middle, np.add.reduceat(area, start[:-1]), radius2[:, None]], axis=1)
    return Groups(order, start, first, plates)


@kernel(error_model="numpy")
def _half_angle(triangles, k, x, y, z):
    """Return half the solid angle of triangle k seen from a point."""
    ax, ay, az = triangles[k, 0, 0] - x, triangles[k, 0, 1] - y, triangles[k, 0, 2] - z
    bx, by, bz = triangles[k, 1, 0] - x, triangles[k, 1, 1] - y, triangles[k, 1, 2] - z
    cx, cy, cz = triangles[k, 2, 0] - x, triangles[k, 2, 1] - y, triangles[k, 2, 2] - z
    a = np.sqrt(ax * ax + ay * ay + az * az)
    b = np.sqrt(bx * bx + by * by + bz * bz)
    c = np.sqrt(cx * cx + cy * cy + cz * cz)
    volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    ab, bc, ca = ax * bx + ay * by + az * bz, bx * cx + by * cy + bz * cz, cx * ax + cy * ay + cz * az
    return np.arctan2(volume, a * b * c + ab * c + bc * a + ca * b)


@kernel(error_model="numpy")
def _winding(triangles, order, start, plates, first, last, far2, x, y, z):
    """Return the winding number of groups first … last - 1 round a point; `far2` is infinite for the exact one."""
    half_angle = 0.0
    for group in range(first, last):
        rx, ry, rz = plates[group, 0] - x, plates[group, 1] - y, plates[group, 2] - z
        apart2 = rx * rx + ry * ry + rz * rz
        if apart2 > far2 * plates[group, 6]:
            facing = rx * plates[group, 3] + ry * plates[group, 4] + rz * plates[group, 5]
            half_angle += 0.5 * facing / (apart2 * np.sqrt(apart2))
            continue
        for i in range(start[group], start[group + 1]):
            half_angle += _half_angle(triangles, order[i], x, y, z)
    return half_angle / (2.0 * np.pi)


@kernel(error_model="numpy")
def enclosing(triangles, order, start, obstacle, plates, bounds, points, answer):
    """Fill, for each point, the first obstacle whose winding number round it is above one half, or -1."""
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        answer[i] = -1
        for k in range(len(obstacle) - 1):
            low, high = bounds[k, 0], bounds[k, 1]
            if x < low[0] or y < low[1] or z < low[2] or x > high[0] or y > high[1] or z > high[2]:
                continue
            first, last = obstacle[k], obstacle[k + 1]
            turns = _winding(triangles, order, start, plates, first, last, _FAR * _FAR, x, y, z)
            if abs(turns - 0.5) < _DOUBT:
                turns = _winding(triangles, order, start, plates, first, last, np.inf, x, y, z)
            if turns > 0.5:
                answer[i] = k
                break


def solid_turns(triangles: Floats, point: Floats) -> float:
    """Return the winding number of triangles (m, 3, 3) round a point (3,)."""
    return float(_turns(np.ascontiguousarray(triangles), point[0], point[1], point[2]))


@kernel(error_model="numpy")
def _turns(triangles, x, y, z):
    half_angle = 0.0
    for k in range(len(triangles)):
        half_angle += _half_angle(triangles, k, x, y, z)
    return half_angle / (2.0 * np.pi)
