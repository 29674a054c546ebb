"""That the body does not touch itself, at the steps and between them.

First the bends: two points with arc s and summed bends φ < π between them are at least s cos(φ/2) apart, whatever the
distances. Where that is not enough, distances of chords: with d₀, d₁ the clearances of two chords at two set-points, m
how far they move beside each other and E how far they bulge, they keep (d₀ + d₁ - m) / 2 - Eᵢ - Eⱼ in between, over as
many steps at once as that proves. Single steps for which it proves too little are halved. See docs/certificate.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.planning.certificate.bound import MOST_HALVINGS
from hognose.planning.certificate.moving import Array, Moving, Pieces, mounted_body, with_mount
from hognose.robot import Robot
from hognose.robot.base import Base
from hognose.robot.own_body import MOUNT, OwnBody, separation
from hognose.ties import first_smallest

Rows = NDArray[np.int64]

#: The bound is tightened until it is this close (m) to the smallest clearance that was seen, or by this part of it …
TIGHTNESS, LOOSENESS = 2.5e-4, 0.25
#: … or closer, down to this (m), where that proves that the body does not touch itself.
TIGHTEST = 2e-5


@dataclass(frozen=True)
class OwnClearance:
    """A proven lower bound of the clearance within the body over a whole continuous motion.

    Attributes
    ----------
    clearance : m
        No two links come closer to each other than this at any time, nor to the mount, beside joints excepted; at most
        `horizon`. Zero or less where they touch: then it is the smallest that was seen.
    horizon : m
        What is farther apart is not measured.
    step
        The row of the plan at or after which it comes closest; None if nothing is closer than the horizon.
    links
        The two links (0-based) that do; the first one may be `MOUNT`.
    place : (3,) m
        Half way between them.
    halvings
        Configurations that were looked at besides the steps.
    """

    clearance: float
    horizon: float
    step: int | None = None
    links: tuple[int, int] = (0, 0)
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)
    halvings: int = 0


@kernel()
def _wanted(seen: float, horizon: float) -> float:
    """The bound (m) that is worth halving for, where this is the smallest clearance that was seen."""
    if seen <= 0.0:
        return seen
    enough = seen - max(TIGHTNESS, LOOSENESS * seen)
    return min(horizon, max(0.0, enough) if seen > TIGHTEST else enough)


@kernel(fastmath={"contract"})
def _moved(low: NDArray, high: NDArray, at: int, to: int, i: int, j: int) -> float:
    """The largest |Δp - Δq| of an end p of chord i and an end q of chord j, from one row to another."""
    largest = 0.0
    for p in range(i, i + 2):
        for q in range(j, j + 2):
            x = high[to, p, 0] - low[at, p, 0] - high[to, q, 0] + low[at, q, 0]
            y = high[to, p, 1] - low[at, p, 1] - high[to, q, 1] + low[at, q, 1]
            z = high[to, p, 2] - low[at, p, 2] - high[to, q, 2] + low[at, q, 2]
            largest = max(largest, x * x + y * y + z * z)
    return math.sqrt(largest)


@kernel(fastmath={"contract"})
def _bulged(bulge: NDArray, row: int, i: int, j: int) -> float:
    """How far both chords bulge together."""
    return max(bulge[row, i], bulge[row, i + 1]) + max(bulge[row, j], bulge[row, j + 1])


@kernel(fastmath={"contract"})
def _gone(travel: NDArray, row: int, i: int, j: int) -> float:
    """How far both chords go together."""
    return max(travel[row, i], travel[row, i + 1]) + max(travel[row, j], travel[row, j + 1])


@kernel(fastmath={"contract"})
def _stride(
    vertices: NDArray,
    travelled: NDArray,
    travel: NDArray,
    bulge: NDArray,
    straight: bool,
    summed: NDArray,
    most: Any,
    pair: tuple[int, int, int],
    lengths: NDArray,
    limits: tuple[float, float, float, float],
    seen: NDArray,
    rows: NDArray,
    found: NDArray,
) -> int:
    """Go along all steps with one pair in the longest strides that are proven; the single steps that are not.

    `most` is how far both chords go and bulge in any step, `pair` its number and its chords, `limits` its arc apart,
    thickness, bend and horizon. Of `seen` (4,), the smallest clearance at a step, where, and which pair, and the
    smallest bound that was enough come back lowered. Returns how many steps are loose; their rows, and clearances at
    both ends, are written.
    """
    number, i, j = pair
    apart, thick, bent, horizon = limits
    last, t, count, low, known = vertices.shape[0] - 1, 0, 0, 0.0, False
    fastest, bulgiest = most
    while t < last:
        if summed.size and max(summed[t, j] - summed[t, i], summed[t + 1, j] - summed[t + 1, i]) <= bent:
            t, known = t + 1, False
            continue
        if not known:
            low = separation(vertices, t, i, j, lengths[i], lengths[j], apart)[0] - thick
            if low < seen[0]:
                seen[0], seen[1], seen[2] = low, t, number
        free = 2.0 * (low - _wanted(seen[0], horizon) - bulgiest)
        stride = last - t
        if fastest > 0.0 and free < fastest * stride:
            stride = max(1, int(free / fastest))
        while True:
            high = separation(vertices, t + stride, i, j, lengths[i], lengths[j], apart)[0] - thick
            if high < seen[0]:
                seen[0], seen[1], seen[2] = high, t + stride, number
            if stride == 1:
                moved = _moved(vertices, vertices, t, t + 1, i, j) if straight else _gone(travel, t, i, j)
                bound = 0.5 * (low + high - moved) - _bulged(bulge, t, i, j)
                break
            moved = travelled[t + stride, i] - travelled[t, i] + travelled[t + stride, j] - travelled[t, j]
            bound = 0.5 * (low + high - moved) - bulgiest
            if bound >= _wanted(seen[0], horizon):
                break
            stride = stride // 2
        if bound < _wanted(seen[0], horizon):
            rows[count], found[count, 0], found[count, 1] = t, low, high
            count += 1
        else:
            seen[3] = min(seen[3], bound)
        t, low, known = t + stride, high, True
    return count


@kernel(fastmath={"contract"})
def _strides(
    vertices: NDArray,
    travelled: NDArray,
    travel: NDArray,
    bulge: NDArray,
    straight: bool,
    summed: NDArray,
    pairs: NDArray,
    lengths: NDArray,
    limits: NDArray,
    seen: NDArray,
) -> tuple[NDArray, NDArray]:
    """All pairs, as `_stride`: number of the pair and row (k, 2), and clearances (k, 2), of what is loose."""
    steps = vertices.shape[0] - 1
    rows, found = np.empty(steps, np.int64), np.empty((steps, 2))
    fastest, bulgiest = np.zeros(lengths.size), np.zeros(lengths.size)
    for k in range(steps):
        for i in range(lengths.size):
            fastest[i] = max(fastest[i], travel[k, i], travel[k, i + 1])
            bulgiest[i] = max(bulgiest[i], bulge[k, i], bulge[k, i + 1])
    loose, clearances, total = np.empty((256, 2), np.int64), np.empty((256, 2)), 0
    for k in range(pairs.shape[0]):
        i, j = pairs[k, 0], pairs[k, 1]
        limit = (limits[k, 0], limits[k, 1], limits[k, 2], limits[k, 3])
        most = (fastest[i] + fastest[j], bulgiest[i] + bulgiest[j])
        count = _stride(
            vertices, travelled, travel, bulge, straight, summed, most, (k, i, j), lengths, limit, seen, rows, found
        )
        while total + count > loose.shape[0]:
            loose, clearances = np.concatenate((loose, loose)), np.concatenate((clearances, clearances))
        for c in range(count):
            loose[total + c, 0], loose[total + c, 1] = k, rows[c]
            clearances[total + c, 0], clearances[total + c, 1] = found[c, 0], found[c, 1]
        total += count
    return loose[:total], clearances[:total]


@kernel(fastmath={"contract"})
def _bounds(
    low: NDArray,
    high: NDArray,
    travel: NDArray,
    bulge: NDArray,
    straight: bool,
    pairs: NDArray,
    loose: NDArray,
    clearances: NDArray,
    out: NDArray,
) -> None:
    """The lower bound (k,) of pairs over intervals `loose` (k, 2) whose clearances at both ends are (k, 2)."""
    for k in range(out.size):
        row = loose[k, 1]
        i, j = pairs[loose[k, 0], 0], pairs[loose[k, 0], 1]
        moved = _moved(low, high, row, row, i, j) if straight else _gone(travel, row, i, j)
        out[k] = 0.5 * (clearances[k, 0] + clearances[k, 1] - moved) - _bulged(bulge, row, i, j)


@kernel(fastmath={"contract"})
def _measured(
    vertices: NDArray, pairs: NDArray, lengths: NDArray, limits: NDArray, loose: NDArray, out: NDArray
) -> None:
    """The clearance (k,) of pairs in bodies `loose` (k, 2)."""
    for k in range(out.size):
        p = loose[k, 0]
        i, j = pairs[p, 0], pairs[p, 1]
        out[k] = separation(vertices, loose[k, 1], i, j, lengths[i], lengths[j], limits[p, 0])[0] - limits[p, 1]


def certify_own_body(
    moving: Moving,
    robot: Robot,
    vertices: Array,
    bends: Array | None = None,
    base: Base | None = None,
) -> OwnClearance:
    """The certificate of a motion's body against itself, and against what it is mounted on.

    Parameters
    ----------
    moving
    robot
    vertices : (T, p+1, 3) m
        Ends of chords at the set-points.
    bends : (T, n) rad, optional
        Bends at the joints of straight links, convex in the angles, at the set-points: with them most pairs need no
        distance.
    base : optional
        Whose mount is part of the body; without one, nothing is.
    """
    vertices = np.require(vertices, requirements=("C", "W"))  # kernels are compiled for arrays of one kind
    # Where sections extend, neighbours are what they are when shortest; of others `clearance_of_neighbours` says it.
    body = OwnBody.of(robot, base.mount if base else None, robot.length_bounds[:, 0])
    if bends is not None and len(bends) > 1:
        bends = moving.bends_within(bends)
        if body.cleared_by_bends(bends):
            return OwnClearance(body.horizon, body.horizon)
    if base is not None and body.mounts:
        moving, vertices = with_mount(moving, base), mounted_body(moving, base, vertices)
    if len(vertices) < 2 or not len(body.pairs):
        return _standing(body, robot, vertices)
    none = np.empty((len(vertices) - 1, 1))  # clearances to obstacles
    steps, parameters = np.arange(len(none)), moving.parameters
    pieces = Pieces(steps, parameters[:-1], parameters[1:], vertices[:-1], vertices[1:], none, none)
    travel, bulge = moving.travel(pieces)
    travelled = np.zeros((len(vertices), len(body.lengths)))
    np.cumsum(np.maximum(travel[:, :-1], travel[:, 1:]), axis=0, out=travelled[1:])
    summed = np.empty((0, 0)) if bends is None else body.summed(bends)
    limits = np.stack([body.aparts, body.thick, body.most_bent, np.full(len(body.pairs), body.horizon)], axis=1)
    seen = np.array([math.inf, 0.0, 0.0, math.inf])
    loose, clearances = _strides(
        vertices, travelled, travel, bulge, moving.straight, summed, body.pairs, body.lengths, limits, seen
    )
    row, pair = int(seen[1]), int(seen[2])
    closest = _Closest(float(seen[0]), row, pair, vertices[row])
    return _refined(moving, robot, body, pieces, loose, clearances, closest, float(seen[3]))


@dataclass(frozen=True, eq=False)
class _Closest:
    """The smallest clearance (m) that was seen: at or after which step, of which pair, in which body (p+1, 3) m."""

    clearance: float
    step: int
    pair: int
    body: Array


def _refined(
    moving: Moving,
    robot: Robot,
    own: OwnBody,
    pieces: Pieces,
    loose: Rows,
    clearances: Array,
    closest: _Closest,
    lowest: float,
) -> OwnClearance:
    """Halve what is loose, pairs and intervals (k, 2) with clearances (k, 2) at both ends, until it is proven."""
    limits, looked_at = np.stack([own.aparts, own.thick], axis=1), 0
    bound = np.empty(len(loose))
    for halving in range(MOST_HALVINGS + 1):
        bound = np.empty(len(loose))
        travel, bulge = moving.travel(pieces)
        low, high = np.ascontiguousarray(pieces.low_body), np.ascontiguousarray(pieces.high_body)
        _bounds(low, high, travel, bulge, moving.straight, own.pairs, loose, clearances, bound)
        still = bound < _wanted(closest.clearance, own.horizon)
        if closest.clearance <= 0.0 or not still.any():
            break
        if halving == MOST_HALVINGS:
            (worst,) = first_smallest(bound)
            pair, row = loose[worst]
            closest = _Closest(float(bound.min()), int(pieces.step[row]), int(pair), pieces.low_body[row])
            break
        lowest = min(lowest, float(bound[~still].min(initial=math.inf)))
        used, row = np.unique(loose[still, 1], return_inverse=True)
        pair, clearances = loose[still, 0], clearances[still]
        pieces = pieces.chosen(used)
        parameters, body = moving.place(0.5 * (pieces.low + pieces.high))
        body = np.ascontiguousarray(body)
        middle = np.empty(len(pair))
        _measured(body, own.pairs, own.lengths, limits, np.stack([pair, row], axis=1), middle)
        looked_at += len(body)
        if middle.min() < closest.clearance:
            (least,) = first_smallest(middle)
            step = int(pieces.step[row[least]])
            closest = _Closest(float(middle.min()), step, int(pair[least]), body[row[least]])
        pieces = pieces.halved(parameters, body, np.empty((len(body), 1)))
        loose = np.concatenate([np.stack([pair, 2 * row + half], axis=1) for half in (0, 1)])
        clearances = np.concatenate([np.stack([clearances[:, 0], middle], 1), np.stack([middle, clearances[:, 1]], 1)])
    return _named(own, robot, closest, min(lowest, float(bound.min(initial=math.inf))), looked_at)


def _standing(own: OwnBody, robot: Robot, vertices: Array) -> OwnClearance:
    """Of an arm that stands still, or has no two links that could touch."""
    value, pair = own.closest(vertices)
    (row,) = first_smallest(value)
    return _named(own, robot, _Closest(float(value.min()), row, int(pair[row]), vertices[row]), math.inf, 0)


def _named(own: OwnBody, robot: Robot, closest: _Closest, lowest: float, looked_at: int) -> OwnClearance:
    """What is proven, with the links that come closest if they come close at all."""
    value = min(closest.clearance, lowest, own.horizon) if closest.clearance > 0.0 else closest.clearance
    if closest.clearance >= own.horizon:
        return OwnClearance(value, own.horizon, halvings=looked_at)
    chords = own.names(closest.pair)
    x, y, z = own.apart(closest.body, *chords)[1].tolist()
    first, second = (MOUNT if chord == MOUNT else int(robot.chord_sections[chord]) for chord in chords)
    return OwnClearance(value, own.horizon, closest.step, (first, second), (x, y, z), looked_at)
