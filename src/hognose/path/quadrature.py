"""Nodes and weights of Gauss-Legendre quadrature.

numpy takes the nodes from an eigenvalue solver, whose last bits differ between processors; these come from Newton's
method in plain arithmetic and are the same everywhere.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

_MOST_STEPS = 20


@cache
def gauss_legendre(count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Nodes (count,) on -1 … 1, ascending, and their weights (count,); not to be changed.

    Newton's method on the Legendre polynomial from Tricomi's estimate of its roots; weights 2 / ((1 - x²) P′(x)²)
    (Abramowitz and Stegun, 25.4.29).
    """
    nodes, weights = np.zeros(count), np.empty(count)
    for k in range((count + 1) // 2):
        middle = 2 * k + 1 == count
        x = 0.0 if middle else math.cos(math.pi * (k + 0.75) / (count + 0.5))
        for _ in range(0 if middle else _MOST_STEPS):
            value, slope = _legendre(count, x)
            step = value / slope
            x -= step
            if abs(step) < 1e-16:
                break
        slope = _legendre(count, x)[1]
        nodes[k], nodes[count - 1 - k] = -x, x
        weights[k] = weights[count - 1 - k] = 2.0 / ((1.0 - x * x) * slope * slope)
    nodes.flags.writeable = weights.flags.writeable = False
    return nodes, weights


def _legendre(degree: int, x: float) -> tuple[float, float]:
    """The Legendre polynomial P and its derivative at -1 < x < 1, by Bonnet's recurrence."""
    before, value = 1.0, x
    for n in range(1, degree):
        before, value = value, ((2 * n + 1) * x * value - n * before) / (n + 1)
    return value, degree * (x * value - before) / (x * x - 1.0)
