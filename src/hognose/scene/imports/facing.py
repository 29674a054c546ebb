"""Triangles that face different ways: those that are there both ways, and shells whose winding changes.

Both upset the winding number, which tells what is inside: a closed box whose triangles all are there both ways has
none, and one with every second side turned round has too little.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel

Floats = NDArray[np.float64]
Faces = NDArray[np.int32]
Flags = NDArray[np.bool_]

#: If this share of a surface's triangles is wound alike, that is how it was meant, and the rest is wrong …
_MEANT = 0.9
# … unless more of them than this share are there both ways, so that little is known.
_UNKNOWN = 0.5


@dataclass(frozen=True, eq=False)
class Faced:
    """Faces (m, 3) after `faced_alike`.

    Attributes
    ----------
    both : (m,)
        Which ones are still there both ways.
    outwards : (m,)
        Which ones belong to surfaces that are wound outwards now because it cannot be told how they were meant.
    once, turned
        How many of those that were there both ways are kept once, and how many others are turned round.
    """

    faces: Faces
    both: Flags
    outwards: Flags
    once: int
    turned: int


def faced_alike(vertices: Floats, faces: Faces, pairs: NDArray[np.int64]) -> Faced:
    """Return faces (m, 3) so that all of a closed surface face the same way, each of them there once.

    It is done for connected surfaces that have two triangles at every edge, once triangles that are there both ways
    count once, and that have two sides. If nearly all triangles are wound one way, so are the rest then; else all
    face outwards. Other surfaces stay as they are.

    Parameters
    ----------
    vertices, faces
        No two faces are the same, wound the same way.
    pairs
        The faces (p, 2) that are the same, wound opposite ways.
    """
    again = np.zeros(len(faces), np.bool_)
    again[pairs[:, 1]] = True
    single = np.flatnonzero(~again)
    corners = faces[single]
    alone = np.ones(len(faces), np.bool_)
    alone[pairs] = False
    alone = alone[single]

    piece = np.empty(len(single), np.int64)
    turned = np.zeros(len(single), np.bool_)
    sound = np.ones(len(single), np.bool_)
    count = _fill(corners.reshape(-1), _mates(corners, len(vertices)), piece, turned, sound)
    volume = np.empty(len(single))
    _volumes(vertices, corners, vertices.mean(axis=0), volume)
    turned ^= (np.bincount(piece, np.where(turned, -volume, volume), count) < 0)[piece]

    size, known = np.bincount(piece, minlength=count), np.bincount(piece, alone, count)
    wrong = np.bincount(piece, alone & turned, count)
    told = known > _UNKNOWN * size
    inwards = told & (wrong >= _MEANT * known)
    doubtful = ~inwards & ~(told & (known - wrong >= _MEANT * known))
    mended = sound[:count] & (((wrong > 0) & (wrong < known)) | (known < size))

    turned = (turned ^ inwards[piece]) & mended[piece]
    faces, both, outwards = faces.copy(), np.zeros(len(faces), np.bool_), np.zeros(len(faces), np.bool_)
    faces[single[turned]] = corners[turned][:, ::-1]
    outwards[single] = (mended & doubtful)[piece]
    of_face = np.empty(len(faces), np.int64)
    of_face[single] = piece
    once = mended[of_face[pairs[:, 0]]]
    both[pairs[~once]] = True
    kept = np.ones(len(faces), np.bool_)
    kept[pairs[once, 1]] = False
    return Faced(faces[kept], both[kept], outwards[kept], int(once.sum()), int((turned & alone).sum()))


def _mates(faces: Faces, vertices: int) -> NDArray[np.int64]:
    """For each edge (3 m,) of triangles, the same edge of the other triangle there; -1 if there is not just one."""
    start, end = faces.astype(np.int64).ravel(), np.roll(faces, -1, axis=1).astype(np.int64).ravel()
    key = np.minimum(start, end) * vertices + np.maximum(start, end)
    order = np.argsort(key)
    begins = np.flatnonzero(np.append(True, np.diff(key[order]) != 0))
    two = begins[np.diff(np.append(begins, len(key))) == 2]
    mates = np.full(len(key), -1)
    mates[order[two]], mates[order[two + 1]] = order[two + 1], order[two]
    return mates


@kernel(error_model="numpy")
def _fill(start, mates, piece, turned, sound):
    """Number the surfaces that triangles are connected to by edges of two; return how many there are.

    `start` (3 m,) is where each edge starts. Fills which triangles are to be turned to be wound like the first of
    their surface, and which surfaces have two triangles at every edge and two sides.
    """
    piece[:] = -1
    waiting = np.empty(len(piece), np.int64)
    count = 0
    for first in range(len(piece)):
        if piece[first] >= 0:
            continue
        piece[first] = count
        waiting[0] = first
        filled = 1
        while filled > 0:
            filled -= 1
            k = waiting[filled]
            for edge in range(3 * k, 3 * k + 3):
                mate = mates[edge]
                if mate < 0:
                    sound[count] = False
                    continue
                other = mate // 3
                to_turn = turned[k] ^ (start[edge] == start[mate])
                if piece[other] < 0:
                    piece[other] = count
                    turned[other] = to_turn
                    waiting[filled] = other
                    filled += 1
                elif turned[other] != to_turn:
                    sound[count] = False
        count += 1
    return count


@kernel(error_model="numpy")
def _volumes(vertices, faces, middle, volume):
    """Fill six times the signed volume between each triangle and the middle."""
    for k in range(len(faces)):
        a = faces[k, 0]
        ax, ay, az = vertices[a, 0] - middle[0], vertices[a, 1] - middle[1], vertices[a, 2] - middle[2]
        b = faces[k, 1]
        bx, by, bz = vertices[b, 0] - middle[0], vertices[b, 1] - middle[1], vertices[b, 2] - middle[2]
        c = faces[k, 2]
        cx, cy, cz = vertices[c, 0] - middle[0], vertices[c, 1] - middle[1], vertices[c, 2] - middle[2]
        volume[k] = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
