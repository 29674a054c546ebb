"""Newton's method for what brings a body closest to a path, with its tip on the path and within bounds.

Unknown are the angles, and the lengths of sections that extend.

Each iteration solves a quadratic model of the distance, with the tip's condition linearised, within the bounds: those
that a solution goes beyond become equations, those whose multiplier points inwards are let go, until neither is left
(primal-dual active sets). Where the exact second derivatives are not positive, what distances multiply is left out
(Gauss-Newton).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.following.fit_lengths import Stretch, lengthened, lengths_set
from hognose.following.fit_model import Chain, Model, assembled, laid
from hognose.following.samples import Body
from hognose.kernels import kernel
from hognose.path.polynomial import Pieces

#: It ends with a step (rad) so small, of which the square is rounding; or of Gauss-Newton's method, which does not
#: square it; or has failed after so many. No step turns more than the longest.
_LAST, _LAST_LINEAR, _MOST, _LONGEST = 1e-8, 1e-13, 60, 0.3
#: Where lengths can make up for angles, steps get no smaller than what rounding leaves of them. After so many
#: iterations it ends with one of this size (rad), whose square is still less than what is promised of the tip.
_ENOUGH, _ROUNDED = 20, 5e-7
#: Rounds in which bounds are chosen.
_ROUNDS = 12


@kernel(fastmath={"contract", "reassoc"})
def _factored(square: NDArray, free: NDArray, lower: NDArray) -> bool:
    """Cholesky's factor of the free rows and columns of a matrix whose lower half is given."""
    for a in range(free.size):
        for b in range(a + 1):
            if not (free[a] and free[b]):
                lower[a, b] = 1.0 if a == b else 0.0
                continue
            total = square[a, b]
            for k in range(b):
                total -= lower[a, k] * lower[b, k]
            if a != b:
                lower[a, b] = total / lower[b, b]
            elif total > 1e-13 * square[a, a] and total > 0.0:
                lower[a, a] = math.sqrt(total)
            else:
                return False
    return True


@kernel(fastmath={"contract", "reassoc"})
def _substituted(lower: NDArray, right: NDArray) -> None:
    """Solve with the factor in place."""
    for a in range(right.size):
        total = right[a]
        for k in range(a):
            total -= lower[a, k] * right[k]
        right[a] = total / lower[a, a]
    for a in range(right.size - 1, -1, -1):
        right[a] /= lower[a, a]
        for k in range(a):
            right[k] -= lower[a, k] * right[a]


@kernel(fastmath={"contract"})
def _within(model: Model, free: NDArray, lower: NDArray, step: NDArray, dual: NDArray) -> bool:
    """The step (2n,) of the free angles, given those of the others, and the multipliers (2,) of the tip's condition."""
    gradient, square, apart, rates, _ = model
    size = gradient.size
    if not _factored(square, free, lower):
        return False
    moved, across = np.empty(size), np.zeros((2, size))
    left = -apart
    for a in range(size):
        moved[a] = -gradient[a] if free[a] else 0.0
        for m in range(2):
            if free[a]:
                across[m, a] = rates[m, a]
            else:
                left[m] -= rates[m, a] * step[a]
    for a in range(size):
        if not free[a] and step[a] != 0.0:
            for b in range(size):
                if free[b]:
                    moved[b] -= (square[a, b] if a > b else square[b, a]) * step[a]
    _substituted(lower, moved)
    _substituted(lower, across[0])
    _substituted(lower, across[1])
    s00, s01, s11, r0, r1 = 0.0, 0.0, 0.0, -left[0], -left[1]
    for a in range(size):
        if free[a]:
            s00 += rates[0, a] * across[0, a]
            s01 += rates[0, a] * across[1, a]
            s11 += rates[1, a] * across[1, a]
            r0 += rates[0, a] * moved[a]
            r1 += rates[1, a] * moved[a]
    determinant = s00 * s11 - s01 * s01
    if not determinant > 1e-12 * s00 * s11:
        return False
    dual[0], dual[1] = (s11 * r0 - s01 * r1) / determinant, (s00 * r1 - s01 * r0) / determinant
    for a in range(size):
        if free[a]:
            step[a] = moved[a] - dual[0] * across[0, a] - dual[1] * across[1, a]
    return True


@kernel(fastmath={"contract"})
def _stepped(
    model: Model, angles: NDArray, limits: NDArray, held: NDArray, lower: NDArray, step: NDArray, dual: NDArray
) -> bool:
    """The step (2n,) from angles (2n,) within limits (2n, 2); `held` (2n,) is the side of those at a limit, or 0."""
    gradient, square, _, rates, _ = model
    for _ in range(_ROUNDS):
        for a in range(step.size):
            step[a] = 0.0 if held[a] == 0.0 else limits[a, 1 if held[a] > 0.0 else 0] - angles[a]
        if not _within(model, held == 0.0, lower, step, dual):
            return False
        changed = False
        for a in range(step.size):
            if held[a] == 0.0:
                goal = angles[a] + step[a]
                if goal > limits[a, 1] or goal < limits[a, 0]:
                    held[a], changed = (1.0 if goal > limits[a, 1] else -1.0), True
                continue
            slope = gradient[a] + dual[0] * rates[0, a] + dual[1] * rates[1, a]
            for b in range(step.size):
                slope += (square[a, b] if a > b else square[b, a]) * step[b]
            if slope * held[a] > 0.0:
                held[a], changed = 0.0, True
        if not changed:
            return True
    return True


@kernel(fastmath={"contract"})
def _tied(ties: NDArray, angles: NDArray, model: Model) -> None:
    """Add what ties (2n,) m² add to the model: half of each times the square of its angle."""
    for a in range(ties.size):
        model[0][a] += ties[a] * angles[a]
        model[1][a, a] += ties[a]


@kernel(fastmath={"contract"})
def fitted(
    pieces: Pieces,
    body: Body,
    origin: NDArray,
    bounds: NDArray,
    ties: NDArray,
    stretch: Stretch,
    flat: NDArray,
    feet: NDArray,
    pull: NDArray,
    chain: Chain,
    model: Model,
    evaluations: NDArray,
) -> bool:
    """Change unknowns (w,), feet (q+1,) and the multiplier (3,) to those of the closest posture near them.

    Unknowns are the angles (n, 2) rad, and behind them how much longer (e,) sections are than at rest, as `Stretch` has
    it; they stay within bounds (w, 2). `ties` (w,) m², where not 0, hold them near 0. The base's frame is in `chain`,
    in which the posture is laid in the end; the sections of `body` are as long as in it. False if none is found.
    """
    size, turns = flat.size, 2 * (chain[0].shape[0] - 1)
    angles, parts = flat[:turns].reshape((turns // 2, 2)), flat[turns:]
    held, lower = np.zeros(size), np.empty((size, size))
    step, dual, exact = np.empty(size), np.empty(2), True
    for a in range(size):
        if flat[a] >= bounds[a, 1]:
            held[a], flat[a] = 1.0, bounds[a, 1]
        elif flat[a] <= bounds[a, 0]:
            held[a], flat[a] = -1.0, bounds[a, 0]
    for count in range(_MOST):
        lengths_set(body, stretch, parts)
        laid(body, angles, exact, chain)
        cost = assembled(pieces, body, origin, pull, feet, exact, chain, model)
        lengthened(pieces, body, stretch, parts, origin, pull, feet, exact, chain, model)
        _tied(ties, flat, model)
        evaluations[0] += feet.size
        if math.isnan(cost):
            return False
        found = _stepped(model, flat, bounds, held, lower, step, dual)
        if not found and exact:
            exact = False
            assembled(pieces, body, origin, pull, feet, exact, chain, model)
            lengthened(pieces, body, stretch, parts, origin, pull, feet, exact, chain, model)
            _tied(ties, flat, model)
            found = _stepped(model, flat, bounds, held, lower, step, dual)
        if not found:
            return False
        largest = 0.0
        for a in range(size):
            largest = max(largest, abs(step[a]))
        scale = min(1.0, _LONGEST / largest) if largest > 0.0 else 1.0
        for a in range(size):
            flat[a] = min(max(flat[a] + scale * step[a], bounds[a, 0]), bounds[a, 1])
        for k in range(3):
            pull[k] = dual[0] * model[4][0, k] + dual[1] * model[4][1, k]
        last = _ROUNDED if parts.size > 0 and count >= _ENOUGH else _LAST
        if largest < (last if exact else _LAST_LINEAR):
            lengths_set(body, stretch, parts)
            laid(body, angles, False, chain)
            return True
        exact = True
    return False
