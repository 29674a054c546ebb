"""B-spline bases as matrices: what the constructors of paths are solved with.

SciPy has all of this, but importing its interpolation package costs more than planning a whole motion.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.path.quadrature import gauss_legendre

Array = NDArray[np.float64]


def clamped_knots(breaks: Array, degree: int) -> Array:
    """Knots of all splines of `degree` with degree - 1 continuous derivatives at the inner breaks."""
    return np.concatenate([np.full(degree, breaks[0]), breaks, np.full(degree, breaks[-1])])


def basis(knots: Array, degree: int, u: Array) -> Array:
    """Values (len(u), count) of the basis functions (Cox–de Boor), continuous from the right.

    The last knot belongs to the last interval.
    """
    last = np.flatnonzero(np.diff(knots) > 0)[-1]
    interval = np.clip(np.searchsorted(knots, u, side="right") - 1, 0, last)
    values = np.zeros((len(u), len(knots) - 1))
    values[np.arange(len(u)), interval] = 1.0
    for p in range(1, degree + 1):
        left, right = knots[: -p - 1], knots[p + 1 :]
        rise, fall = knots[p:-1] - left, right - knots[1:-p]
        with np.errstate(divide="ignore", invalid="ignore"):
            up = np.where(rise > 0, (u[:, None] - left) / rise, 0.0)
            down = np.where(fall > 0, (right - u[:, None]) / fall, 0.0)
        values = up * values[:, :-1] + down * values[:, 1:]
    return values


def derivative_matrix(knots: Array, degree: int, order: int) -> Array:
    """The matrix from control points to those of the derivative of this order.

    The derivative is a spline of degree `degree - order` on the knots without their first and last `order`.
    """
    matrix = np.eye(len(knots) - degree - 1)
    for p in range(degree, degree - order, -1):
        inner = knots[degree - p : len(knots) - (degree - p)]
        span = inner[p + 1 : -1] - inner[1 : -p - 1]
        scale = np.divide(p, span, out=np.zeros_like(span), where=span > 0)
        matrix = scale[:, None] * np.diff(matrix, axis=0)
    return matrix


def derivative_basis(knots: Array, degree: int, order: int, u: Array) -> Array:
    """Rows that give the derivative of this order at `u` when multiplied with the control points."""
    inner = knots[order : len(knots) - order]
    return basis(inner, degree - order, u) @ derivative_matrix(knots, degree, order)


def energy(knots: Array, degree: int, order: int) -> Array:
    """The Gram matrix of ∫ |derivative of this order|² over the whole spline."""
    breaks = np.unique(knots)
    nodes, weights = gauss_legendre(max(1, degree - order + 1))
    half = np.diff(breaks)[:, None] / 2
    u = (breaks[:-1, None] + half * (nodes + 1)).ravel()
    rows = derivative_basis(knots, degree, order, u)
    return rows.T @ (rows * (half * weights).ravel()[:, None])


def power_coefficients(knots: Array, degree: int, control_points: Array) -> Array:
    """Coefficients (segments, degree+1, 3) of ascending powers of the distance from each segment's start."""
    starts = np.unique(knots)[:-1]
    return np.stack(
        [
            derivative_basis(knots, degree, order, starts) @ control_points / math.factorial(order)
            for order in range(degree + 1)
        ],
        axis=1,
    )
