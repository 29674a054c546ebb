"""Distances to triangles at all nodes of a grid: the closest triangle of a node is mostly that of a neighbour.

Points strewn over each triangle give it to the nodes around; sweeps through the grid then hand triangles on from node
to node, each measured exactly. What comes out is the distance to *some* triangle, so never too small, and rarely more
than a small part of a cell too large. Source: after Danielsson (1980), "Euclidean distance mapping"; own code.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel

#: Distance of the points on a triangle, in cells.
_STREWN = 0.7


def distances(triangles: NDArray, growth: NDArray, origin: NDArray, cell: float, far: float, out: NDArray) -> None:
    """Fill `out` (a, b, c) m with distances to triangles (m, 3, 3) thickened by growth (m,), at most `far` m."""
    owner = np.full(out.shape, -1, np.int32)
    out[...] = far
    _seed(triangles, growth, origin, cell, far, out, owner)
    for direction in (1, -1, 1):
        _sweep(triangles, growth, origin, cell, direction, out, owner)


@kernel()
def _away(tri: NDArray, x: float, y: float, z: float) -> float:
    """Distance of a point to a triangle, by the region it is in (Ericson, Real-Time Collision Detection, 5.1.5)."""
    ax, ay, az = tri[0, 0], tri[0, 1], tri[0, 2]
    ux, uy, uz = tri[1, 0] - ax, tri[1, 1] - ay, tri[1, 2] - az
    vx, vy, vz = tri[2, 0] - ax, tri[2, 1] - ay, tri[2, 2] - az
    px, py, pz = x - ax, y - ay, z - az
    d1, d2 = ux * px + uy * py + uz * pz, vx * px + vy * py + vz * pz
    s, t = 0.0, 0.0  # numba wants them known before the branches
    uu, uv, vv = ux * ux + uy * uy + uz * uz, ux * vx + uy * vy + uz * vz, vx * vx + vy * vy + vz * vz
    d3, d4 = d1 - uu, d2 - uv
    d5, d6 = d1 - uv, d2 - vv
    vc, vb, va = d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4
    if d1 <= 0.0 and d2 <= 0.0:
        s, t = 0.0, 0.0
    elif d3 >= 0.0 and d4 <= d3:
        s = 1.0
    elif d6 >= 0.0 and d5 <= d6:
        t = 1.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        s = d1 / (d1 - d3)
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        t = d2 / (d2 - d6)
    elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        t = (d4 - d3) / max((d4 - d3) + (d5 - d6), 1e-300)
        s = 1.0 - t
    else:
        whole = va + vb + vc
        s, t = vb / whole, vc / whole
    px, py, pz = px - s * ux - t * vx, py - s * uy - t * vy, pz - s * uz - t * vz
    return math.sqrt(px * px + py * py + pz * pz)


@kernel()
def _longest_edge(tri: NDArray) -> tuple[int, float, float]:
    """The longest edge of a triangle, by the corner it begins at; its length, and the triangle's height over it."""
    base, size2 = 0, -1.0
    for edge in range(3):
        edge2 = 0.0
        for axis in range(3):
            edge2 += (tri[(edge + 1) % 3, axis] - tri[edge, axis]) ** 2
        if edge2 > size2:
            base, size2 = edge, edge2
    size = math.sqrt(size2)
    p, q, apex = tri[base], tri[(base + 1) % 3], tri[(base + 2) % 3]
    along, height2 = 0.0, 0.0
    for axis in range(3):
        along += (apex[axis] - p[axis]) * (q[axis] - p[axis])
    along /= max(size * size, 1e-300)
    for axis in range(3):
        height2 += (apex[axis] - p[axis] - along * (q[axis] - p[axis])) ** 2
    return base, size, math.sqrt(height2)


@kernel()
def _part_in_box(
    first: NDArray, across: NDArray, origin: NDArray, cell: float, around: int, shape: tuple[int, int, int]
) -> tuple[float, float]:
    """Between which parts of it the line from `first` along `across` is in the grid and so many cells around."""
    low, high = 0.0, 1.0
    for axis in range(3):
        begin = origin[axis] - around * cell - first[axis]
        end = origin[axis] + (shape[axis] + around) * cell - first[axis]
        if across[axis] == 0.0:
            if begin > 0.0 or end < 0.0:
                high = -1.0
        elif across[axis] > 0.0:
            low, high = max(low, begin / across[axis]), min(high, end / across[axis])
        else:
            low, high = max(low, end / across[axis]), min(high, begin / across[axis])
    return low, high


@kernel()
def _seed(triangles: NDArray, growth: NDArray, origin: NDArray, cell: float, far: float, out: NDArray, owner: NDArray):
    """Give each triangle to the nodes of the cells that points on it lie in: rows of points along its longest edge."""
    a, b, c = out.shape
    around = math.ceil((far + growth.max()) / cell) + 1  # so many cells beside the grid are looked at, too
    apart = _STREWN * cell
    first, across = np.empty(3), np.empty(3)
    for m in range(triangles.shape[0]):
        tri = triangles[m]
        base, size, height = _longest_edge(tri)
        p, q, apex = tri[base], tri[(base + 1) % 3], tri[(base + 2) % 3]
        rows = max(1, math.ceil(height / apart))
        last_i, last_j, last_n = -around - 1, 0, 0
        for r in range(rows + 1):
            up = r / rows
            for axis in range(3):
                first[axis] = p[axis] + up * (apex[axis] - p[axis])
                across[axis] = (1.0 - up) * (q[axis] - p[axis])
            low, high = _part_in_box(first, across, origin, cell, around, out.shape)
            if low > high:
                continue
            columns = max(1, math.ceil((high - low) * (1.0 - up) * size / apart))
            for k in range(columns + 1):
                t = low + (high - low) * k / columns
                i = math.floor((first[0] + t * across[0] - origin[0]) / cell)
                j = math.floor((first[1] + t * across[1] - origin[1]) / cell)
                n = math.floor((first[2] + t * across[2] - origin[2]) / cell)
                if i == last_i and j == last_j and n == last_n:
                    continue
                last_i, last_j, last_n = i, j, n
                # What lies beside the grid is given to the nodes on its side.
                i, j, n = min(max(i, -1), a - 1), min(max(j, -1), b - 1), min(max(n, -1), c - 1)
                for di in range(2):
                    for dj in range(2):
                        for dk in range(2):
                            x, y, z = i + di, j + dj, n + dk
                            if x < 0 or y < 0 or z < 0 or x >= a or y >= b or z >= c or owner[x, y, z] == m:
                                continue
                            found = (
                                _away(tri, origin[0] + x * cell, origin[1] + y * cell, origin[2] + z * cell) - growth[m]
                            )
                            if found < out[x, y, z]:
                                out[x, y, z], owner[x, y, z] = found, m


@kernel()
def _sweep(
    triangles: NDArray, growth: NDArray, origin: NDArray, cell: float, direction: int, out: NDArray, owner: NDArray
) -> None:
    """Hand triangles on to the 13 neighbours that come later in the order of the sweep."""
    a, b, c = out.shape
    for step_i in range(a):
        i = step_i if direction > 0 else a - 1 - step_i
        for step_j in range(b):
            j = step_j if direction > 0 else b - 1 - step_j
            for step_k in range(c):
                k = step_k if direction > 0 else c - 1 - step_k
                x, y, z = origin[0] + i * cell, origin[1] + j * cell, origin[2] + k * cell
                best, which = out[i, j, k], owner[i, j, k]
                for n in range(13):
                    di, dj, dk = n // 9 - 1, (n // 3) % 3 - 1, n % 3 - 1
                    p, q, r = i + direction * di, j + direction * dj, k + direction * dk
                    if p < 0 or q < 0 or r < 0 or p >= a or q >= b or r >= c:
                        continue
                    m = owner[p, q, r]
                    apart = cell * math.sqrt(di * di + dj * dj + dk * dk)
                    if m < 0 or m == which or out[p, q, r] - apart >= best:
                        continue
                    found = _away(triangles[m], x, y, z) - growth[m]
                    if found < best:
                        best, which = found, m
                out[i, j, k], owner[i, j, k] = best, which
