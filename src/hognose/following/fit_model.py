"""Half the mean squared distance of a body to the path, with its exact first and second derivatives by the angles.

An angle a turns what is behind its section rigidly: a point X moves by ω_a × X + ν_a. So what the samples behind a
section contribute to the second derivatives is one 6 x 6 matrix, as a rigid body's mass is, and sums go from the tip to
the base in time proportional to n² and to the number of samples. With v from the nearest path point to the sample, t
the tangent and κ the curvature there,

    ∂v·∂v + v·∂²v = J_a·(1 - t tᵀ/(1 - κ·v)) J_b + v·∂²X ,   ∂²X/∂a∂b = ω_a × J_b for a before b.

Derivation: docs/following.md.
"""

from __future__ import annotations

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


@kernel(inline="always")
def _outer(frame: NDArray, row: NDArray, out: NDArray) -> None:
    """A vector seen from outside, of one in a frame's axes."""
    for k in range(3):
        out[k] = row[0] * frame[0, k] + row[1] * frame[1, k] + row[2] * frame[2, k]


@kernel(inline="always")
def _cross(a: NDArray, b: NDArray, out: NDArray) -> None:
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@kernel(inline="always")
def _dot(a: NDArray, b: NDArray) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel(inline="always")
def _power(twist: NDArray, force: NDArray) -> float:
    return _dot(twist[:3], force[:3]) + _dot(twist[3:], force[3:])


@kernel(fastmath={"contract"})
def laid(body: Body, angles: NDArray, second: bool, chain: Chain) -> None:
    """Fill `chain` for angles (n, 2) from the frame that stands in its first place."""
    ends, frames, twists, sections, points = chain
    work, vector = np.empty((ROWS, 3)), np.empty(3)
    ends[0] = 0.0
    for i in range(angles.shape[0]):
        alpha, beta = angles[i, 0], angles[i, 1]
        section_passed(body, i, alpha, beta, sections[0, i], points[0], work)
        if second:
            section_passed(body, i, alpha + _BESIDE, beta, sections[1, i], points[1], work)
            section_passed(body, i, alpha, beta + _BESIDE, sections[2, i], points[2], work)
        frame = frames[i + 1]
        frame[:] = frames[i]
        _outer(frame, sections[0, i, END], vector)
        ends[i + 1] = ends[i] + vector
        for b in range(2):
            twist = twists[2 * i + b]
            _outer(frame, sections[0, i, TURN_ALPHA + b], twist[:3])
            _outer(frame, sections[0, i, BY_ALPHA + b], twist[3:])
            _cross(twist[:3], ends[i + 1], vector)
            twist[3:] -= vector
        frame_after(frame, sections[0, i])


@kernel(fastmath={"contract"})
def _weigh(mass: NDArray, place: NDArray, ahead: NDArray, weight: float, along: float) -> None:
    """Add weight - along t tᵀ at a place to the 6 x 6 matrix `mass`."""
    lever = np.empty(3)
    _cross(place, ahead, lever)
    square = weight * _dot(place, place)
    for k in range(3):
        for m in range(3):
            mass[k, m] -= weight * place[k] * place[m] + along * lever[k] * lever[m]
            mass[k, 3 + m] -= along * lever[k] * ahead[m]
            mass[3 + k, 3 + m] -= along * ahead[k] * ahead[m]
        mass[k, k] += square
        mass[3 + k, 3 + k] += weight
    mass[0, 4] -= weight * place[2]
    mass[0, 5] += weight * place[1]
    mass[1, 3] += weight * place[2]
    mass[1, 5] -= weight * place[0]
    mass[2, 3] -= weight * place[1]
    mass[2, 4] += weight * place[0]


@kernel(fastmath={"contract"})
def _pushed(mass: NDArray, twist: NDArray, out: NDArray) -> None:
    """`mass` times a twist."""
    for k in range(3):
        out[k], out[3 + k] = 0.0, 0.0
        for m in range(3):
            out[k] += mass[k, m] * twist[m] + mass[k, 3 + m] * twist[3 + m]
            out[3 + k] += mass[m, 3 + k] * twist[m] + mass[3 + k, 3 + m] * twist[3 + m]


@kernel(fastmath={"contract"})
def _tip(pieces: Pieces, origin: NDArray, feet: NDArray, chain: Chain, model: Model, found: NDArray) -> None:
    """What must vanish of the tip, its change with the angles, and how it lies on the path (FEET_ROWS, 3)."""
    ends, _, twists, _, _ = chain
    _, _, apart, rates, across = model
    tip, lever = ends[-1], np.empty(3)
    feet[-1] = foot(pieces, feet[-1], origin[0] + tip[0], origin[1] + tip[1], origin[2] + tip[2], found)
    ahead = found[AHEAD]
    least = 0
    for k in range(1, 3):
        if abs(ahead[k]) < abs(ahead[least]):
            least = k
    for k in range(3):
        across[0, k] = (1.0 if k == least else 0.0) - ahead[least] * ahead[k]
    across[0] /= np.sqrt(_dot(across[0], across[0]))
    _cross(ahead, across[0], across[1])
    for m in range(2):
        apart[m] = _dot(across[m], found[OFF])
        _cross(tip, across[m], lever)
        for a in range(twists.shape[0]):
            rates[m, a] = _dot(twists[a, :3], lever) + _dot(twists[a, 3:], across[m])


@kernel(fastmath={"contract"})
def _bent_behind(
    chain: Chain, i: int, push: NDArray, spread: NDArray, frame: NDArray, out: NDArray
) -> None:
    """Add v·∂²X of all that is behind section i, by its own two angles, to `out` (3,): αα, αβ, ββ.

    `push` is Σ w v and `spread` is Σ w v Xᵀ of what is behind.
    """
    ends, _, twists, sections, _ = chain
    about, vector = np.empty((3, 3)), np.empty(3)
    for k in range(3):
        for m in range(3):
            about[k, m] = spread[k, m] - push[k] * ends[i + 1, m]
    trace = about[0, 0] + about[1, 1] + about[2, 2]
    turning = np.array([about[2, 1] - about[1, 2], about[0, 2] - about[2, 0], about[1, 0] - about[0, 1]])
    for each in range(3):
        a, b = (0 if each < 2 else 1), (0 if each == 0 else 1)
        first, other = twists[2 * i + a, :3], twists[2 * i + b, :3]
        total = -trace * _dot(first, other)
        for k in range(3):
            total += first[k] * _dot(about[k], other)
        _outer(frame, (sections[1 + a, i, TURN_ALPHA + b] - sections[0, i, TURN_ALPHA + b]) / _BESIDE, vector)
        total += _dot(vector, turning)
        _outer(frame, (sections[1 + a, i, BY_ALPHA + b] - sections[0, i, BY_ALPHA + b]) / _BESIDE, vector)
        out[each] += total + _dot(vector, push)


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

    And, for the sections before, to the sums of `assembled`. Returns their part of half the mean squared distance.
    """
    ends, frames, _, _, points = chain
    begins, weights, farther = body[2], body[5], body[6]
    mass, wrench, push, spread = sums
    frame, found = frames[i], np.empty((FEET_ROWS, 3))
    place, by, pulled, vector = np.empty(3), np.empty((2, 3)), np.empty((2, 3)), np.empty(3)
    cost = 0.0
    for j in range(begins[i], begins[i + 1]):
        _outer(frame, points[0, j, 0], place)
        place += ends[i]
        feet[j] = foot(pieces, feet[j], origin[0] + place[0], origin[1] + place[1], origin[2] + place[2], found)
        off, ahead = found[OFF], found[AHEAD]
        half = 0.5 * _dot(off, off)
        weight, steep = weights[j] * (1.0 + half * farther), weights[j] * farther
        cost += weights[j] * half * (1.0 + 0.5 * half * farther)
        room = 1.0 - _dot(found[BEND], off)
        along = weight / room if second and room > 0.1 else weight
        for b in range(2):
            _outer(frame, points[0, j, 1 + b], by[b])
            slope[b] += weight * _dot(by[b], off)
            part, beside = along * _dot(by[b], ahead), steep * _dot(by[b], off)
            for k in range(3):
                pulled[b, k] = weight * by[b, k] - part * ahead[k] + beside * off[k]
            _cross(place, pulled[b], vector)
            force[b, :3] += vector
            force[b, 3:] += pulled[b]
        pair[0] += _dot(by[0], pulled[0])
        pair[1] += _dot(by[0], pulled[1])
        pair[2] += _dot(by[1], pulled[1])
        if second:
            for each in range(3):
                a, b = (0 if each < 2 else 1), (0 if each == 0 else 1)
                _outer(frame, (points[1 + a, j, 1 + b] - points[0, j, 1 + b]) / _BESIDE, vector)
                pair[each] += weight * _dot(vector, off)
            for b in range(2):
                _cross(by[b], off, vector)
                force[b, :3] += weight * vector
            for k in range(3):
                push[k] += weight * off[k]
                for m in range(3):
                    spread[k, m] += weight * off[k] * place[m]
        _weigh(mass, place, ahead, weight, along)
        _weigh(mass, place, off, 0.0, -steep)
        _cross(place, off, vector)
        wrench[:3] += weight * vector
        wrench[3:] += weight * off
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
    """Fill `model` of a chain that is laid, and move the feet (q+1,) along; returns half the mean squared distance (m²).

    `pull` (3,) is the multiplier of the tip's condition. Without `second` what distances multiply is left out, so that
    the second derivatives are at least zero.
    """
    _, frames, twists, _, _ = chain
    gradient, square = model[0], model[1]
    mass, wrench, push, spread = np.zeros((6, 6)), np.zeros(6), np.zeros(3), np.zeros((3, 3))
    force, pair, found = np.empty((2, 6)), np.empty(3), np.empty((FEET_ROWS, 3))
    _tip(pieces, origin, feet, chain, model, found)
    if second:
        _weigh(mass, chain[0][-1], found[AHEAD], 0.0, _dot(pull, found[BEND]))
        push[:] = pull
        for k in range(3):
            spread[k] = pull[k] * chain[0][-1]
    cost = 0.0
    for i in range(frames.shape[0] - 2, -1, -1):
        low = 2 * i
        for b in range(2):
            _pushed(mass, twists[low + b], force[b])
            gradient[low + b] = _power(wrench, twists[low + b])
        pair[0] = _power(twists[low], force[0])
        pair[1] = _power(twists[low], force[1])
        pair[2] = _power(twists[low + 1], force[1])
        if second:
            _bent_behind(chain, i, push, spread, frames[i], pair)
            trace = spread[0, 0] + spread[1, 1] + spread[2, 2]
            for b in range(2):
                turn, drift = twists[low + b, :3], twists[low + b, 3:]
                force[b, 0] += drift[1] * push[2] - drift[2] * push[1] - trace * turn[0]
                force[b, 1] += drift[2] * push[0] - drift[0] * push[2] - trace * turn[1]
                force[b, 2] += drift[0] * push[1] - drift[1] * push[0] - trace * turn[2]
                for k in range(3):
                    for m in range(3):
                        force[b, k] += spread[m, k] * turn[m]
        sums = (mass, wrench, push, spread)
        cost += _own(pieces, body, i, origin, feet, second, chain, sums, gradient[low : low + 2], pair, force)
        square[low, low], square[low + 1, low], square[low + 1, low + 1] = pair[0], pair[1], pair[2]
        for b in range(2):
            for a in range(low):
                square[low + b, a] = _power(twists[a], force[b])
    return cost
