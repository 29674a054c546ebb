"""What the distance search needs to know of each triangle, worked out once.

A segment comes closest to a mesh where it cuts a triangle, where one of its ends lies over a triangle's
inside, or at an edge. An edge is shared by two triangles and needs looking at once; an edge inside a flat
region of the mesh needs no look at all, since the region's inside and its border cover it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel

# A triangle flatter than this (height over longest edge) has no usable normal and is searched by its edges.
_DEGENERATE = 1e-11
# An edge is flat if the normals on its two sides differ by at most this angle, rad …
_COPLANAR = 1e-9
# … and both triangles are no thinner, and have no shorter edge, than this relative to their longest edge.
_THIN = 1e-4
_NEEDLE = 1e-3

# The corners where edges AB, AC and BC start and end, and the corner across from each.
_EDGE_START, _EDGE_END, _EDGE_APEX = np.array([0, 0, 1]), np.array([1, 2, 2]), np.array([2, 1, 0])
_MIXERS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)
_LAST_MIXER, _SHIFT, _OTHER_SHIFT = np.uint64(0xBF58476D1CE4E5B9), np.uint64(32), np.uint64(29)


def face_rows(triangles: NDArray[np.float64], grown: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rows (m, 16) of triangles (m, 3, 3) that the search reads; each is thickened by `grown` (m,).

    Columns: corner A; edges B = AB and C = AC, of which B is the longest; unit normal, zero if the triangle
    is degenerate; for the edges AB, AC and BC one over the squared length, zero if it has none and
    negative if this triangle need not look at it; and the longest edge's length if an edge is flat, else 0.
    Edges are left only to neighbours that are thickened as much.
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
    skipped, flat = _shared_edges(corners, normal, shapely, grown)
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
    corners: NDArray[np.float64],
    normal: NDArray[np.float64],
    shapely: NDArray[np.bool_],
    grown: NDArray[np.float64],
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which edges AB, AC, BC, (m, 3), this triangle need not look at, and which of them are flat."""
    first, second = _pairs(corners)
    alike = grown[first // 3] == grown[second // 3]
    first, second = first[alike], second[alike]
    skipped, flat = np.zeros(3 * len(corners), np.bool_), np.zeros(3 * len(corners), np.bool_)
    skipped[second] = True

    lean = np.einsum("pi,pi->p", normal[first // 3], normal[second // 3])
    likely = np.abs(lean) > 1 - 1e-12
    first, second = first[likely], second[likely]
    (m, edge), (n, other_edge) = np.divmod(first, 3), np.divmod(second, 3)
    bend = np.linalg.norm(np.cross(normal[m], normal[n]), axis=1)
    origin = corners[m, _EDGE_START[edge]]
    along = corners[m, _EDGE_END[edge]] - origin
    inward = np.cross(along, corners[m, _EDGE_APEX[edge]] - origin)
    outward = np.cross(along, corners[n, _EDGE_APEX[other_edge]] - origin)
    opposite = np.einsum("pi,pi->p", inward, outward) < 0
    coplanar = shapely[m] & shapely[n] & opposite & (bend <= _COPLANAR)
    first, second = first[coplanar], second[coplanar]
    skipped[first] = flat[first] = flat[second] = True
    return skipped.reshape(-1, 3), flat.reshape(-1, 3)


def _pairs(corners: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the edges (3 × triangle + edge) that exactly two triangles share: in the first and the second."""
    # Sorting by a hash is many times faster than by coordinates; what it brings together is compared then.
    mixed = place_keys(corners.reshape(-1, 3)).reshape(-1, 3)
    key = (mixed[:, _EDGE_START] + mixed[:, _EDGE_END]).ravel()
    order = np.argsort(key)
    key = key[order]
    differs = np.concatenate([[True], key[1:] != key[:-1], [True]])
    twice = np.flatnonzero(differs[:-2] & ~differs[1:-1] & differs[2:])
    first, second = np.sort([order[twice], order[twice + 1]], axis=0)

    (m, edge), (n, other_edge) = np.divmod(first, 3), np.divmod(second, 3)
    a, b = corners[m, _EDGE_START[edge]], corners[m, _EDGE_END[edge]]
    c, d = corners[n, _EDGE_START[other_edge]], corners[n, _EDGE_END[other_edge]]
    same = ((a == c) & (b == d)).all(axis=1) | ((a == d) & (b == c)).all(axis=1)
    return first[same], second[same]


def place_keys(points: NDArray[np.float64]) -> NDArray[np.uint64]:
    """Return a hash (p,) of each point's coordinates (p, 3); those of equal points are equal."""
    bits = np.ascontiguousarray(points + 0.0).view(np.uint64)  # + 0.0: there is one zero only
    keys = np.empty(len(points), np.uint64)
    _mix(bits, keys)
    return keys


@kernel()
def _mix(bits, keys):
    """Fill the hashes; the last bits of most coordinates of files are zero, so each is mixed twice."""
    for i in range(len(bits)):
        total = np.uint64(0)
        for axis in range(3):
            one = bits[i, axis]
            one = (one ^ (one >> _SHIFT)) * _MIXERS[axis]
            one = (one ^ (one >> _OTHER_SHIFT)) * _MIXERS[axis]
            total += one ^ (one >> _SHIFT)
        total *= _LAST_MIXER
        keys[i] = total ^ (total >> _SHIFT)
