"""How far a body is from the path in the mean, with its exact first and second derivatives by the angles.

An angle a turns what is behind its section rigidly: a point X moves by ω_a × X + ν_a. So what the samples behind a
section contribute to the second derivatives is one 6 x 6 matrix, as a rigid body's mass is, and sums go from the tip to
the base in time proportional to n² and to the number of samples. With v from the nearest path point to the sample, t
the tangent and κ the curvature there,

    ∂v·∂v + v·∂²v = J_a·(1 - t tᵀ/(1 - κ·v)) J_b + v·∂²X ,   ∂²X/∂a∂b = ω_a × J_b for a before b.

Derivation: docs/following.md.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.following.samples import AHEAD, BEND, FEET_ROWS, OFF, Body, foot, section_passed
from hognose.kernels import kernel
from hognose.path.polynomial import Pieces
from hognose.robot.sections.chain import BY_ALPHA, END, ROWS, TURN_ALPHA, frame_after

#: Ends (n+1, 3) m from the base, frames (n+1, 3, 3) with axes in rows, twists (2n, 6) of the angles, the sections as of
#: `end_of` (3, n, ROWS, 3) and samples (3, q, 3, 3), each at the angles and a little beside in α and in β.
Chain = tuple[NDArray, NDArray, NDArray, NDArray, NDArray]
#: The gradient (2n,), second derivatives (2n, 2n) in the lower half, and of the tip what must vanish (2,) m, how it
#: changes (2, 2n), and the two directions (2, 3) across the path.
Model = tuple[NDArray, NDArray, NDArray, NDArray, NDArray]

#: How far beside (rad): what is differenced is multiplied by distances to the path.
_BESIDE = 1e-7


@kernel(fastmath={"contract"})
def seen(frame: NDArray, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector in a frame's axes, seen from outside."""
    return (
        x * frame[0, 0] + y * frame[1, 0] + z * frame[2, 0],
        x * frame[0, 1] + y * frame[1, 1] + z * frame[2, 1],
        x * frame[0, 2] + y * frame[1, 2] + z * frame[2, 2],
    )


@kernel(fastmath={"contract"})
def _power(twists: NDArray, a: int, force: NDArray, b: int) -> float:
    total = 0.0
    for k in range(6):
        total += twists[a, k] * force[b, k]
    return total


@kernel(fastmath={"contract"})
def laid(body: Body, angles: NDArray, second: bool, chain: Chain) -> None:
    """Fill `chain` for angles (n, 2) from the frame that stands in its first place."""
    ends, frames, twists, sections, points = chain
    work = np.empty((ROWS, 3))
    ends[0] = 0.0
    for i in range(angles.shape[0]):
        alpha, beta = angles[i, 0], angles[i, 1]
        section_passed(body, i, alpha, beta, sections[0, i], points[0], work)
        if second:
            section_passed(body, i, alpha + _BESIDE, beta, sections[1, i], points[1], work)
            section_passed(body, i, alpha, beta + _BESIDE, sections[2, i], points[2], work)
        frame, out = frames[i + 1], sections[0, i]
        frame[:] = frames[i]
        x, y, z = seen(frame, out[END, 0], out[END, 1], out[END, 2])
        x, y, z = x + ends[i, 0], y + ends[i, 1], z + ends[i, 2]
        ends[i + 1, 0], ends[i + 1, 1], ends[i + 1, 2] = x, y, z
        for b in range(2):
            a, turn, by = 2 * i + b, TURN_ALPHA + b, BY_ALPHA + b
            ox, oy, oz = seen(frame, out[turn, 0], out[turn, 1], out[turn, 2])
            vx, vy, vz = seen(frame, out[by, 0], out[by, 1], out[by, 2])
            twists[a, 0], twists[a, 1], twists[a, 2] = ox, oy, oz
            twists[a, 3], twists[a, 4], twists[a, 5] = vx - oy * z + oz * y, vy - oz * x + ox * z, vz - ox * y + oy * x
        frame_after(frame, out)


@kernel(fastmath={"contract"})
def _stiffened(
    mass: NDArray, x: float, y: float, z: float, tx: float, ty: float, tz: float, along: float, lever: NDArray
) -> None:
    """Subtract along t tᵀ at a place from the 6 x 6 matrix `mass`, its upper half."""
    lever[0], lever[1], lever[2] = y * tz - z * ty, z * tx - x * tz, x * ty - y * tx
    lever[3], lever[4], lever[5] = tx, ty, tz
    for k in range(6):
        part = along * lever[k]
        for m in range(k, 6):
            mass[k, m] -= part * lever[m]


@kernel(fastmath={"contract"})
def _weighed(mass: NDArray, x: float, y: float, z: float, weight: float) -> None:
    """Add a weight at a place to the 6 x 6 matrix `mass`, its upper half."""
    wx, wy, wz = weight * x, weight * y, weight * z
    mass[0, 0] += wy * y + wz * z
    mass[1, 1] += wx * x + wz * z
    mass[2, 2] += wx * x + wy * y
    mass[0, 1] -= wx * y
    mass[0, 2] -= wx * z
    mass[1, 2] -= wy * z
    mass[0, 4] -= wz
    mass[0, 5] += wy
    mass[1, 3] += wz
    mass[1, 5] -= wx
    mass[2, 3] -= wy
    mass[2, 4] += wx
    for k in range(3, 6):
        mass[k, k] += weight


@kernel(fastmath={"contract"})
def _pushed(mass: NDArray, twists: NDArray, a: int, force: NDArray, b: int) -> None:
    """Row b of `force` is `mass` times twist a."""
    for k in range(6):
        total = 0.0
        for m in range(6):
            total += (mass[k, m] if m >= k else mass[m, k]) * twists[a, m]
        force[b, k] = total


@kernel(fastmath={"contract"})
def _tip(pieces: Pieces, origin: NDArray, feet: NDArray, chain: Chain, model: Model, found: NDArray) -> None:
    """What must vanish of the tip, its change with the angles, and how it lies on the path (FEET_ROWS, 3)."""
    ends, _, twists, _, _ = chain
    _, _, apart, rates, across = model
    x, y, z = ends[-1, 0], ends[-1, 1], ends[-1, 2]
    feet[-1] = foot(pieces, feet[-1], origin[0] + x, origin[1] + y, origin[2] + z, found)
    tx, ty, tz = found[AHEAD, 0], found[AHEAD, 1], found[AHEAD, 2]
    least = 0
    for k in range(1, 3):
        if abs(found[AHEAD, k]) < abs(found[AHEAD, least]):
            least = k
    size = math.sqrt(1.0 - found[AHEAD, least] ** 2)
    for k in range(3):
        across[0, k] = ((1.0 if k == least else 0.0) - found[AHEAD, least] * found[AHEAD, k]) / size
    ux, uy, uz = across[0, 0], across[0, 1], across[0, 2]
    across[1, 0], across[1, 1], across[1, 2] = ty * uz - tz * uy, tz * ux - tx * uz, tx * uy - ty * ux
    for m in range(2):
        ux, uy, uz = across[m, 0], across[m, 1], across[m, 2]
        apart[m] = ux * found[OFF, 0] + uy * found[OFF, 1] + uz * found[OFF, 2]
        lx, ly, lz = y * uz - z * uy, z * ux - x * uz, x * uy - y * ux
        for a in range(twists.shape[0]):
            rates[m, a] = twists[a, 0] * lx + twists[a, 1] * ly + twists[a, 2] * lz
            rates[m, a] += twists[a, 3] * ux + twists[a, 4] * uy + twists[a, 5] * uz


@kernel(fastmath={"contract"})
def _bent_behind(chain: Chain, i: int, push: NDArray, spread: NDArray, frame: NDArray, out: NDArray) -> None:
    """Add v·∂²X of all that is behind section i, by its own two angles, to `out` (3,): αα, αβ, ββ.

    `push` is Σ w v and `spread` is Σ w v Xᵀ of what is behind.
    """
    ends, _, twists, sections, _ = chain
    about = np.empty((3, 3))
    for k in range(3):
        for m in range(3):
            about[k, m] = spread[k, m] - push[k] * ends[i + 1, m]
    trace = about[0, 0] + about[1, 1] + about[2, 2]
    turning = (about[2, 1] - about[1, 2], about[0, 2] - about[2, 0], about[1, 0] - about[0, 1])
    for each in range(3):
        a, b = (0 if each < 2 else 1), (0 if each == 0 else 1)
        beside, here, turn, by = sections[1 + a, i], sections[0, i], TURN_ALPHA + b, BY_ALPHA + b
        total = 0.0
        for k in range(3):
            total -= trace * twists[2 * i + a, k] * twists[2 * i + b, k]
            for m in range(3):
                total += twists[2 * i + a, k] * about[k, m] * twists[2 * i + b, m]
        x, y, z = seen(
            frame, beside[turn, 0] - here[turn, 0], beside[turn, 1] - here[turn, 1], beside[turn, 2] - here[turn, 2]
        )
        changed = x * turning[0] + y * turning[1] + z * turning[2]
        x, y, z = seen(frame, beside[by, 0] - here[by, 0], beside[by, 1] - here[by, 1], beside[by, 2] - here[by, 2])
        out[each] += total + (changed + x * push[0] + y * push[1] + z * push[2]) / _BESIDE


@kernel(fastmath={"contract"})
def _own(
    pieces: Pieces,
    body: Body,
    i: int,
    origin: NDArray,
    feet: NDArray,
    second: bool,
    chain: Chain,
    sums: tuple[NDArray, NDArray, NDArray, NDArray],
    slope: NDArray,
    pair: NDArray,
    force: NDArray,
) -> float:
    """Add what section i's samples contribute: to its slope (2,), its second derivatives (3,) and forces (2, 6).

    And, for the sections before, to the sums of `assembled`. Returns their part of the cost.
    """
    ends, frames, _, _, points = chain
    begins, weights, farther = body[2], body[5], body[6]
    mass, wrench, push, spread = sums
    frame, found = frames[i], np.empty((FEET_ROWS, 3))
    by, lever, cost = np.empty((2, 6)), np.empty(6), 0.0
    for j in range(begins[i], begins[i + 1]):
        x, y, z = seen(frame, points[0, j, 0, 0], points[0, j, 0, 1], points[0, j, 0, 2])
        x, y, z = x + ends[i, 0], y + ends[i, 1], z + ends[i, 2]
        feet[j] = foot(pieces, feet[j], origin[0] + x, origin[1] + y, origin[2] + z, found)
        vx, vy, vz = found[OFF, 0], found[OFF, 1], found[OFF, 2]
        tx, ty, tz = found[AHEAD, 0], found[AHEAD, 1], found[AHEAD, 2]
        half = 0.5 * (vx * vx + vy * vy + vz * vz)
        weight, steep = weights[j] * (1.0 + half * farther), weights[j] * farther
        cost += weights[j] * half * (1.0 + 0.5 * half * farther)
        room = 1.0 - found[BEND, 0] * vx - found[BEND, 1] * vy - found[BEND, 2] * vz
        along = weight / room if second and room > 0.1 else weight
        for b in range(2):
            bx, by_, bz = seen(frame, points[0, j, 1 + b, 0], points[0, j, 1 + b, 1], points[0, j, 1 + b, 2])
            beside = bx * vx + by_ * vy + bz * vz
            slope[b] += weight * beside
            part, beside = along * (bx * tx + by_ * ty + bz * tz), steep * beside
            px = weight * bx - part * tx + beside * vx
            py = weight * by_ - part * ty + beside * vy
            pz = weight * bz - part * tz + beside * vz
            by[b, 0], by[b, 1], by[b, 2], by[b, 3], by[b, 4], by[b, 5] = bx, by_, bz, px, py, pz
            # What turns the sections before as well goes with the place that it acts on, and with v.
            turned = weight if second else 0.0
            force[b, 0] += y * pz - z * py + turned * (by_ * vz - bz * vy)
            force[b, 1] += z * px - x * pz + turned * (bz * vx - bx * vz)
            force[b, 2] += x * py - y * px + turned * (bx * vy - by_ * vx)
            force[b, 3] += px
            force[b, 4] += py
            force[b, 5] += pz
        for k in range(3):
            pair[0] += by[0, k] * by[0, 3 + k]
            pair[1] += by[0, k] * by[1, 3 + k]
            pair[2] += by[1, k] * by[1, 3 + k]
        if second:
            own = weight / _BESIDE
            ux, uy, uz = (
                vx * frame[0, 0] + vy * frame[0, 1] + vz * frame[0, 2],
                vx * frame[1, 0] + vy * frame[1, 1] + vz * frame[1, 2],
                vx * frame[2, 0] + vy * frame[2, 1] + vz * frame[2, 2],
            )
            for each in range(3):
                a, b = (1 if each < 2 else 2), (1 if each == 0 else 2)
                pair[each] += own * (
                    ux * (points[a, j, b, 0] - points[0, j, b, 0])
                    + uy * (points[a, j, b, 1] - points[0, j, b, 1])
                    + uz * (points[a, j, b, 2] - points[0, j, b, 2])
                )
            place, off = (x, y, z), (weight * vx, weight * vy, weight * vz)
            for k in range(3):
                push[k] += off[k]
                for m in range(3):
                    spread[k, m] += off[k] * place[m]
        _weighed(mass, x, y, z, weight)
        _stiffened(mass, x, y, z, tx, ty, tz, along, lever)
        _stiffened(mass, x, y, z, vx, vy, vz, -steep, lever)
        wrench[0, 0] += weight * (y * vz - z * vy)
        wrench[0, 1] += weight * (z * vx - x * vz)
        wrench[0, 2] += weight * (x * vy - y * vx)
        wrench[0, 3] += weight * vx
        wrench[0, 4] += weight * vy
        wrench[0, 5] += weight * vz
    return cost


@kernel(fastmath={"contract"})
def assembled(
    pieces: Pieces,
    body: Body,
    origin: NDArray,
    pull: NDArray,
    feet: NDArray,
    second: bool,
    chain: Chain,
    model: Model,
) -> float:
    """Fill `model` of a chain that is laid, and move the feet (q+1,) along; returns the cost (m²).

    `pull` (3,) is the multiplier of the tip's condition. Without `second` what distances multiply is left out, so that
    the second derivatives are at least zero.
    """
    _, frames, twists, _, _ = chain
    gradient, square = model[0], model[1]
    mass, wrench, push, spread = np.zeros((6, 6)), np.zeros((1, 6)), np.zeros(3), np.zeros((3, 3))
    force, pair, found, tip = np.empty((2, 6)), np.empty(3), np.empty((FEET_ROWS, 3)), chain[0][-1]
    _tip(pieces, origin, feet, chain, model, found)
    if second:
        along = pull[0] * found[BEND, 0] + pull[1] * found[BEND, 1] + pull[2] * found[BEND, 2]
        tx, ty, tz = found[AHEAD, 0], found[AHEAD, 1], found[AHEAD, 2]
        _stiffened(mass, tip[0], tip[1], tip[2], tx, ty, tz, along, np.empty(6))
        for k in range(3):
            push[k] = pull[k]
            for m in range(3):
                spread[k, m] = pull[k] * tip[m]
    cost = 0.0
    for i in range(frames.shape[0] - 2, -1, -1):
        low = 2 * i
        for b in range(2):
            _pushed(mass, twists, low + b, force, b)
            gradient[low + b] = _power(twists, low + b, wrench, 0)
        pair[0], pair[1] = _power(twists, low, force, 0), _power(twists, low, force, 1)
        pair[2] = _power(twists, low + 1, force, 1)
        if second:
            _bent_behind(chain, i, push, spread, frames[i], pair)
            trace = spread[0, 0] + spread[1, 1] + spread[2, 2]
            for b in range(2):
                twist = twists[low + b]
                for k in range(3):
                    m, o = (k + 1) % 3, (k + 2) % 3
                    force[b, k] += twist[3 + m] * push[o] - twist[3 + o] * push[m] - trace * twist[k]
                    for m in range(3):
                        force[b, k] += spread[m, k] * twist[m]
        sums = (mass, wrench, push, spread)
        cost += _own(pieces, body, i, origin, feet, second, chain, sums, gradient[low : low + 2], pair, force)
        square[low, low], square[low + 1, low], square[low + 1, low + 1] = pair[0], pair[1], pair[2]
        for b in range(2):
            for a in range(low):
                square[low + b, a] = _power(twists, a, force, b)
    return cost
