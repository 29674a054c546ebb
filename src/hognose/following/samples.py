"""Places along the body of an arm with sections of any kinds, how they move with its angles, and how far off they are.

They are Gauss points of the pieces, so that their weighted sums are integrals along the body.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.path.polynomial import Pieces, evaluate, segment_at
from hognose.robot.sections import MixedSections
from hognose.robot.sections.chain import BY_ALPHA, BY_BETA, END, ROWS, X, Y, Z, moved, passed

#: Pieces (p, 4) and where each section's begin (n+1,); of the samples, where each section's begin (n+1,), their
#: piece (q,), the part of it (q,) at which they are, and their weights (q,); and s, 1/m², of the cost q + s q²/2 of
#: half a squared distance q. A free base is two more sections in front, see `with_free_base`.
Body = tuple[NDArray, NDArray, NDArray, NDArray, NDArray, NDArray, float]

#: The body has about so many samples on curved pieces; each has at least, and at most, so many.
_WANTED, _LEAST, _MOST = 48, 4, 16
#: Samples of a straight piece, if it is a whole section, and if it is not.
_OF_LINK, _OF_JOINT = 3, 2
#: Newton's method for the nearest point ends with a step (m) so small, or after so many.
_NEAR, _STEPS = 1e-9, 20

#: Weight of the first section, whose direction is the base's and not free; that of the others is 1.
_FIRST = 2.5
#: The distance, in mean section lengths, beyond which its fourth power counts more than its square.
_FAR = 1 / 300

#: What marks a piece that does not bend but slides across: its end is (α, β) times its shares (m) beside its beginning.
_SLIDES = -1.0
#: Sections that stand for a free base: one that slides across the path, and an arc without length that turns.
BASE_SECTIONS = 2

#: Rows of what `foot` finds: from the path to the point, across it; the tangent; the curvature; the place.
OFF, AHEAD, BEND, FEET_ROWS = 0, 1, 2, 3


def sampled(model: MixedSections) -> Body:
    """The samples of an arm."""
    table, first = model.table, model.first
    curved = max(int((table[:, 3] != 0.0).sum()), 1)
    dense = min(max(math.ceil(_WANTED / curved), _LEAST), _MOST)
    alone = np.repeat(np.diff(first) == 1, np.diff(first))
    counts = np.where(table[:, 3] != 0.0, dense, np.where(alone, _OF_LINK, _OF_JOINT))
    rules = [np.polynomial.legendre.leggauss(count) for count in counts.tolist()]
    parts = np.concatenate([0.5 * (1.0 + places) for places, _ in rules])
    weights = np.concatenate([0.5 * length * rule[1] for length, rule in zip(table[:, 2], rules, strict=True)])
    begins = np.concatenate([[0], np.cumsum(counts)])[first]
    weights /= table[:, 2].sum()
    weights[: begins[1]] *= _FIRST
    far = _FAR * float(table[:, 2].sum()) / len(begins[1:])
    return table, first, begins, np.repeat(np.arange(len(table)), counts), parts, weights, 1.0 / far**2


def with_free_base(body: Body) -> Body:
    """The samples of an arm whose base is free: the base's place across the path and its direction are angles as well.

    They are those of two sections in front of all others, without samples: the first slides across the path, by a mean
    section's length for each rad, the second turns the shortest way. The arm's first section is as free as all others.
    Where its own first joint does what a turn of the base does, as in a link and nearly so in two hinges, the base does
    not turn.
    """
    table, first, begins, pieces, parts, weights, farther = body
    length = float(table[:, 2].sum()) / (len(first) - 1)
    own = table[: first[1]]
    turns = own[:, 3].any() or (np.count_nonzero(own[:, :2], axis=0) > 1).all()
    front = np.array([[length, length, 0.0, _SLIDES], [float(turns), float(turns), 0.0, 1.0]])
    weights = weights.copy()
    weights[: begins[1]] /= _FIRST
    return (
        np.concatenate([front, table]),
        np.concatenate([np.arange(BASE_SECTIONS), first + BASE_SECTIONS]),
        np.concatenate([np.zeros(BASE_SECTIONS, begins.dtype), begins]),
        pieces + BASE_SECTIONS,
        parts,
        weights,
        farther,
    )


@kernel(fastmath={"contract"})
def section_passed(body: Body, i: int, alpha: float, beta: float, out: NDArray, points: NDArray, work: NDArray) -> None:
    """As `end_of` for section i, and its samples' places and their derivatives by α and β, (q, 3, 3), into `points`."""
    table, first, begins, pieces, parts, _, _ = body
    out[:ROWS] = 0.0
    out[X, 0], out[Y, 1], out[Z, 2] = 1.0, 1.0, 1.0
    j = begins[i]
    for p in range(first[i], first[i + 1]):
        sa, sb, length, curved = table[p, 0], table[p, 1], table[p, 2], table[p, 3] != 0.0
        if table[p, 3] == _SLIDES:
            moved(out, END, sa * alpha, sb * beta, 0.0)
            moved(out, BY_ALPHA, sa, 0.0, 0.0)
            moved(out, BY_BETA, 0.0, sb, 0.0)
            continue
        while j < begins[i + 1] and pieces[j] == p:
            part = parts[j]
            for row in range(ROWS):
                for k in range(3):
                    work[row, k] = out[row, k]
            turned = part if curved else 1.0
            passed(turned * sa, turned * sb, part * length, curved, alpha, beta, work)
            for k in range(3):
                points[j, 0, k] = work[END, k]
                points[j, 1, k] = work[BY_ALPHA, k]
                points[j, 2, k] = work[BY_BETA, k]
            j += 1
        passed(sa, sb, length, curved, alpha, beta, out)


@kernel(fastmath={"contract"})
def foot(pieces: Pieces, guess: float, x: float, y: float, z: float, out: NDArray) -> float:
    """The parameter near a guess at which the path is closest to a point; `out` (FEET_ROWS, 3) says how it lies."""
    breaks, coefficients = pieces
    u, last = guess, coefficients.shape[0] - 1
    segment, count = segment_at(breaks, u), 0
    while True:
        while segment < last and u >= breaks[segment + 1]:
            segment += 1
        while segment > 0 and u < breaks[segment]:
            segment -= 1
        px, py, pz, vx, vy, vz, ax, ay, az = evaluate(coefficients, segment, u - breaks[segment])
        dx, dy, dz = x - px, y - py, z - pz
        square = vx * vx + vy * vy + vz * vz
        steep = square - 2.0 * (dx * ax + dy * ay + dz * az)
        step = (dx * vx + dy * vy + dz * vz) / (steep if steep > 0.1 * square else square)
        u = min(max(u + step, breaks[0]), breaks[-1])
        count += 1
        if step * step * square < _NEAR * _NEAR or count == _STEPS:
            break
    speed = math.sqrt(square)
    tx, ty, tz = vx / speed, vy / speed, vz / speed
    # With the nearest point a step away, what is across the tangent there is across the one here but for its square.
    bend = 2.0 * (ax * tx + ay * ty + az * tz)
    along = dx * tx + dy * ty + dz * tz
    out[OFF, 0], out[OFF, 1], out[OFF, 2] = dx - along * tx, dy - along * ty, dz - along * tz
    out[AHEAD, 0], out[AHEAD, 1], out[AHEAD, 2] = tx, ty, tz
    out[BEND, 0] = (2.0 * ax - bend * tx) / square
    out[BEND, 1] = (2.0 * ay - bend * ty) / square
    out[BEND, 2] = (2.0 * az - bend * tz) / square
    return u
