"""Evaluation of piecewise polynomials inside compiled loops."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel

#: Breaks (S+1,) and coefficients (S, k+1, 3) of a piecewise polynomial.
Pieces = tuple[NDArray, NDArray]


@kernel(fastmath={"contract"}, inline="always")
def evaluate(coefficients: NDArray, segment: int, h: float) -> Any:
    """Position, first derivative and half the second derivative on one segment (Horner)."""
    j = coefficients.shape[1] - 1
    px, py, pz = coefficients[segment, j, 0], coefficients[segment, j, 1], coefficients[segment, j, 2]
    vx, vy, vz = 0.0, 0.0, 0.0
    ax, ay, az = 0.0, 0.0, 0.0
    while j > 0:
        j -= 1
        ax, ay, az = ax * h + vx, ay * h + vy, az * h + vz
        vx, vy, vz = vx * h + px, vy * h + py, vz * h + pz
        px = px * h + coefficients[segment, j, 0]
        py = py * h + coefficients[segment, j, 1]
        pz = pz * h + coefficients[segment, j, 2]
    return px, py, pz, vx, vy, vz, ax, ay, az


@kernel(inline="always")
def evaluate_at(breaks: NDArray, coefficients: NDArray, u: float) -> Any:
    """As `evaluate`, at a parameter."""
    segment = segment_at(breaks, u)
    return evaluate(coefficients, segment, u - breaks[segment])


@kernel()
def segment_at(breaks: NDArray, u: float) -> int:
    """The segment that holds a parameter; the first or the last one for parameters outside."""
    return min(max(int(np.searchsorted(breaks, u, side="right")) - 1, 0), breaks.size - 2)
