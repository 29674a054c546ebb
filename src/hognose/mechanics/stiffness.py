"""How stiff the arm is with its motors held: the derivative of all torques by the joint angles.

    K = Jᵀ diag(k) J  +  Σ T_k H_k + d²U/dq²

The first term is the elastic stiffness of the cables, always positive; the rest is the geometric one of tensions and
weight. Cables across universal joints have a negative one. Where K has a negative eigenvalue, the arm buckles. The
load factor λ is by how much tensions and weight would have to grow for that:

    det(K_elastic + λ K_geometric) = 0   for the smallest λ > 0 .
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel

Array = NDArray[np.float64]

#: The largest eigenvalue alone of matrices of up to so many rows is found faster than LAPACK finds all of them.
_LARGE = 60


@kernel(fastmath={"contract"})
def elastic_at(jacobian: NDArray, sections: NDArray, constants: NDArray, out: NDArray) -> None:
    """Add Jᵀ diag(k) J of one pose to `out` (2n, 2n), for a Jacobian (c, 2n) and spring constants (c,)."""
    for k in range(sections.size):
        for a in range(2 * sections[k] + 2):
            factor = constants[k] * jacobian[k, a]
            for b in range(2 * sections[k] + 2):
                out[a, b] += factor * jacobian[k, b]


@kernel()
def _elastic(jacobians: NDArray, sections: NDArray, constants: NDArray, out: NDArray) -> None:
    for t in range(jacobians.shape[0]):
        elastic_at(jacobians[t], sections, constants[t], out[t])


@kernel(fastmath={"contract"})
def _forward(factor: NDArray, right: NDArray) -> None:
    """Solve L X = B in place, row by row, for the lower triangle L and B (m, m)."""
    for i in range(right.shape[0]):
        for k in range(i):
            share = factor[i, k]
            for b in range(right.shape[1]):
                right[i, b] -= share * right[k, b]
        scale = 1.0 / factor[i, i]
        for b in range(right.shape[1]):
            right[i, b] *= scale


@kernel(fastmath={"contract"})
def _reduced(elastic: NDArray, geometric: NDArray, out: NDArray) -> int:
    """Write -L⁻¹ K_geometric L⁻ᵀ (T, m, m), with L Lᵀ = K_elastic; returns the step where there is no L, or -1."""
    m = elastic.shape[1]
    factor, half = np.empty((m, m)), np.empty((m, m))
    for t in range(elastic.shape[0]):
        for i in range(m):
            for j in range(i + 1):
                total = elastic[t, i, j]
                for k in range(j):
                    total -= factor[i, k] * factor[j, k]
                if j < i:
                    factor[i, j] = total / factor[j, j]
                elif total > 0.0:
                    factor[i, i] = math.sqrt(total)
                else:
                    return t
        half[:] = -geometric[t]
        _forward(factor, half)
        out[t] = half.T
        _forward(factor, out[t])
    return -1


@kernel(fastmath={"contract"})
def _tridiagonal(a: NDArray, diagonal: NDArray, beside: NDArray) -> None:
    """Turn a symmetric matrix (m, m) into one with entries only on and beside its diagonal, by reflections.

    Eigenvalues stay. `a` is overwritten; `diagonal` (m,) and `beside` (m,), whose last entry is 0, are written.
    """
    m = a.shape[0]
    v, p = np.empty(m), np.empty(m)
    for k in range(m - 2):
        square = 0.0
        for i in range(k + 1, m):
            v[i] = a[i, k]
            square += v[i] * v[i]
        size = -math.copysign(math.sqrt(square), v[k + 1])
        diagonal[k], beside[k] = a[k, k], size
        if square == 0.0:
            continue
        scale = 1.0 / (square - v[k + 1] * size)  # 2 / |v|², once the reflection's vector is made
        v[k + 1] -= size
        along = 0.0
        for i in range(k + 1, m):
            total = 0.0
            for j in range(k + 1, i + 1):
                total += a[i, j] * v[j]
            for j in range(i + 1, m):
                total += a[j, i] * v[j]
            p[i] = scale * total
            along += p[i] * v[i]
        along *= 0.5 * scale
        for i in range(k + 1, m):
            p[i] -= along * v[i]
        for i in range(k + 1, m):
            for j in range(k + 1, i + 1):
                a[i, j] -= v[i] * p[j] + p[i] * v[j]
    if m > 1:
        diagonal[m - 2], beside[m - 2] = a[m - 2, m - 2], a[m - 1, m - 2]
    diagonal[m - 1], beside[m - 1] = a[m - 1, m - 1], 0.0


@kernel(fastmath={"contract"})
def _highest(diagonal: NDArray, beside: NDArray) -> float:
    """The largest eigenvalue of a tridiagonal matrix: bisection to the last bits by Sturm's count."""
    m, low, high = diagonal.size, -math.inf, -math.inf
    for i in range(m):
        reach = abs(beside[i]) + (abs(beside[i - 1]) if i > 0 else 0.0)
        low, high = max(low, diagonal[i]), max(high, diagonal[i] + reach)
    least = 1e-300 + 1e-18 * max(abs(low), abs(high))
    for _ in range(120):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        pivot, above = diagonal[0] - middle, False
        for i in range(1, m):
            if pivot > -least:
                above = True
                break
            pivot = diagonal[i] - middle - beside[i - 1] * beside[i - 1] / pivot
        if above or pivot >= 0.0:
            low = middle
        else:
            high = middle
    return high


@kernel()
def _largest(matrices: NDArray, out: NDArray) -> None:
    """Largest eigenvalues (T,) of symmetric matrices (T, m, m), which are overwritten."""
    m = matrices.shape[1]
    diagonal, beside = np.empty(m), np.empty(m)
    for t in range(matrices.shape[0]):
        _tridiagonal(matrices[t], diagonal, beside)
        out[t] = _highest(diagonal, beside)


def elastic_stiffness(jacobians: Array, sections: NDArray[np.int64], constants: Array) -> Array:
    """Stiffness (T, 2n, 2n) N m/rad of cables of spring constants (T, c) N/m with their motors held."""
    out = np.zeros((len(jacobians), jacobians.shape[2], jacobians.shape[2]))
    _elastic(jacobians, sections, constants, out)
    return out


def smallest_eigenvalues(stiffness: Array) -> Array:
    """Smallest eigenvalues (T,) of symmetric matrices (T, m, m)."""
    return np.ascontiguousarray(np.linalg.eigvalsh(stiffness)[:, 0], dtype=np.float64)


def _largest_eigenvalues(matrices: Array) -> Array:
    """Largest eigenvalues (T,) of symmetric matrices (T, m, m), which may be overwritten."""
    if matrices.shape[1] > _LARGE:
        return np.ascontiguousarray(np.linalg.eigvalsh(matrices)[:, -1], dtype=np.float64)
    out = np.empty(len(matrices))
    _largest(matrices, out)
    return out


def load_factors(elastic: Array, geometric: Array) -> Array:
    """By how much (T,) all tensions and the weight would have to grow until the arm buckles; infinite if it never does.

    Below 1 it buckles as it is. Zero where the cables do not hold every joint.

    Parameters
    ----------
    elastic, geometric : (T, 2n, 2n) N m/rad
    """
    reduced = np.zeros(elastic.shape)
    loose = _reduced(elastic, geometric, reduced)
    out = np.zeros(len(elastic))
    sound = len(elastic) if loose < 0 else loose
    largest = _largest_eigenvalues(reduced[:sound])
    with np.errstate(divide="ignore"):
        out[:sound] = np.where(largest > 0.0, 1.0 / largest, math.inf)
    if loose >= 0:
        out[loose + 1 :] = load_factors(elastic[loose + 1 :], geometric[loose + 1 :])
    return out
