"""Gaps in a surface that should be closed, and how wide they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.scene.imports.repair import merged_vertices

Floats = NDArray[np.float64]

#: Surfaces with more open edges than this are not looked at edge by edge.
_MOST = 4000
_ALONG = (0.25, 0.5, 0.75)


@dataclass(frozen=True)
class Gap:
    """A gap: how wide, infinite if there are too many to measure; and a place beside it (3,)."""

    width: float
    place: tuple[float, float, float]


def widest_gap(vertices: Floats, faces: NDArray[np.integer]) -> Gap | None:
    """Return the widest gap of a mesh of vertices (v, 3) and faces (m, 3), or None if it has none.

    An open edge lies at a gap as wide as the distance to the nearest open edge that runs the other way: a crack
    between two faces is as narrow as it looks, and a hole as wide as it is where it is widest between its rims.
    """
    starts, ends = _open_edges(vertices, faces)
    if not len(starts):
        return None
    if len(starts) > _MOST:
        return Gap(np.inf, _place(starts[0]))
    along = ends - starts
    squared = np.maximum(np.einsum("ei,ei->e", along, along), np.finfo(np.float64).tiny)
    widest = np.zeros(len(starts))
    for edge in range(len(starts)):
        others = along @ along[edge] < 0
        if not others.any():
            return Gap(np.inf, _place(starts[edge]))
        for share in _ALONG:
            off = starts[edge] + share * along[edge] - starts[others]
            foot = np.clip(np.einsum("ei,ei->e", off, along[others]) / squared[others], 0, 1)
            apart = np.linalg.norm(off - foot[:, None] * along[others], axis=1).min()
            widest[edge] = max(widest[edge], apart)
    worst = int(widest.argmax())
    return Gap(float(widest[worst]), _place(starts[worst]))


def _open_edges(vertices: Floats, faces: NDArray[np.integer]) -> tuple[Floats, Floats]:
    """Starts and ends (e, 3) of the edges that an odd number of triangles meet, as the triangles run along them."""
    places, corners, _ = merged_vertices(vertices, faces)
    corners = corners.astype(np.int64)
    start, end = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    start, end = start[start != end], end[start != end]
    key = np.minimum(start, end) * len(places) + np.maximum(start, end)
    _, first, count = np.unique(key, return_index=True, return_counts=True)
    alone = first[count % 2 == 1]
    return places[start[alone]], places[end[alone]]


def _place(point: Floats) -> tuple[float, float, float]:
    x, y, z = point.tolist()
    return x, y, z
