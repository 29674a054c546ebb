"""How far a body is from the path in the mean, by the lengths of sections that extend: the rest of `fit_model`.

A single arc of length L is L times one of length 1. So a sample X of it moves by X/L, measured from where the section
begins, what is behind moves by the section's whole chord over L without turning, and

    ∂²X/∂L² = 0 ,   ∂²X/∂L∂a = ω_a × ∂X/∂L  for an angle a before,   (∂X/∂a)/L  for one of its own,   0  for one behind.

Lengths are counted in parts of a mean section from those at rest, so that they compare with angles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.following.fit_model import Chain, Model, seen
from hognose.following.samples import AHEAD, BEND, FEET_ROWS, OFF, Body, foot
from hognose.kernels import kernel
from hognose.path.polynomial import Pieces
from hognose.robot.bends import CLOSED
from hognose.robot.sections import MixedSections
from hognose.robot.sections.chain import BY_ALPHA, END

Array = NDArray[np.float64]

#: Of the sections that extend (e,): which they are, their row of the pieces, their lengths (m) at rest, the lowest and
#: highest part (e, 2), what a part of 1 is (m), and what ties the sum of all parts to 0, m².
Stretch = tuple[NDArray, NDArray, NDArray, NDArray, float, float]

#: What ties each length to that at rest, where it is free, and all together to the arm's, in squares of a mean section.
#: With less of the first, lengths go from end to end of their range for little. The second keeps the arm from following
#: better by being short, with its tip behind.
_TIE, _TIE_OF_ALL = 0.3, 100.0
#: A length may be beyond its range by this (m) where it is at rest at an end of it.
_BEYOND = 1e-10


def stretch_of(model: MixedSections, in_front: int) -> tuple[Stretch, Array]:
    """What `lengthened` needs of an arm with so many sections in front of its own, and what ties (e,) m² each part."""
    which = np.flatnonzero(model.extends)
    unit = float(model.table[:, 2].sum()) / len(model.sections)
    rests = np.array([model.sections[i].pitch for i in which])
    bounds = np.array([model.sections[i].lengths for i in which]).reshape(-1, 2)
    parts = (bounds - rests[:, None]) / unit
    # As sides of angles that are closed, but no length goes beyond its range by as much as checks allow.
    open_by = min(CLOSED, _BEYOND / unit)
    parts = np.stack([np.minimum(parts[:, 0], -open_by), np.maximum(parts[:, 1], open_by)], axis=1)
    stretch = (which + in_front, model.first[:-1][which] + in_front, rests, parts, unit, _TIE_OF_ALL * unit**2)
    return stretch, np.full(len(which), _TIE * unit**2)


@kernel(fastmath={"contract"})
def lengths_set(body: Body, stretch: Stretch, parts: NDArray) -> None:
    """Make the sections of the body as long as parts (e,) say."""
    _, rows, rests, _, unit, _ = stretch
    for e in range(rows.size):
        body[0][rows[e], 2] = rests[e] + unit * parts[e]


@kernel(fastmath={"contract"})
def _gone(chain: Chain, section: int, j: int, a: int, x: float, y: float, z: float, out: NDArray) -> None:
    """How a sample at (x, y, z), the j-th, of a section moves with angle a of it or of one before, into `out` (3,)."""
    twists = chain[2]
    if a // 2 == section:
        by = chain[4][0, j, 1 + a % 2]
        out[0], out[1], out[2] = seen(chain[1][section], by[0], by[1], by[2])
        return
    out[0] = twists[a, 1] * z - twists[a, 2] * y + twists[a, 3]
    out[1] = twists[a, 2] * x - twists[a, 0] * z + twists[a, 4]
    out[2] = twists[a, 0] * y - twists[a, 1] * x + twists[a, 5]


@kernel(fastmath={"contract"})
def _longer(chain: Chain, stretch: Stretch, lengths: NDArray, section: int, j: int, e: int, out: NDArray) -> bool:
    """As `_gone`, with the length of the e-th section that extends; False if it does not move."""
    owner, unit = stretch[0][e], stretch[4]
    if owner > section:
        return False
    place = chain[4][0, j, 0] if owner == section else chain[3][0, owner, END]
    part = unit / lengths[e]
    x, y, z = seen(chain[1][owner], place[0], place[1], place[2])
    out[0], out[1], out[2] = part * x, part * y, part * z
    return True


@kernel(fastmath={"contract"})
def _turned(
    chain: Chain, stretch: Stretch, lengths: NDArray, section: int, j: int, e: int, a: int, by: NDArray, off: NDArray
) -> float:
    """v·∂²X of a sample by the length of the e-th section that extends and angle a; `by` (3,) is ∂X by the length."""
    owner, of_angle, twists = stretch[0][e], a // 2, chain[2]
    if of_angle > owner:
        return 0.0
    if of_angle == owner:
        change = chain[4][0, j, 1 + a % 2] if owner == section else chain[3][0, owner, BY_ALPHA + a % 2]
        x, y, z = seen(chain[1][owner], change[0], change[1], change[2])
        return stretch[4] / lengths[e] * (x * off[0] + y * off[1] + z * off[2])
    wx, wy, wz = twists[a, 0], twists[a, 1], twists[a, 2]
    return off[0] * (wy * by[2] - wz * by[1]) + off[1] * (wz * by[0] - wx * by[2]) + off[2] * (wx * by[1] - wy * by[0])


@kernel(fastmath={"contract"})
def lengthened(
    pieces: Pieces,
    body: Body,
    stretch: Stretch,
    parts: NDArray,
    origin: NDArray,
    pull: NDArray,
    feet: NDArray,
    second: bool,
    chain: Chain,
    model: Model,
) -> None:
    """Fill the rows of the lengths, behind those of the angles, of a model that `assembled` has filled for the same."""
    ends, frames, twists, _, points = chain
    gradient, square, _, rates, across = model
    begins, weights, farther = body[2], body[5], body[6]
    sections, size, count = frames.shape[0] - 1, twists.shape[0], parts.size
    lengths, found, off = np.empty(count), np.empty((FEET_ROWS, 3)), np.empty(3)
    moves, pushed = np.empty((size + count, 3)), np.empty(3)
    for e in range(count):
        lengths[e] = body[0][stretch[1][e], 2]
        gradient[size + e] = 0.0
        square[size + e] = 0.0
    # The tip is one more sample, behind all sections, whose v is the multiplier of its condition.
    for section in range(sections + 1):
        low, high = (begins[section], begins[section + 1]) if section < sections else (feet.size - 1, feet.size)
        for j in range(low, high):
            tip = section == sections
            x, y, z = ends[-1, 0], ends[-1, 1], ends[-1, 2]
            if not tip:
                x, y, z = seen(frames[section], points[0, j, 0, 0], points[0, j, 0, 1], points[0, j, 0, 2])
                x, y, z = x + ends[section, 0], y + ends[section, 1], z + ends[section, 2]
            foot(pieces, feet[j], origin[0] + x, origin[1] + y, origin[2] + z, found)
            weight, steep, along = 0.0, 0.0, 0.0
            if tip:
                for k in range(3):
                    off[k] = pull[k] if second else 0.0
                    along += off[k] * found[BEND, k]
            else:
                half, room = 0.0, 1.0
                for k in range(3):
                    half += 0.5 * found[OFF, k] * found[OFF, k]
                    room -= found[BEND, k] * found[OFF, k]
                weight, steep = weights[j] * (1.0 + half * farther), weights[j] * farther
                along = weight / room if second and room > 0.1 else weight
                for k in range(3):
                    off[k] = weight * found[OFF, k]
            # What is behind a sample does not move it: so many angles and lengths do.
            bent, longer = min(2 * section + 2, size), 0
            for a in range(bent):
                _gone(chain, section, j, a, x, y, z, moves[a])
            while longer < count and _longer(chain, stretch, lengths, section, j, longer, moves[size + longer]):
                longer += 1
            for e in range(longer):
                by = moves[size + e]
                ahead, beside = 0.0, 0.0
                for k in range(3):
                    ahead += along * by[k] * found[AHEAD, k]
                    beside += steep * by[k] * found[OFF, k]
                for k in range(3):
                    pushed[k] = weight * by[k] - ahead * found[AHEAD, k] + beside * found[OFF, k]
                    if not tip:
                        gradient[size + e] += by[k] * off[k]
                for a in range(bent):
                    if second and a < 2 * stretch[0][e] + 2:
                        square[size + e, a] += _turned(chain, stretch, lengths, section, j, e, a, by, off)
                    square[size + e, a] += moves[a, 0] * pushed[0] + moves[a, 1] * pushed[1] + moves[a, 2] * pushed[2]
                for a in range(size, size + e + 1):
                    square[size + e, a] += moves[a, 0] * pushed[0] + moves[a, 1] * pushed[1] + moves[a, 2] * pushed[2]
                if tip:
                    for m in range(2):
                        rates[m, size + e] = across[m, 0] * by[0] + across[m, 1] * by[1] + across[m, 2] * by[2]
    total = 0.0
    for e in range(count):
        total += parts[e]
    for e in range(count):
        gradient[size + e] += stretch[5] * total
        for other_e in range(e + 1):
            square[size + e, size + other_e] += stretch[5]
