"""Repairs of imported meshes that are safe: no part of a surface moves or vanishes, except where it is there twice.

- Vertices at the same place are merged.
- Triangles with two corners in one place are dropped if what is left of them is an edge of another triangle.
- Triangles that are there twice, wound the same way, are kept once.
- Triangles of a closed surface that are there both ways are kept once, and all of it is wound alike.
- A closed shell that is wound inwards is turned round, unless it is the wall of a cavity in another one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.scene.faces import place_keys
from hognose.scene.imports.facing import faced_alike
from hognose.scene.winding import solid_turns

Floats = NDArray[np.float64]
Faces = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Repaired:
    """A mesh after its repairs: vertices (v, 3), faces (m, 3), and what `geometry.Body` says of it."""

    vertices: Floats
    faces: Faces
    open_edges: int
    twisted_edges: int
    volume: float
    repairs: tuple[str, ...]


def repaired(vertices: Floats, faces: NDArray[np.integer]) -> Repaired:
    """Return a mesh with all safe repairs made; `faces` (m, 3) are indices into `vertices` (v, 3), all finite."""
    told = []
    vertices, faces, merged = merged_vertices(vertices, faces)
    if merged:
        told.append(f"{_count(merged, 'vertex', 'vertices')} merged")
    faces, collapsed = _without_collapsed(faces, len(vertices))
    if collapsed:
        told.append(f"{_count(collapsed, 'triangle')} dropped as collapsed to an edge or a point")
    faces, pairs, doubled = _without_doubles(faces)
    if doubled:
        told.append(f"{_count(doubled, 'triangle')} dropped as doubles")
    both = outwards = np.zeros(len(faces), np.bool_)
    at_open_edges, gaps, twists = _unpaired(faces, both, len(vertices))
    if len(pairs) or twists:
        faced = faced_alike(vertices, faces, pairs)
        if faced.once:
            were = "was" if faced.once == 1 else "were"
            told.append(f"{_count(faced.once, 'triangle')} that {were} there both ways kept once")
        if faced.turned:
            told.append(f"{_count(faced.turned, 'triangle')} turned round so that all face outwards")
        faces, outwards = faced.faces, faced.outwards
        at_open_edges, gaps, twists = _unpaired(faces, _enclosing(faces, faced.both, len(vertices)), len(vertices))
    faces, turned = _turned_outwards(vertices, faces, at_open_edges, outwards)
    if turned:
        told.append(f"{_count(turned, 'shell')} wound inwards turned round")
    return Repaired(vertices, faces, gaps, twists, float(_volumes(vertices, faces).sum()), tuple(told))


def merged_vertices(vertices: Floats, faces: NDArray[np.integer]) -> tuple[Floats, Faces, int]:
    """Return vertices that are used and all differ, the faces over them, and how many used ones were merged."""
    used = np.zeros(len(vertices), np.bool_)
    used[faces] = True
    kept = vertices[used] + 0.0  # + 0.0: there is one zero only
    place = np.cumsum(used) - 1
    # Sorting by a hash is many times faster than by coordinates.
    first, index = _groups(place_keys(kept))
    if not np.array_equal(kept[first][index], kept):  # two places with one hash
        _, index = np.unique(kept, axis=0, return_inverse=True)
        first, index = _groups(index.reshape(-1))
    return kept[first], index.astype(np.int32)[place[faces]], len(kept) - len(first)


def _groups(key: NDArray[np.integer]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Where each different key stands first, in that order, and for each key which of these it is."""
    order = np.argsort(key)
    begins = np.flatnonzero(np.append(True, key[order[1:]] != key[order[:-1]]))
    first = np.minimum.reduceat(order, begins)
    in_order = np.argsort(first)
    rank = np.empty(len(first), np.int64)
    rank[in_order] = np.arange(len(first))
    index = np.empty(len(key), np.int64)
    index[order] = np.repeat(rank, np.diff(np.append(begins, len(key))))
    return first[in_order], index


def _without_collapsed(faces: Faces, vertices: int) -> tuple[Faces, int]:
    collapsed = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
    if not collapsed.any() or collapsed.all():
        return faces, 0
    edges = np.sort(_edge_keys(faces[~collapsed], vertices))
    used = np.zeros(vertices, np.bool_)
    used[faces[~collapsed]] = True
    low, high = faces[collapsed].min(axis=1).astype(np.int64), faces[collapsed].max(axis=1).astype(np.int64)
    wanted = low * vertices + high
    on_edge = edges[np.minimum(np.searchsorted(edges, wanted), len(edges) - 1)] == wanted
    on_vertex = (low == high) & used[low]
    drop = np.flatnonzero(collapsed)[on_edge | on_vertex]
    return np.delete(faces, drop, axis=0), len(drop)


def _edge_keys(faces: Faces, vertices: int) -> NDArray[np.int64]:
    """One number for each edge (3 m,), the same in both directions."""
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2).astype(np.int64)
    return ends.min(axis=1) * vertices + ends.max(axis=1)


def _without_doubles(faces: Faces) -> tuple[Faces, NDArray[np.int64], int]:
    """Of equal triangles, wound the same way, the first is kept.

    With them come those (p, 2) that are the same but wound opposite ways, and how many were dropped.
    """
    # Whichever way they are wound, the same three corners come together, and then the same way.
    key = place_keys(np.sort(faces, axis=1).astype(np.float64))
    order = np.argsort(key)
    sorted_keys = key[order]
    like_next = np.append(sorted_keys[1:] == sorted_keys[:-1], False)
    few = order[like_next | np.append(False, like_next[:-1])]
    lead = faces[few].argmin(axis=1)[:, None]
    turned = np.take_along_axis(faces[few], (lead + np.arange(3)) % 3, axis=1)
    by_corners = np.lexsort((few, turned[:, 1] < turned[:, 2], *np.sort(turned, axis=1).T))
    few, turned = few[by_corners], turned[by_corners]
    same = np.append(False, (turned[1:] == turned[:-1]).all(axis=1))[: len(few)]
    drop, few = few[same], few[~same]
    corners = np.sort(faces[few], axis=1)
    proper = np.all(np.diff(corners, axis=1) > 0, axis=1)[1:]
    opposite = np.flatnonzero(np.all(corners[1:] == corners[:-1], axis=1) & proper)
    pairs = np.sort(np.stack([few[opposite], few[opposite + 1]], axis=1), axis=1)
    kept = np.ones(len(faces), np.bool_)
    kept[drop] = False
    return faces[kept], (np.cumsum(kept) - 1)[pairs], len(drop)


@dataclass(frozen=True, eq=False)
class _Shells:
    """The connected shells of a mesh, and its faces shell after shell."""

    of_face: NDArray[np.int32]
    order: NDArray[np.int64]
    start: NDArray[np.int64]
    closed: NDArray[np.bool_]
    low: Floats
    high: Floats

    def faces(self, k: int) -> NDArray[np.int64]:
        """The faces of shell k."""
        return self.order[self.start[k] : self.start[k + 1]]


def _shells(vertices: Floats, faces: Faces, at_open_edges: NDArray[np.int64]) -> _Shells:
    label = np.empty(len(vertices), np.int32)
    count = _label(faces, label)
    of_face = label[faces[:, 0]]
    order = np.argsort(of_face, kind="stable")
    start = np.searchsorted(of_face[order], np.arange(count + 1))
    closed = np.ones(count, np.bool_)
    closed[label[at_open_edges]] = False
    corners = vertices[faces[order]]
    low = np.minimum.reduceat(corners.min(axis=1), start[:-1])
    high = np.maximum.reduceat(corners.max(axis=1), start[:-1])
    return _Shells(of_face, order, start, closed, low, high)


def _turned_outwards(
    vertices: Floats, faces: Faces, at_open_edges: NDArray[np.int64], outwards: NDArray[np.bool_]
) -> tuple[Faces, int]:
    """Faces with closed shells turned so that they are wound outwards, and how many shells were turned.

    Shells of faces that were put `outwards` (m,) stay so: how they were wound says nothing of what they are.
    """
    shells = _shells(vertices, faces, at_open_edges)
    volume = np.bincount(shells.of_face, _volumes(vertices, faces), len(shells.closed))
    volume[~shells.closed] = 0.0
    # Inside out as a whole, walls of cavities included; then single shells.
    sign = -1.0 if volume.sum() < 0 else 1.0
    loose = shells.closed.copy()
    loose[shells.of_face[outwards]] = False
    inverted = loose & (sign * volume < 0)
    for k in np.flatnonzero(inverted):
        inverted[k] = not _is_cavity(vertices, faces, shells, int(k))
    turned = loose & (inverted ^ (sign < 0))
    if turned.any():
        faces = faces.copy()
        which = turned[shells.of_face]
        faces[which] = faces[which][:, ::-1]
    return faces, int(turned.sum())


def _is_cavity(vertices: Floats, faces: Faces, shells: _Shells, k: int) -> bool:
    """Whether shell k lies inside an odd number of other closed shells."""
    point = vertices[faces[shells.faces(k)[0], 0]]
    round_it = shells.closed & (shells.low <= point).all(axis=1) & (shells.high >= point).all(axis=1)
    round_it[k] = False
    turns = [solid_turns(vertices[faces[shells.faces(int(other))]], point) for other in np.flatnonzero(round_it)]
    return sum(abs(number) > 0.5 for number in turns) % 2 == 1


def _enclosing(faces: Faces, both: NDArray[np.bool_], vertices: int) -> NDArray[np.bool_]:
    """Which (m,) of the faces that are there `both` ways may enclose something, or are all there is.

    Fins on a body do not, nor what fans of polygons with a slit cover there and back: both meet the rest of a surface
    and have a rim that ends free.
    """
    if not both.any():
        return both
    doubled = faces[both]
    label = np.zeros(vertices, np.int32)
    count = _label(doubled, label)
    patch = label[doubled[:, 0]]
    rest = np.zeros(vertices, np.bool_)
    rest[faces[~both]] = True
    meets = np.bincount(patch, rest[doubled].any(axis=1), count) > 0
    _, edge, met = np.unique(_edge_keys(faces, vertices), return_inverse=True, return_counts=True)
    rim = (met[edge.reshape(-1, 3)] == 2)[both].any(axis=1)
    free = np.bincount(patch, rim, count) > 0
    enclosing = both.copy()
    enclosing[both] = ~(meets & free)[patch]
    return enclosing


def _unpaired(faces: Faces, both: NDArray[np.bool_], vertices: int) -> tuple[NDArray[np.int64], int, int]:
    """The vertices of edges that are not run along as often one way as the other, and their number.

    It comes in two: edges of holes, and edges on which two triangles are wound against each other. Those of triangles
    that are there `both` (m,) ways and may enclose something count as edges of holes.
    """
    start = faces.astype(np.int64).ravel()
    end = np.roll(faces, -1, axis=1).astype(np.int64).ravel()
    key = np.minimum(start, end) * vertices + np.maximum(start, end)
    order = np.argsort(key)
    key, way = key[order], np.where(start < end, 1, -1)[order]
    way[start[order] == end[order]] = 0
    begins = np.flatnonzero(np.append(True, key[1:] != key[:-1]))
    balance = np.add.reduceat(way, begins)
    wrong, twist = balance != 0, np.abs(balance) == 2
    if both.any():
        doubled = np.logical_or.reduceat(np.repeat(both, 3)[order], begins)
        wrong, twist = wrong | doubled, twist & ~doubled
    unpaired = key[begins[wrong]]
    twisted = int(twist.sum())
    return np.concatenate([unpaired // vertices, unpaired % vertices]), len(unpaired) - twisted, twisted


def _volumes(vertices: Floats, faces: Faces) -> Floats:
    """Signed volume (m,) between each triangle and the middle of all."""
    a, b, c = (vertices[faces[:, i]] - vertices.mean(axis=0) for i in range(3))
    return np.einsum("mi,mi->m", a, np.cross(b, c)) / 6


@kernel(error_model="numpy")
def _label(faces, label):
    """Number the vertices by the connected shell they are in; return the number of shells."""
    count = len(label)
    parent = np.arange(count)
    for k in range(len(faces)):
        a = faces[k, 0]
        while parent[a] != a:
            parent[a] = parent[parent[a]]
            a = parent[a]
        for i in range(1, 3):
            b = faces[k, i]
            while parent[b] != b:
                parent[b] = parent[parent[b]]
                b = parent[b]
            if b < a:
                a, b = b, a
            parent[b] = a
    shells = 0
    for v in range(count):
        if parent[v] == v:
            label[v] = shells
            shells += 1
        else:
            label[v] = label[parent[v]]
    return shells


def _count(number: int, one: str, many: str | None = None) -> str:
    return f"{number:,} {one if number == 1 else many or one + 's'}"
