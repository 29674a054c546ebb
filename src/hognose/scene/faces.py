"""What the distance search needs to know of each triangle, worked out once.

A segment comes closest to a mesh where it cuts a triangle, where one of its ends lies over a triangle's
inside, or at an edge. An edge is shared by two triangles and needs looking at once; an edge inside a flat
region of the mesh needs no look at all, since the region's inside and its border cover it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# A triangle flatter than this (height over longest edge) has no usable normal and is searched by its edges.
_DEGENERATE = 1e-11
# An edge is flat if the normals on its two sides differ by at most this angle, rad …
_COPLANAR = 1e-9
# … and both triangles are no thinner, and have no shorter edge, than this relative to their longest edge.
_THIN = 1e-4
_NEEDLE = 1e-3


def face_rows(triangles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rows (m, 16) of triangles (m, 3, 3) that the search reads.

    Columns: corner A; edges B = AB and C = AC, of which B is the longest; unit normal, zero if the triangle
    is degenerate; for the edges AB, AC and BC one over the squared length, zero if it has none and
    negative if this triangle need not look at it; and the longest edge's length if an edge is flat, else 0.
    """
    corners = _longest_first(triangles)
    a, b, c = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    edges = np.stack([b, c, c - b], axis=1)
    squares = np.einsum("mei,mei->me", edges, edges)
    inverse = np.divide(1.0, squares, out=np.zeros_like(squares), where=squares > np.finfo(np.float64).tiny)

    # In a sliver the cross product leans along the triangle; square it up with the longest edge again.
    along = b * np.sqrt(inverse[:, :1])
    normal = np.cross(along, c * np.sqrt(inverse[:, :1]))
    normal -= np.einsum("mi,mi->m", normal, along)[:, None] * along
    height = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.divide(normal, height, out=np.zeros_like(normal), where=height > _DEGENERATE)

    shapely = (height[:, 0] > _THIN) & (squares.min(axis=1) > _NEEDLE**2 * squares[:, 0])
    skipped, flat = _shared_edges(corners, normal, shapely)
    inverse[skipped] *= -1.0
    longest = np.where(flat.any(axis=1), np.sqrt(squares[:, 0]), 0.0)
    return np.ascontiguousarray(np.concatenate([a, b, c, normal, inverse, longest[:, None]], axis=1))


def _longest_first(triangles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Turn the corners of each triangle so that its first edge is the longest."""
    sides = np.roll(triangles, -1, axis=1) - triangles
    longest = np.einsum("mei,mei->me", sides, sides).argmax(axis=1)
    turned = (longest[:, None] + np.arange(3)) % 3
    return np.take_along_axis(triangles, turned[:, :, None], axis=1)


def _shared_edges(
    corners: NDArray[np.float64], normal: NDArray[np.float64], shapely: NDArray[np.bool_]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which edges AB, AC, BC, (m, 3), this triangle need not look at, and which of them are flat."""
    ends = corners[:, [[0, 1], [0, 2], [1, 2]]].reshape(-1, 2, 3)
    far = corners[:, [2, 1, 0]].reshape(-1, 3)
    first, second = _pairs(ends)
    m, n = first // 3, second // 3

    origin, along = ends[first, 0], ends[first, 1] - ends[first, 0]
    inward, outward = np.cross(along, far[first] - origin), np.cross(along, far[second] - origin)
    opposite = np.einsum("pi,pi->p", inward, outward) < 0
    bend = np.linalg.norm(np.cross(normal[m], normal[n]), axis=1)
    coplanar = shapely[m] & shapely[n] & opposite & (bend <= _COPLANAR)

    skipped, flat = np.zeros(len(ends), np.bool_), np.zeros(len(ends), np.bool_)
    skipped[second] = True
    skipped[first[coplanar]] = True
    flat[first[coplanar]] = flat[second[coplanar]] = True
    return skipped.reshape(-1, 3), flat.reshape(-1, 3)


def _pairs(ends: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the indices of edges (e, 2, 3) that occur exactly twice: of the first and of the second."""
    if not len(ends):
        return np.empty(0, np.int64), np.empty(0, np.int64)
    # Sorting by a hash is many times faster than by coordinates; what it brings together is compared then.
    bits = (ends + 0.0).view(np.uint64)  # + 0.0: there is one zero only
    mixed = bits * np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)
    mixed ^= mixed >> np.uint64(29)
    corner = mixed.sum(axis=2) * np.uint64(0xBF58476D1CE4E5B9)
    key = (corner ^ (corner >> np.uint64(32))).sum(axis=1)
    order = np.argsort(key, kind="stable")
    sorted_key = key[order]
    new = np.flatnonzero(np.diff(sorted_key, prepend=~sorted_key[:1]) != 0)
    twice = new[np.diff(new, append=len(order)) == 2]
    first, second = order[twice], order[twice + 1]
    one, other = ends[first], ends[second]
    same = (one == other).all(axis=(1, 2)) | (one == other[:, ::-1]).all(axis=(1, 2))
    return first[same], second[same]
