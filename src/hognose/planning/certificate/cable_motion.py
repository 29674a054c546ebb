"""How far joints leave linear angles while all cable lengths go linearly from one set-point to the next.

The derivation is in `docs/certificate.md`, "Cables interpolated"; names there and here are the same.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.planning.certificate.bound import Array
from hognose.robot import Robot
from hognose.robot.joint_cable import curvature_through_joint, through_joint

#: Greatest value of |t (t - 1/2) (t - 1)| / 6 from 0 to 1: what a parabola through three points leaves of a third
#: derivative.
_CUBIC = 1.0 / (72.0 * math.sqrt(3.0))
#: Bounds of the second and third derivative of R_y(α) R_x(β) q along a line of unit speed, for |q| = 1.
_SECOND, _THIRD = 1.5, 2.885
#: Greatest value of x (1 - x²) from 0 to 1.
_MIXED = 2.0 / (3.0 * math.sqrt(3.0))
#: A bound is tried so much above what it was made from, and so often.
_ABOVE, _TRIALS = 1.1, 30
#: Least radius (rad) round the middle in which derivatives are bounded.
_LEAST = 1e-6


@kernel()
def _matrices(
    middle: NDArray,
    swing: NDArray,
    reach: NDArray,
    before: NDArray,
    after: NDArray,
    first: NDArray,
    radius: NDArray,
    cosine: NDArray,
    sine: NDArray,
    own: NDArray,
    gain: NDArray,
    chain: NDArray,
    bent: NDArray,
    steep: NDArray,
    third: NDArray,
) -> bool:
    """P (2, c) as `own`, its norms, A (n, n, 2, 2), and the bounds H, N (n, n) and T (n,) of one piece.

    False where some cable may have no length at all, or where cables do not determine a section's angles.
    """
    trig = np.empty((middle.shape[0], 4))
    for j in range(middle.shape[0]):
        trig[j, 0], trig[j, 1] = math.cos(middle[j, 0]), math.sin(middle[j, 0])
        trig[j, 2], trig[j, 3] = math.cos(middle[j, 1]), math.sin(middle[j, 1])
    for i in range(middle.shape[0]):
        aa, ab, bb = 0.0, 0.0, 0.0
        for k in range(first[i], first[i + 1]):
            _, ga, gb = through_joint(
                trig[i, 0], trig[i, 1], trig[i, 2], trig[i, 3], before[i], after[i], radius[k], cosine[k], sine[k]
            )
            own[0, k], own[1, k] = ga, gb
            aa, ab, bb = aa + ga * ga, ab + ga * gb, bb + gb * gb
        determinant = aa * bb - ab * ab
        least = 0.5 * (aa + bb - math.sqrt((aa - bb) * (aa - bb) + 4.0 * ab * ab))
        if not least > 1e-9 * (aa + bb):
            return False
        gain[i] = 1.0 / math.sqrt(least)
        for k in range(first[i], first[i + 1]):
            ga, gb = own[0, k], own[1, k]
            own[0, k], own[1, k] = (bb * ga - ab * gb) / determinant, (aa * gb - ab * ga) / determinant
        bent[i], steep[i], chain[i] = 0.0, 0.0, 0.0
        jerks = 0.0
        for k in range(first[i], first[i + 1]):
            jerk = 0.0
            for j in range(i + 1):
                ca, sa, cb, sb = trig[j, 0], trig[j, 1], trig[j, 2], trig[j, 3]
                h1, h2, r, c, s = before[j], after[j], radius[k], cosine[k], sine[k]
                length, ga, gb = through_joint(ca, sa, cb, sb, h1, h2, r, c, s)
                arm = math.sqrt(r * r + h2 * h2)
                shortest = length - arm * reach[j]
                if not shortest > 0.0:
                    return False
                ratio = arm / shortest
                changing = arm * (_THIRD + 3.0 * _SECOND * ratio + 3.0 * _MIXED * ratio * ratio)
                turning = curvature_through_joint(ca, sa, cb, sb, h1, h2, r, c, s, length, ga, gb) + changing * reach[j]
                slope = math.sqrt(ga * ga + gb * gb) + turning * reach[j]
                bent[i, j] += turning * turning
                steep[i, j] += slope * slope
                jerk += changing * swing[j] * swing[j] * swing[j]
                chain[i, j, 0, 0] += own[0, k] * ga
                chain[i, j, 0, 1] += own[0, k] * gb
                chain[i, j, 1, 0] += own[1, k] * ga
                chain[i, j, 1, 1] += own[1, k] * gb
            jerks += jerk * jerk
        third[i] = math.sqrt(jerks)
        for j in range(i + 1):
            bent[i, j], steep[i, j] = math.sqrt(bent[i, j]), math.sqrt(steep[i, j])
    return True


@kernel()
def _norm(a: float, b: float, c: float, d: float) -> float:
    """The spectral norm of [[a, b], [c, d]]."""
    whole, determinant = a * a + b * b + c * c + d * d, a * d - b * c
    return math.sqrt(0.5 * (whole + math.sqrt(max(whole * whole - 4.0 * determinant * determinant, 0.0))))


@kernel()
def _inverse_norms(chain: NDArray, column: NDArray, out: NDArray) -> None:
    """Norms (n, n) of the blocks of the inverse of the block triangular A, whose diagonal is 1."""
    for j in range(chain.shape[0]):
        column[j, 0, 0], column[j, 0, 1], column[j, 1, 0], column[j, 1, 1] = 1.0, 0.0, 0.0, 1.0
        out[j, j] = 1.0
        for i in range(j + 1, chain.shape[0]):
            a, b, c, d = 0.0, 0.0, 0.0, 0.0
            for k in range(j, i):
                p, q, r, s = chain[i, k, 0, 0], chain[i, k, 0, 1], chain[i, k, 1, 0], chain[i, k, 1, 1]
                w, x, y, z = column[k, 0, 0], column[k, 0, 1], column[k, 1, 0], column[k, 1, 1]
                a, b, c, d = a - p * w - q * y, b - p * x - q * z, c - r * w - s * y, d - r * x - s * z
            column[i, 0, 0], column[i, 0, 1], column[i, 1, 0], column[i, 1, 1] = a, b, c, d
            out[i, j] = _norm(a, b, c, d)


@kernel()
def _parabola(
    own: NDArray, first: NDArray, chain: NDArray, off: NDArray, solved: NDArray, out: NDArray, far: NDArray
) -> None:
    """Adds up |A⁻¹ P φ| (n,) rad and |φ| (n,) m over the three φ = off (3, c) m of the beginning, middle and end."""
    out[:], far[:] = 0.0, 0.0
    for m in range(3):
        for i in range(chain.shape[0]):
            a, b, size = 0.0, 0.0, 0.0
            for k in range(first[i], first[i + 1]):
                a, b, size = a + own[0, k] * off[m, k], b + own[1, k] * off[m, k], size + off[m, k] * off[m, k]
            for j in range(i):
                a -= chain[i, j, 0, 0] * solved[j, 0] + chain[i, j, 0, 1] * solved[j, 1]
                b -= chain[i, j, 1, 0] * solved[j, 0] + chain[i, j, 1, 1] * solved[j, 1]
            solved[i, 0], solved[i, 1] = a, b
            out[i] += math.sqrt(a * a + b * b)
            far[i] += math.sqrt(size)


@kernel()
def _improved(
    swing: NDArray,
    gain: NDArray,
    bent: NDArray,
    steep: NDArray,
    third: NDArray,
    inverse: NDArray,
    known: NDArray,
    far: NDArray,
    assumed: NDArray,
    rest: NDArray,
    out: NDArray,
) -> None:
    """What follows for |δ| (n,) rad from what is assumed of it."""
    for i in range(gain.size):
        curved, residual = 0.0, far[i] + _CUBIC * third[i]
        for j in range(i + 1):
            curved += bent[i, j] * (0.5 * swing[j] + assumed[j]) * assumed[j]
            residual += steep[i, j] * assumed[j]
        turned = gain[i] * bent[i, i] * (0.5 * swing[i] + assumed[i])
        rest[i] = gain[i] * (_CUBIC * third[i] + curved + turned * residual)
        out[i] = known[i]
        for j in range(i + 1):
            out[i] += inverse[i, j] * rest[j]


@kernel()
def _deviations(
    low: NDArray,
    high: NDArray,
    off: NDArray,
    before: NDArray,
    after: NDArray,
    first: NDArray,
    radius: NDArray,
    cosine: NDArray,
    sine: NDArray,
    out: NDArray,
) -> None:
    n, c = low.shape[1], radius.size
    swing, reach, gain, third = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    known, far, rest, assumed = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    own, chain, column, solved = np.empty((2, c)), np.zeros((n, n, 2, 2)), np.empty((n, 2, 2)), np.empty((n, 2))
    bent, steep, inverse = np.empty((n, n)), np.empty((n, n)), np.empty((n, n))
    for m in range(low.shape[0]):
        largest = 0.0
        for i in range(n):
            a, b = high[m, i, 0] - low[m, i, 0], high[m, i, 1] - low[m, i, 1]
            swing[i] = math.sqrt(a * a + b * b)
            largest = max(largest, swing[i])
        for i in range(n):
            reach[i] = 0.5 * (swing[i] + largest) + _LEAST
        out[m] = math.inf
        middle = 0.5 * (low[m] + high[m])
        if not _matrices(
            middle, swing, reach, before, after, first, radius, cosine, sine, own, gain, chain, bent, steep, third
        ):
            continue
        _parabola(own, first, chain, off[m], solved, known, far)
        _inverse_norms(chain, column, inverse)
        found = known.copy()
        for _ in range(_TRIALS):
            for i in range(n):
                assumed[i] = _ABOVE * found[i] + 1e-15
            _improved(swing, gain, bent, steep, third, inverse, known, far, assumed, rest, found)
            kept, inside = True, True
            for i in range(n):
                kept = kept and found[i] < assumed[i]
                inside = inside and 0.5 * swing[i] + assumed[i] <= reach[i]
            if kept and inside:
                out[m] = found
            if kept or not inside:
                break


def deviations(robot: Robot, low: Array, high: Array, low_lengths: Array, high_lengths: Array) -> Array:
    """How far (m, n) rad each section's angles leave linear ones at most; infinite where that is not known.

    Parameters
    ----------
    robot
    low, high : (m, n, 2) rad
        The angles that belong to the lengths at both ends of each piece, as `Robot.angles_from_cables` finds them.
    low_lengths, high_lengths : (m, c) m
        Between these, all lengths go linearly.
    """
    lengths = 0.5 * (low_lengths + high_lengths)
    off = np.stack(
        [
            robot.cable_lengths(low) - low_lengths,
            robot.cable_lengths(0.5 * (low + high)) - lengths,
            robot.cable_lengths(high) - high_lengths,
        ],
        axis=1,
    )
    azimuth, out = robot.cable_azimuths, np.empty(low.shape[:2])
    joints = (robot.joint_before, robot.joint_after, robot.first_cables)
    _deviations(low, high, off, *joints, robot.cable_radii, np.cos(azimuth), np.sin(azimuth), out)
    return out
