"""Levenberg–Marquardt over joint angles with bounds and finite differences: what a general optimiser does."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.following.chain import placed
from hognose.kernels import kernel
from hognose.path.polynomial import Pieces, evaluate_at

#: A base as kernels take it: its place (3,) m, and its frame with the rows x, y, z.
Base = tuple[NDArray, NDArray]
#: Lengths (n,) m of the links, lowest and highest angles (n, 2, 2) rad, and weights (n,) of the distances of the joints
#: behind the base.
Arm = tuple[NDArray, NDArray, NDArray]

#: It ends when the weighted distances (m) or the change of the angles (rad) are below these, or after so many tries.
_CLOSE, _STILL, _TRIES = 1e-11, 1e-13, 200
#: Difference (rad) of the finite differences.
_DIFFERENCE = 1e-7


@kernel()
def foot_point(pieces: Pieces, start: float, point: NDArray) -> float:
    """The parameter where the curve is closest to a point, by Newton's method from a start; within the curve."""
    breaks, coefficients = pieces
    u = start
    for _ in range(20):
        px, py, pz, vx, vy, vz, ax, ay, az = evaluate_at(breaks, coefficients, u)
        dx, dy, dz = point[0] - px, point[1] - py, point[2] - pz
        speed = vx * vx + vy * vy + vz * vz
        steep = speed - 2.0 * (dx * ax + dy * ay + dz * az)
        change = (dx * vx + dy * vy + dz * vz) / (steep if steep > 0.1 * speed else speed)
        moved = min(max(u + change, breaks[0]), breaks[-1])
        if abs(moved - u) < 1e-13:
            return moved
        u = moved
    return u


@kernel()
def _distances(pieces: Pieces, joints: NDArray, weights: NDArray, feet: NDArray, residuals: NDArray) -> float:
    """Weighted vectors (3n,) from the path to the joints behind the base, and half their squared norm."""
    breaks, coefficients = pieces
    cost = 0.0
    for i in range(weights.size):
        feet[i] = foot_point(pieces, feet[i], joints[i + 1])
        px, py, pz, _, _, _, _, _, _ = evaluate_at(breaks, coefficients, feet[i])
        residuals[3 * i] = weights[i] * (joints[i + 1, 0] - px)
        residuals[3 * i + 1] = weights[i] * (joints[i + 1, 1] - py)
        residuals[3 * i + 2] = weights[i] * (joints[i + 1, 2] - pz)
        for k in range(3):
            cost += 0.5 * residuals[3 * i + k] ** 2
    return cost


@kernel(fastmath={"contract", "reassoc"})
def _normal_equations(slopes: NDArray, residuals: NDArray, square: NDArray, gradient: NDArray) -> None:
    """JᵀJ (lower half) and Jᵀr from the rows of Jᵀ."""
    for a in range(gradient.size):
        gradient[a] = np.dot(slopes[a], residuals)
        for b in range(a + 1):
            total = 0.0
            for k in range(residuals.size):
                total += slopes[a, k] * slopes[b, k]
            square[a, b] = total


@kernel()
def _solve_damped(square: NDArray, gradient: NDArray, damping: float, free: NDArray, step: NDArray) -> bool:
    """Solve (JᵀJ + damping diag) step = -gradient for the free variables by Cholesky's method."""
    size = gradient.size
    lower = np.empty((size, size))
    for a in range(size):
        for b in range(a + 1):
            total = square[a, b] if free[a] and free[b] else 0.0
            if a == b:
                total = total * (1.0 + damping) + 1e-15 if free[a] else 1.0
            for k in range(b):
                total -= lower[a, k] * lower[b, k]
            if a == b:
                if not total > 0.0:
                    return False
                lower[a, a] = math.sqrt(total)
            else:
                lower[a, b] = total / lower[b, b]
    for a in range(size):
        total = -gradient[a] if free[a] else 0.0
        for k in range(a):
            total -= lower[a, k] * step[k]
        step[a] = total / lower[a, a]
    for a in range(size - 1, -1, -1):
        total = step[a]
        for k in range(a + 1, size):
            total -= lower[k, a] * step[k]
        step[a] = total / lower[a, a]
    return True


@kernel()
def minimise(
    pieces: Pieces, at: Base, arm: Arm, angles: NDArray, feet: NDArray, joints: NDArray, evaluations: NDArray
) -> float:
    """Turn the joints until their weighted squared distances to the path are smallest within the limits.

    Changes the angles (n, 2), the parameters of the closest points (n,) and the joints (n+1, 3) in place.
    Returns the norm (m) of the weighted distances that are left.
    """
    base, frame = at
    lengths, limits, weights = arm
    links = lengths.size
    axes, other = np.empty((links, 2, 3)), np.empty((links + 1, 3))
    residuals, moved = np.empty(3 * links), np.empty(3 * links)
    slopes, square = np.empty((2 * links, 3 * links)), np.empty((2 * links, 2 * links))
    gradient, step, free = np.empty(2 * links), np.empty(2 * links), np.empty(2 * links, np.bool_)
    for i in range(links):
        for k in range(2):
            angles[i, k] = min(max(angles[i, k], limits[i, k, 0]), limits[i, k, 1])
    placed(base, frame, lengths, angles, joints, axes)
    cost = _distances(pieces, joints, weights, feet, residuals)
    evaluations[0] += links
    damping, fresh = 1e-6, True
    for _ in range(_TRIES):
        if cost < 0.5 * _CLOSE**2:
            break
        if fresh:
            for a in range(2 * links):
                i, k = a // 2, a % 2
                kept = angles[i, k]
                angles[i, k] = kept + _DIFFERENCE
                placed(base, frame, lengths, angles, other, axes)
                angles[i, k] = kept
                trial = feet.copy()
                _distances(pieces, other, weights, trial, moved)
                slopes[a] = (moved - residuals) / _DIFFERENCE
            evaluations[0] += 2 * links * links
            _normal_equations(slopes, residuals, square, gradient)
            for a in range(2 * links):
                angle, low, high = angles[a // 2, a % 2], limits[a // 2, a % 2, 0], limits[a // 2, a % 2, 1]
                free[a] = not ((angle >= high and gradient[a] < 0.0) or (angle <= low and gradient[a] > 0.0))
        if not _solve_damped(square, gradient, damping, free, step):
            damping, fresh = max(10.0 * damping, 1e-9), False
            continue
        tried, largest = angles.copy(), 0.0
        for a in range(2 * links):
            i, k = a // 2, a % 2
            tried[i, k] = min(max(angles[i, k] + step[a], limits[i, k, 0]), limits[i, k, 1])
            largest = max(largest, abs(tried[i, k] - angles[i, k]))
        placed(base, frame, lengths, tried, other, axes)
        trial = feet.copy()
        lower = _distances(pieces, other, weights, trial, moved)
        evaluations[0] += links
        fresh = lower < cost
        if fresh:
            angles[:], feet[:], joints[:], residuals[:] = tried, trial, other, moved
            damping *= 0.1
            little = cost - lower < 1e-12 * cost
            cost = lower
            if little:
                break
        else:
            damping *= 10.0
        if largest < _STILL:
            break
    return math.sqrt(2.0 * cost)
