"""Bodies of a file that are parts of one surface, put together.

Some programs write a closed body in parts: a group for each side, a solid for each patch. Each part by itself is open
and encloses nothing, so that an arm inside the body would be taken for free.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hognose.scene.imports.content import RawBody
from hognose.scene.imports.repair import merged_vertices

#: Names of parts that are all put into the name of the whole.
_MOST_NAMES = 3


def joined(bodies: Sequence[RawBody], parts: str) -> tuple[tuple[RawBody, ...], tuple[str, ...]]:
    """Return bodies with those put together whose open borders close each other, and what is to be said of it.

    Parameters
    ----------
    bodies
        In the order of the file.
    parts
        What the format calls them: "groups".
    """
    if len(bodies) < 2:
        return tuple(bodies), ()
    group = _groups(bodies)
    made: list[RawBody] = []
    for first in sorted(set(group)):
        members = [body for body, of in zip(bodies, group, strict=True) if of == first]
        made.append(members[0] if len(members) == 1 else _whole(members))
    if len(made) == len(bodies):
        return tuple(bodies), ()
    several = len(bodies) - sum(group.count(of) == 1 for of in set(group))
    whole = sum(group.count(of) > 1 for of in set(group))
    into = "one body" if whole == 1 else f"{whole:,} bodies"
    return tuple(made), (f"{several:,} {parts} that are parts of one surface put together: {into}",)


def _groups(bodies: Sequence[RawBody]) -> list[int]:
    """For each body, the first one of those it belongs with."""
    arrays = {id(body.vertices): body.vertices for body in bodies}
    offset, begin = {}, 0
    for key, vertices in arrays.items():
        offset[key] = begin
        begin += len(vertices)
    faces = np.concatenate([body.faces + offset[id(body.vertices)] for body in bodies])
    places, faces, _ = merged_vertices(np.concatenate(list(arrays.values())), faces)
    owner = np.repeat(np.arange(len(bodies)), [3 * len(body.faces) for body in bodies])
    key, owner = _open_edges(faces.astype(np.int64), owner, len(places))

    first = list(range(len(bodies)))

    def root(k: int) -> int:
        while first[k] != k:
            k = first[k]
        return k

    same = key[1:] == key[:-1]
    pairs = np.stack([owner[:-1][same], owner[1:][same]], axis=1)
    for a, b in np.unique(pairs, axis=0).tolist():
        a, b = sorted((root(a), root(b)))
        first[b] = a
    return [root(k) for k in range(len(bodies))]


def _open_edges(
    faces: NDArray[np.int64], owner: NDArray[np.int64], vertices: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Edges that are open in single bodies and closed in all together: a key and the body, sorted by the key."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    proper = start != end
    start, end, owner = start[proper], end[proper], owner[proper]
    key = np.minimum(start, end) * vertices + np.maximum(start, end)
    order = np.lexsort([owner, key])
    key, owner = key[order], owner[order]
    begins = np.flatnonzero(np.append(True, (key[1:] != key[:-1]) | (owner[1:] != owner[:-1])))
    # Not by direction: some programs wind the parts of one surface against each other.
    odd = np.diff(np.append(begins, len(key))) % 2 == 1
    key, owner = key[begins[odd]], owner[begins[odd]]
    if not len(key):
        return key, owner
    edges = np.flatnonzero(np.append(True, key[1:] != key[:-1]))
    count = np.diff(np.append(edges, len(key)))
    closed = np.repeat(count % 2 == 0, count)
    return key[closed], owner[closed]


def _whole(members: list[RawBody]) -> RawBody:
    names = [body.name for body in members if body.name]
    called = " + ".join(names) if len(names) <= _MOST_NAMES else f"{names[0]} + {len(names) - 1} more"
    if all(body.vertices is members[0].vertices for body in members):
        return RawBody(called, members[0].vertices, np.concatenate([body.faces for body in members]))
    offset = np.cumsum([0, *(len(body.vertices) for body in members)])
    faces = [body.faces + begin for body, begin in zip(members, offset[:-1], strict=True)]
    return RawBody(called, np.concatenate([body.vertices for body in members]), np.concatenate(faces))
