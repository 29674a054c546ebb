"""Tensions that hold the arm: the distribution that is closest to the pretension.

    minimise ½ |T - T₀|²   subject to   -Jᵀ T = g,   T_min ≤ T ≤ T_max

for the torques g of the weight. With multipliers y of the equilibrium, T = clip(T₀ - J y), and y is the zero of the
piecewise linear F(y) = -Jᵀ T(y) - g, whose derivative is Jᵀ J over the cables that are not at a bound: a semismooth
Newton method on the concave dual function. It ends in finitely many steps. Where no tensions hold the arm, y grows
without bound and in the end proves it: no T within the bounds has yᵀ(-Jᵀ T) as large as yᵀ g.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel

Array = NDArray[np.float64]

#: Equilibrium is met to this share of the largest torques of the weight and of one cable.
_EXACT = 1e-12
#: Where many cables lie at a bound with nothing to spare, rounding stops Newton's method before that; this is enough.
_ENOUGH = 1e-9
#: Newton's method gives up after so many steps: no case that can be held takes a quarter of them.
_MOST_STEPS = 200
_MOST_HALVINGS = 60
#: A pivot below this share of the largest: cables that are not at a bound do not determine all torques.
_SINGULAR = 1e-11
#: What is added to the diagonal then, as a share of it.
_DAMPED = 1e-7

#: By what share of the sums that are compared a proof must hold, which is far beyond their rounding.
_PROOF = 1e-9

#: What `distribute` says of a step.
HELD, NOT_HELD, UNDECIDED = 0, 1, 2


@kernel(fastmath={"contract"})
def solve_spd(matrix: NDArray, right: NDArray, least: float) -> bool:
    """Solve in place with a symmetric matrix, whose lower triangle becomes its Cholesky factor.

    False, with nothing solved, if a pivot is not above `least`.
    """
    n = right.size
    for i in range(n):
        for j in range(i):
            total = matrix[i, j]
            for k in range(j):
                total -= matrix[i, k] * matrix[j, k]
            matrix[i, j] = total / matrix[j, j]
        pivot = matrix[i, i]
        for k in range(i):
            pivot -= matrix[i, k] * matrix[i, k]
        if not pivot > least:
            return False
        matrix[i, i] = math.sqrt(pivot)
    for i in range(n):
        total = right[i]
        for k in range(i):
            total -= matrix[i, k] * right[k]
        right[i] = total / matrix[i, i]
    for i in range(n - 1, -1, -1):
        right[i] /= matrix[i, i]
        for k in range(i):
            right[k] -= matrix[i, k] * right[i]
    return True


@kernel(fastmath={"contract"})
def _evaluate(
    jacobian: NDArray,
    torque: NDArray,
    sections: NDArray,
    wanted: NDArray,
    low: NDArray,
    high: NDArray,
    y: NDArray,
    tensions: NDArray,
    free: NDArray,
    off: NDArray,
) -> tuple[float, bool]:
    """Tensions T(y), which are free, and F(y); returns the dual function, and whether y proves that none hold."""
    off[:] = -torque
    dual, short, size = 0.0, 0.0, 0.0
    for a in range(torque.size):
        short += y[a] * torque[a]
        size += abs(y[a] * torque[a])
    for k in range(wanted.size):
        reach = 2 * sections[k] + 2
        along = 0.0
        for a in range(reach):
            along -= jacobian[k, a] * y[a]
        raw = wanted[k] + along
        tension = min(max(raw, low[k]), high[k])
        free[k] = tension == raw
        tensions[k] = tension
        dual += 0.5 * (tension - wanted[k]) ** 2
        most = max(along * low[k], along * high[k])
        short -= most
        size += abs(most)
        for a in range(reach):
            off[a] -= jacobian[k, a] * tension
    for a in range(torque.size):
        dual -= y[a] * off[a]
    return dual, short > _PROOF * size


@kernel(fastmath={"contract"})
def _gram(jacobian: NDArray, sections: NDArray, free: NDArray, out: NDArray) -> float:
    """Lower triangle of Jᵀ J over the free cables; returns its largest diagonal entry."""
    out[:] = 0.0
    for k in range(sections.size):
        if free[k]:
            for a in range(2 * sections[k] + 2):
                factor = jacobian[k, a]
                for b in range(a + 1):
                    out[a, b] += factor * jacobian[k, b]
    largest = 0.0
    for a in range(out.shape[0]):
        largest = max(largest, out[a, a])
    return largest


@kernel()
def _newton_step(
    jacobian: NDArray, sections: NDArray, free: NDArray, off: NDArray, gram: NDArray, step: NDArray
) -> None:
    """The step that makes F zero as long as the same cables stay free."""
    step[:] = -off
    largest = _gram(jacobian, sections, free, gram)
    if not solve_spd(gram, step, _SINGULAR * largest):
        scale = 0.0
        for k in range(sections.size):
            for a in range(off.size):
                scale = max(scale, jacobian[k, a] ** 2)
        _gram(jacobian, sections, free, gram)
        for a in range(off.size):
            gram[a, a] += _DAMPED * scale
        step[:] = -off
        solve_spd(gram, step, 0.0)


@kernel()
def _distribute(
    jacobians: NDArray,
    torques: NDArray,
    sections: NDArray,
    wanted: NDArray,
    low: NDArray,
    high: NDArray,
    tensions: NDArray,
    left: NDArray,
    status: NDArray,
) -> int:
    """Fill tensions (T, c), what is left of the equilibrium (T, 2n), and what is said of each step.

    Returns the number of Newton steps taken. Each step begins anew, so that no step's tensions depend on the others.
    """
    size, count = torques.shape[1], 0
    y, trial, step, gram = np.zeros(size), np.empty(size), np.empty(size), np.empty((size, size))
    free = np.empty(wanted.size, np.bool_)
    for t in range(torques.shape[0]):
        J, torque, T, off = jacobians[t], torques[t], tensions[t], left[t]
        y[:] = 0.0
        scale = np.abs(torque).max() + np.abs(J).max() * wanted.max()
        status[t] = 2
        dual, none = _evaluate(J, torque, sections, wanted, low, high, y, T, free, off)
        for _ in range(_MOST_STEPS):
            if np.abs(off).max() <= _EXACT * scale:
                status[t] = 0
                break
            if none:
                status[t] = 1
                break
            count += 1
            _newton_step(J, sections, free, off, gram, step)
            slope, found = 0.0, dual
            for a in range(size):
                slope -= off[a] * step[a]
            for _ in range(_MOST_HALVINGS):
                trial[:] = y + step
                found, none = _evaluate(J, torque, sections, wanted, low, high, trial, T, free, off)
                if none or found >= dual + 1e-4 * slope - 1e-14 * abs(dual):
                    break
                step *= 0.5
                slope *= 0.5
            y[:] = trial
            dual = found
        if status[t] == 2 and np.abs(off).max() <= _ENOUGH * scale:
            status[t] = 0
    return count


def distribute(
    jacobians: Array, torques: Array, sections: NDArray[np.int64], wanted: Array, low: Array, high: Array
) -> tuple[Array, Array, NDArray[np.int64]]:
    """Tensions (T, c) N closest to the wanted ones that hold torques (T, 2n) N m within their bounds.

    Parameters
    ----------
    jacobians : (T, c, 2n) m/rad
        Derivatives of the cable lengths; of a cable of section i zero behind the angles of its section.
    torques : (T, 2n) N m
        Derivatives of the potential energy.
    sections : (c,)
    wanted, low, high : (c,) N

    Returns
    -------
    tensions : (T, c) N
        Where none hold the arm, some that leave little.
    left : (T, 2n) N m
        Torque -Jᵀ T - g that tensions do not balance.
    status : (T,)
        `HELD`, `NOT_HELD`: it is proven that no tensions hold the arm, or `UNDECIDED`.
    """
    tensions, left = np.empty((len(torques), wanted.size)), np.empty(torques.shape)
    status = np.zeros(len(torques), np.int64)
    _distribute(jacobians, torques, sections, wanted, low, high, tensions, left, status)
    return tensions, left, status
