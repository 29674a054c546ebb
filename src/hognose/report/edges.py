"""The edges of triangle meshes that a draughtsman would draw, and which parts of them are seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

#: Corners closer than this are one corner, m.
_WELD = 1e-6
#: Neighbours that turn by more than this meet in a sharp edge.
_SHARP = np.cos(np.radians(30.0))


@dataclass(frozen=True)
class Edges:
    """The edges of a mesh, each once.

    Attributes
    ----------
    corners : (e, 2) int
        The edge's ends, as places in the list of all triangle corners (triangle * 3 + corner).
    sides : (e, 2) int
        The triangles on its two sides; the same one twice where there is only one.
    lone : (e,) bool
        Whether it has other than two triangles, so that it is an edge from everywhere.
    """

    corners: NDArray[np.int64]
    sides: NDArray[np.int64]
    lone: NDArray[np.bool_]


def edges_of(triangles: ArrayLike, owner: ArrayLike) -> Edges:
    """Return the edges of triangles (k, 3, 3), m; triangles are joined only within one owner (k,)."""
    points = np.asarray(triangles, dtype=float).reshape(-1, 3)
    keys = np.column_stack([np.round(points / _WELD).astype(np.int64), np.repeat(np.asarray(owner), 3)])
    _, name = np.unique(keys, axis=0, return_inverse=True)
    corner = np.arange(len(points)).reshape(-1, 3)
    ends = np.stack([corner, np.roll(corner, -1, axis=1)], axis=-1).reshape(-1, 2)
    names = np.sort(name.reshape(-1)[ends], axis=1)
    kept = names[:, 0] != names[:, 1]
    ends, names = ends[kept], names[kept]
    pair = names[:, 0] * len(points) + names[:, 1]
    _, first, inverse, count = np.unique(pair, return_index=True, return_inverse=True, return_counts=True)
    last = np.zeros(len(first), dtype=np.int64)
    np.maximum.at(last, inverse.reshape(-1), np.arange(len(names)))
    sides = np.column_stack([ends[first, 0], ends[last, 0]]) // 3
    return Edges(ends[first], sides, count != 2)


def normals_of(triangles: Floats) -> Floats:
    """Return the unit normals (k, 3) of triangles (k, 3, 3); zero for a triangle without area."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)


def drawn(edges: Edges, triangles: Floats, eye: Floats) -> Floats:
    """Return the edges to draw, (d, 2, 3) m: sharp ones, and the outline of what is round, seen from `eye`.

    Parameters
    ----------
    edges
        Of a mesh of the same build as `triangles`.
    triangles : (k, 3, 3) float, m
    eye : (3,) float, m
    """
    normals = normals_of(triangles)
    facing = np.einsum("ij,ij->i", normals, eye - triangles[:, 0]) > 0
    one, other = edges.sides.T
    sharp = np.einsum("ij,ij->i", normals[one], normals[other]) < _SHARP
    chosen = edges.lone | sharp | (facing[one] != facing[other])
    return triangles.reshape(-1, 3)[edges.corners[chosen]]


def runs(state: NDArray[np.int64], line: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return where stretches of equal state begin and end, within each line.

    Parameters
    ----------
    state : (p,) int
        At sample points along lines, one line after another.
    line : (p,) int
        The line each sample lies on.

    Returns
    -------
    first, last : (r,) int
        First and last sample of each stretch. A stretch ends where the next one on its line begins, so
        that no gap is left between them.
    """
    change = np.flatnonzero((np.diff(state) != 0) | (np.diff(line) != 0)) + 1
    first = np.concatenate([[0], change]).astype(np.int64)
    last = np.concatenate([change, [len(state)]]).astype(np.int64)
    joined = np.append(line[first[1:]] == line[first[:-1]], False)
    return first, np.where(joined, last, last - 1)
