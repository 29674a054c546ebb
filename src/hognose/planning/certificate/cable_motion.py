"""How far joints leave linear angles while all cable lengths go linearly from one set-point to the next.

The derivation is in `docs/certificate.md`, "Cables interpolated"; letters in comments are those used there.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.planning.certificate.moving import Array
from hognose.robot import Robot
from hognose.robot.cable_terms import ALPHA_TWICE, BETA_TWICE, BOTH, BY_ALPHA, BY_BETA, ENTRIES, THIRD, terms

#: Angles (n, 2) rad in the middle of a piece, their cosines and sines (n, 4), and how far (n,) rad they go from there.
At = tuple[NDArray, NDArray, NDArray]
#: Of all cables: whether they are plain, the joints (n, 2), where each section's begin (n + 1,), holes (c, 3), laws
#: (n, 6) and circles (c, n + 1), as of `terms`.
Cables = tuple[bool, NDArray, NDArray, NDArray, NDArray, NDArray]

#: What a parabola through three points leaves of a third derivative at most: |t (t - 1/2) (t - 1)| / 6.
_CUBIC = 1.0 / (72.0 * math.sqrt(3.0))
#: The largest magnitude of such a parabola, in terms of that of its three points.
_LEBESGUE = 1.25
#: A bound is tried so much above what follows from the one before, and so often.
_ABOVE, _TRIALS = 1.1, 30
#: Derivatives are bounded within this (rad) of the middle at least.
_LEAST = 1e-6


@kernel(inline="always")
def _norm(a: float, b: float, c: float, d: float) -> float:
    """The spectral norm of [[a, b], [c, d]]."""
    whole, determinant = a * a + b * b + c * c + d * d, a * d - b * c
    return math.sqrt(0.5 * (whole + math.sqrt(max(whole * whole - 4.0 * determinant * determinant, 0.0))))


@kernel(inline="always")
def _terms(j: int, k: int, at: At, cables: Cables, found: NDArray) -> None:
    """What `terms` finds of cable k in section j, within the reach of the piece."""
    middle, trig, reach = at
    plain, joints, _, holes, laws, circles = cables
    terms(plain, trig[j], middle[j], joints[j], holes[k], laws[j], circles[k, j], circles[k, j + 1], reach[j], found)


@kernel(fastmath={"contract"})
def _own_cables(i: int, at: At, cables: Cables, found: NDArray, own: NDArray, gain: NDArray) -> bool:
    """P of section i as columns `own` (2, c), and its norm; False where its cables do not determine its angles."""
    aa, ab, bb = 0.0, 0.0, 0.0
    first = cables[2]
    for k in range(first[i], first[i + 1]):
        _terms(i, k, at, cables, found)
        ga, gb = found[BY_ALPHA], found[BY_BETA]
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
    return True


@kernel(fastmath={"contract"})
def _matrices(
    at: At,
    swing: NDArray,
    cables: Cables,
    own: NDArray,
    gain: NDArray,
    chain: NDArray,
    bent: NDArray,
    steep: NDArray,
    third: NDArray,
) -> bool:
    """A (n, n, 2, 2) as `chain`, and the bounds H, N (n, n) and T (n,) of a piece.

    False where a cable may have no length, or where cables do not determine a section's angles.
    """
    found, first, reach = np.empty(ENTRIES), cables[2], at[2]
    for i in range(gain.size):
        if not _own_cables(i, at, cables, found, own, gain):
            return False
        third[i] = 0.0
        for j in range(i + 1):
            slopes, bends, changes, paa, pab, pba, pbb = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for k in range(first[i], first[i + 1]):
                _terms(j, k, at, cables, found)
                pa, pb, ga, gb, change = own[0, k], own[1, k], found[BY_ALPHA], found[BY_BETA], found[THIRD]
                aa, bb, ab = found[ALPHA_TWICE], found[BETA_TWICE], found[BOTH]
                if change == math.inf:
                    return False
                slopes, bends = slopes + ga * ga + gb * gb, bends + aa * aa + bb * bb + 2.0 * ab * ab
                changes += change * change
                paa, pab, pba, pbb = paa + pa * ga, pab + pa * gb, pba + pb * ga, pbb + pb * gb
            chain[i, j, 0, 0], chain[i, j, 0, 1], chain[i, j, 1, 0], chain[i, j, 1, 1] = paa, pab, pba, pbb
            changing = math.sqrt(changes)
            bent[i, j] = math.sqrt(bends) + changing * reach[j]
            steep[i, j] = math.sqrt(slopes) + bent[i, j] * reach[j]
            third[i] += changing * swing[j] * swing[j] * swing[j]
    return True


@kernel(fastmath={"contract"})
def _inverse_norms(chain: NDArray, column: NDArray, out: NDArray) -> None:
    """Norms (n, n) of the blocks of the inverse of A, which is block triangular with 1 on its diagonal."""
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


@kernel(fastmath={"contract"})
def _parabola(
    own: NDArray, first: NDArray, chain: NDArray, off: NDArray, solved: NDArray, known: NDArray, far: NDArray
) -> None:
    """Bounds of |A⁻¹ P φ| (n,) rad and |φ| (n,) m on the parabola through φ = off (3, c) m, but for the cubic rest.

    The three are the values at the beginning, in the middle and at the end.
    """
    known[:], far[:] = 0.0, 0.0
    for m in range(3):
        for i in range(chain.shape[0]):
            a, b, size = 0.0, 0.0, 0.0
            for k in range(first[i], first[i + 1]):
                a, b, size = a + own[0, k] * off[m, k], b + own[1, k] * off[m, k], size + off[m, k] * off[m, k]
            for j in range(i):
                a -= chain[i, j, 0, 0] * solved[j, 0] + chain[i, j, 0, 1] * solved[j, 1]
                b -= chain[i, j, 1, 0] * solved[j, 0] + chain[i, j, 1, 1] * solved[j, 1]
            solved[i, 0], solved[i, 1] = a, b
            known[i] += math.sqrt(a * a + b * b)
            far[i] = max(far[i], _LEBESGUE * math.sqrt(size))


@kernel(fastmath={"contract"})
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
        tilted = gain[i] * bent[i, i] * (0.5 * swing[i] + assumed[i])
        rest[i] = gain[i] * (_CUBIC * third[i] + curved + tilted * residual)
        out[i] = known[i]
        for j in range(i + 1):
            out[i] += inverse[i, j] * rest[j]


@kernel(fastmath={"contract"})
def _deviations(low: NDArray, high: NDArray, off: NDArray, cables: Cables, out: NDArray) -> None:
    """See `deviations`."""
    n, first = low.shape[1], cables[2]
    middle, trig, own, chain = np.empty((n, 2)), np.empty((n, 4)), np.empty((2, off.shape[2])), np.empty((n, n, 2, 2))
    column, solved, bent = np.empty((n, 2, 2)), np.empty((n, 2)), np.empty((n, n))
    steep, inverse, lists = np.empty((n, n)), np.empty((n, n)), np.empty((8, n))
    swing, reach, gain, third, known, far, rest, assumed = lists
    for m in range(low.shape[0]):
        for j in range(n):
            alpha, beta = 0.5 * (low[m, j, 0] + high[m, j, 0]), 0.5 * (low[m, j, 1] + high[m, j, 1])
            middle[j, 0], middle[j, 1] = alpha, beta
            trig[j, 0], trig[j, 1] = math.cos(alpha), math.sin(alpha)
            trig[j, 2], trig[j, 3] = math.cos(beta), math.sin(beta)
            swing[j] = math.sqrt((high[m, j, 0] - low[m, j, 0]) ** 2 + (high[m, j, 1] - low[m, j, 1]) ** 2)
        largest = swing.max()
        for j in range(n):
            reach[j] = 0.5 * (swing[j] + largest) + _LEAST
        out[m] = math.inf
        if not _matrices((middle, trig, reach), swing, cables, own, gain, chain, bent, steep, third):
            continue
        _parabola(own, first, chain, off[m], solved, known, far)
        _inverse_norms(chain, column, inverse)
        found = known.copy()
        for _ in range(_TRIALS):
            assumed[:] = _ABOVE * found + 1e-15
            _improved(swing, gain, bent, steep, third, inverse, known, far, assumed, rest, found)
            inside = (0.5 * swing + assumed <= reach).all()
            if inside and (found < assumed).all():
                out[m] = found
                break
            if not inside:
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
    ends = (low, 0.5 * (low + high), high)
    lengths = (low_lengths, 0.5 * (low_lengths + high_lengths), high_lengths)
    off = np.stack([robot.cable_lengths(a) - b for a, b in zip(ends, lengths, strict=True)], axis=1)
    out = np.empty(low.shape[:2])
    first = (robot.plain_cables, robot.hole_planes, robot.first_cables)
    _deviations(low, high, off, (*first, robot.cable_holes, robot.cable_laws, robot.cable_circles), out)
    return out
