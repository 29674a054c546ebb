"""Polygons of files: cut into triangles that cover them.

A polygon is cut into the fan of triangles round its first corner. As closed curves these add up to the polygon's
border, for the two ways along each inner edge cancel. So the winding numbers of the triangles round any point of the
plane add up to that of the polygon, and a point inside the polygon, where that is not zero, is inside at least one of
them: a fan covers its polygon, whether that is convex or not, and even if it crosses itself; beside a polygon that is
not convex it may cover more. The border stays the same, so that what was closed stays closed, and what is covered
beside the polygon is covered as often one way as the other: what is inside a body stays so.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: A polygon is said not to be flat if its corners lie this far from a plane, relative to its size.
_FLAT = 1e-3


def triangles(vertices: Floats, index: Ints, corners: Ints, first: int = 0) -> tuple[Ints, tuple[str, ...]]:
    """Return polygons cut into triangles (m, 3), and what is to be said of them.

    Parameters
    ----------
    vertices : (v, 3)
        All vertices of the file.
    index
        The vertices of all polygons, one after the other, from 0.
    corners
        How many each polygon has.
    first
        The number of the first vertex in the file, for messages.

    Raises
    ------
    InputError
        A polygon has fewer than three corners, or one that does not exist.
    """
    few = np.flatnonzero(corners < 3)
    if few.size:
        raise InputError(
            f"face {few[0] + 1} has {_count(int(corners[few[0]]), 'corner')}, expected three or more; is it damaged?"
        )
    wrong = np.flatnonzero((index < 0) | (index >= len(vertices)))
    if wrong.size:
        number = int(np.searchsorted(np.cumsum(corners), wrong[0], side="right")) + 1
        raise InputError(
            f"face {number} names the vertex {int(index[wrong[0]]) + first}, but there are {len(vertices):,}; is the "
            "file cut or damaged?"
        )
    return fans(index, corners), _bent(vertices, index, corners)


def fans(index: Ints, corners: Ints) -> Ints:
    """Return polygons cut into triangles (m, 3), given the vertices of all and the number of corners of each."""
    if len(corners) and (corners == 3).all():
        return index.reshape(-1, 3)
    first = np.repeat(np.append(0, np.cumsum(corners))[:-1], corners - 2)
    turn = np.arange(len(first)) - np.repeat(np.append(0, np.cumsum(corners - 2))[:-1], corners - 2)
    return index[np.stack([first, first + turn + 1, first + turn + 2], axis=1)]


def loose(vertices: Floats, faces: Ints) -> Floats:
    """Return the vertices (p, 3) that no triangle (m, 3) uses."""
    used = np.zeros(len(vertices), np.bool_)
    used[faces.reshape(-1)] = True
    return vertices[~used]


def gathered(begins: Ints, counts: Ints) -> Ints:
    """Return the places of all items of lists that begin at `begins` and have `counts` items each."""
    return np.repeat(begins - np.append(0, np.cumsum(counts))[:-1], counts) + np.arange(int(counts.sum()))


def _bent(vertices: Floats, index: Ints, corners: Ints) -> tuple[str, ...]:
    """What is to be said of polygons that are not flat: nobody knows which surface they mean."""
    many = corners > 3
    if not many.any():
        return ()
    ends = np.cumsum(corners)
    count = corners[many]
    begins = np.append(0, np.cumsum(count))[:-1]
    places = vertices[index[gathered((ends - corners)[many], count)]]
    following = np.arange(len(places)) + 1
    following[begins + count - 1] = begins
    with np.errstate(all="ignore"):  # what is not finite is refused elsewhere
        local = places - np.repeat(places[begins], count, axis=0)
        normal = np.add.reduceat(np.cross(local, local[following]), begins)  # twice the area, as a vector
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        height = np.einsum("ij,ij->i", local, np.repeat(normal, count, axis=0))
        apart = np.maximum.reduceat(height, begins) - np.minimum.reduceat(height, begins)
        size = np.linalg.norm(np.maximum.reduceat(local, begins) - np.minimum.reduceat(local, begins), axis=1)
        bent = apart > _FLAT * size
    if not bent.any():
        return ()
    return (
        f"{_count(int(bent.sum()), 'polygon')} of more than three corners not flat, by up to {apart[bent].max():.3g} "
        "in the file's unit: taken as triangles round the first corner; `tolerance` covers what else they may mean",
    )


def _count(number: int, one: str) -> str:
    return f"{number:,} {one if number == 1 else one + 's'}"
