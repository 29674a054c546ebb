"""The search over arcs (hybrid A*): kernels.

A state is a place and a heading, a move an arc of constant curvature, straight or bent to one of several sides. What
is left of the way is estimated by the cheapest way over the grid, which knows the obstacles and not the bending.
Source: Dolgov et al. (2008), "Practical search techniques in path planning", carried over to three dimensions; own
code.
"""

from __future__ import annotations

import heapq
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel

#: A move is tested at least so often, and where it passes by no more than this part of the width needed.
TESTS, SPACING = 4, 0.5
#: From so near, in moves, the last arc may go to the target.
LAST = 4.4
#: Sides that a move may bend to.
SIDES = 8
#: Places closer than this part of a move are one state if their headings are in the same bin.
PITCH = 0.53
MOST_EXPANSIONS = 25_000


@kernel()
def _at(field: NDArray, origin: NDArray, cell: float, x: float, y: float, z: float) -> float:
    """The field between its nodes, trilinear; -1 outside."""
    u, v, w = (x - origin[0]) / cell, (y - origin[1]) / cell, (z - origin[2]) / cell
    i, j, k = math.floor(u), math.floor(v), math.floor(w)
    a, b, c = field.shape
    if i < 0 or j < 0 or k < 0 or i + 1 >= a or j + 1 >= b or k + 1 >= c:
        return -1.0
    u, v, w = u - i, v - j, w - k
    total = 0.0
    for di in range(2):
        for dj in range(2):
            for dk in range(2):
                part = (u if di else 1.0 - u) * (v if dj else 1.0 - v) * (w if dk else 1.0 - w)
                total += part * field[i + di, j + dj, k + dk]
    return total


@kernel()
def _nearest(field: NDArray, origin: NDArray, cell: float, x: float, y: float, z: float) -> Any:
    """The field at the nearest node; infinite outside."""
    i = math.floor((x - origin[0]) / cell + 0.5)
    j = math.floor((y - origin[1]) / cell + 0.5)
    k = math.floor((z - origin[2]) / cell + 0.5)
    a, b, c = field.shape
    if i < 0 or j < 0 or k < 0 or i >= a or j >= b or k >= c:
        return np.inf
    return field[i, j, k]


@kernel()
def _state(p: NDArray, t: NDArray, origin: NDArray, shape: NDArray, pitch: float, bins: int) -> int:
    """The number of the state that a place and a heading belong to; -1 outside."""
    index = 0
    for axis in range(3):
        n = math.floor((p[axis] - origin[axis]) / pitch)
        if n < 0 or n >= shape[axis]:
            return -1
        index = index * shape[axis] + n
    face = 0
    for axis in range(1, 3):
        if abs(t[axis]) > abs(t[face]):
            face = axis
    scale = 1.0 / abs(t[face])
    u = t[(face + 1) % 3] * scale
    v = t[(face + 2) % 3] * scale
    row = min(bins - 1, int((u + 1.0) * 0.5 * bins))
    column = min(bins - 1, int((v + 1.0) * 0.5 * bins))
    return ((index * 6 + 2 * face + (1 if t[face] < 0 else 0)) * bins + row) * bins + column


@kernel()
def _arc(p: NDArray, t: NDArray, side: NDArray, bend: float, s: float, q: NDArray, out: NDArray) -> None:
    """Place q and heading `out` after s m of an arc of curvature `bend` that turns from t to the side."""
    turn = bend * s
    along = math.sin(turn) / bend if bend > 0.0 else s
    across = (1.0 - math.cos(turn)) / bend if bend > 0.0 else 0.0
    ct, st = math.cos(turn), math.sin(turn)
    for axis in range(3):
        q[axis] = p[axis] + along * t[axis] + across * side[axis]
        out[axis] = ct * t[axis] + st * side[axis]


@kernel()
def _tested(
    distance: NDArray,
    cost: NDArray,
    origin: NDArray,
    cell: float,
    p: NDArray,
    t: NDArray,
    side: NDArray,
    bend: float,
    length: float,
    tests: int,
    need: float,
    q: NDArray,
    out: NDArray,
) -> float:
    """Cost of an arc, infinite if it does not pass; its end comes in q and `out`."""
    total = 0.0
    for n in range(1, tests + 1):
        _arc(p, t, side, bend, length * n / tests, q, out)
        # Between nodes the field is too low at the middle of a narrow passage.
        if _at(distance, origin, cell, q[0], q[1], q[2]) < need - 0.5 * cell:
            return np.inf
        total += _nearest(cost, origin, cell, q[0], q[1], q[2])
    return total / tests * length


@kernel()
def _arc_to(target: NDArray, p: NDArray, t: NDArray, sharpest: float, within: float, side: NDArray) -> Any:
    """Length and curvature of the arc from p along t to the target, and in `side` where it turns to.

    The length is infinite where the target is not within reach, lies behind, or is reached only by a sharper bend.
    """
    dx, dy, dz = target[0] - p[0], target[1] - p[1], target[2] - p[2]
    away = math.sqrt(dx * dx + dy * dy + dz * dz)
    ahead = dx * t[0] + dy * t[1] + dz * t[2]
    if away >= within or ahead <= 0.0:
        return np.inf, 0.0
    side[0], side[1], side[2] = dx - ahead * t[0], dy - ahead * t[1], dz - ahead * t[2]
    beside = math.sqrt(side[0] * side[0] + side[1] * side[1] + side[2] * side[2])
    bend = 2.0 * beside / max(away * away, 1e-12)
    if bend > sharpest:
        return np.inf, 0.0
    if beside > 1e-12:
        side /= beside
    arc = away if bend * away < 1e-9 else 2.0 * math.asin(min(1.0, 0.5 * bend * away)) / bend
    return arc, bend


@kernel()
def _sides(t: NDArray, e1: NDArray, e2: NDArray) -> None:
    """Two unit vectors e1, e2 across a heading t and each other."""
    smallest = 0
    for axis in range(1, 3):
        if abs(t[axis]) < abs(t[smallest]):
            smallest = axis
    for axis in range(3):
        e1[axis] = (1.0 if axis == smallest else 0.0) - t[smallest] * t[axis]
    e1 /= math.sqrt(e1[0] * e1[0] + e1[1] * e1[1] + e1[2] * e1[2])
    e2[0], e2[1], e2[2] = t[1] * e1[2] - t[2] * e1[1], t[2] * e1[0] - t[0] * e1[2], t[0] * e1[1] - t[1] * e1[0]


@kernel()
def _turned(bend: float, side: NDArray, spin: NDArray, sharpest: float) -> float:
    """Cost of a metre of a bend to a side, after a move with the curvature vector `spin`."""
    change = 0.0
    for axis in range(3):
        change += (bend * side[axis] - spin[axis]) ** 2
    return (0.3 * bend * bend + 0.3 * change) / (sharpest * sharpest)


@kernel()
def search_arcs(
    distance: NDArray,
    cost: NDArray,
    left: NDArray,
    origin: NDArray,
    cell: float,
    start: NDArray,
    heading: NDArray,
    target: NDArray,
    need: float,
    sharpest: float,
    longest: float,
    move: float,
    headings: int,
    greed: float,
    bends: NDArray,
    shape: NDArray,
) -> tuple[NDArray, NDArray, NDArray]:
    """Hybrid A*: parents (m,) and places (m, 3) of visited states, and the heading (3,) at the last of them."""
    seen = {-1}
    tests = max(TESTS, math.ceil(move / (SPACING * need)))
    capacity = MOST_EXPANSIONS * 8
    places, tangents = np.empty((capacity, 3)), np.empty((capacity, 3))
    spins = np.zeros((capacity, 3))  # curvature vector of the move that came here
    lengths, paid = np.zeros(capacity), np.zeros(capacity)
    parent = np.full(capacity, -1, np.int64)
    places[0], tangents[0] = start, heading
    count, expanded = 1, 0
    queue = [(0.0, 0)]
    q, out, side = np.empty(3), np.empty(3), np.empty(3)
    e1, e2 = np.empty(3), np.empty(3)
    while len(queue) > 0 and expanded < MOST_EXPANSIONS:
        _, at = heapq.heappop(queue)
        p, t = places[at], tangents[at]
        state = _state(p, t, origin, shape, PITCH * move, headings)
        if state in seen:
            continue
        seen.add(state)
        expanded += 1
        arc, bend = _arc_to(target, p, t, sharpest, LAST * move, side)
        if arc < np.inf and lengths[at] + arc <= longest:
            most = max(1, math.ceil(arc / move * tests))
            if _tested(distance, cost, origin, cell, p, t, side, bend, arc, most, need, q, out) < np.inf:
                return parent[: at + 1].copy(), places[: at + 1].copy(), t.copy()
        _sides(t, e1, e2)
        for way in range(1 + SIDES * bends.size):
            bend, angle = 0.0, 0.0
            if way > 0:
                bend = sharpest * bends[(way - 1) // SIDES]
                angle = 2.0 * math.pi * ((way - 1) % SIDES) / SIDES
            for axis in range(3):
                side[axis] = math.cos(angle) * e1[axis] + math.sin(angle) * e2[axis]
            total = _tested(distance, cost, origin, cell, p, t, side, bend, move, tests, need, q, out)
            if not total < np.inf or count >= capacity:
                continue
            rest = _nearest(left, origin, cell, q[0], q[1], q[2])
            straight = math.sqrt((target[0] - q[0]) ** 2 + (target[1] - q[1]) ** 2 + (target[2] - q[2]) ** 2)
            if not rest < np.inf or lengths[at] + move + straight > longest:
                continue
            state = _state(q, out, origin, shape, PITCH * move, headings)
            if state in seen:
                continue
            turned = _turned(bend, side, spins[at], sharpest)
            places[count], tangents[count] = q, out
            spins[count] = bend * side
            lengths[count] = lengths[at] + move
            paid[count] = paid[at] + total + move * turned
            parent[count] = at
            heapq.heappush(queue, (paid[count] + greed * rest, count))
            count += 1
    return np.empty(0, np.int64), np.empty((0, 3)), np.empty(3)
