"""The law that aims a section's end and its direction at the path, so that directions do not ring.

What `hognose.following.sections` adds to the equation of an end on the path: λ L across(T - t - ē). On a path of slowly
changing curvature, ends on the path and no ringing leave the direction of a stack of k joints beside the tangent by

    ē = -L t′/2k - L² t″ (1/12 - 1/4k²) ,

derivatives by arc length: the last link is behind the tangent by half a bend, and an arc turns too little or too much
where the path's curvature changes along it [derived]. t″ is taken from a second difference over the section's length.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.following.crossing import Traced
from hognose.kernels import kernel
from hognose.path.polynomial import evaluate, segment_at
from hognose.robot.sections.chain import TURN_ALPHA, TURN_BETA, Z


@kernel(fastmath={"contract"})
def _tangent(curve: Traced, u: float, out: NDArray) -> None:
    """Unit tangent (3,) at a parameter."""
    breaks, coefficients, _, _ = curve
    segment = segment_at(breaks, u)
    _, _, _, vx, vy, vz, _, _, _ = evaluate(coefficients, segment, u - breaks[segment])
    size = math.sqrt(vx * vx + vy * vy + vz * vz)
    out[0], out[1], out[2] = vx / size, vy / size, vz / size


@kernel(fastmath={"contract"})
def aimed(
    curve: Traced,
    u: float,
    path: NDArray,
    inverse: float,
    length: float,
    weight: float,
    columns: NDArray,
    work: NDArray,
) -> None:
    """Add what the law has besides the end on the path to the equations' columns (4, 3): by α, β, u, and the rest.

    `path` (3, 3) is the place, its derivative and half the second one at u; `work` has the directions outside.
    """
    speed = math.sqrt(path[1, 0] ** 2 + path[1, 1] ** 2 + path[1, 2] ** 2)
    tangent, along = path[1] / speed, 0.0
    for k in range(3):
        along += 2.0 * path[2, k] * tangent[k]
    slope = (2.0 * path[2] - along * tangent) / speed  # of the tangent, by u
    before, after = np.empty(3), np.empty(3)
    _tangent(curve, u - 0.5 * length / speed, before)
    _tangent(curve, u + 0.5 * length / speed, after)
    off = np.empty(3)
    for k in range(3):
        ideal = -0.5 * inverse * length * slope[k] / speed
        ideal -= (1.0 / 3.0 - inverse * inverse) * (before[k] - 2.0 * tangent[k] + after[k])
        off[k] = work[Z, k] - ideal
    for turn, column in ((TURN_ALPHA, 0), (TURN_BETA, 1)):
        turned = np.zeros((1, 3))
        _cross(work, turn, turned)
        beside = turned[0, 0] * tangent[0] + turned[0, 1] * tangent[1] + turned[0, 2] * tangent[2]
        for k in range(3):
            columns[column, k] += weight * (turned[0, k] - beside * tangent[k])
    forward = off[0] * tangent[0] + off[1] * tangent[1] + off[2] * tangent[2]
    tilt = off[0] * slope[0] + off[1] * slope[1] + off[2] * slope[2]
    for k in range(3):
        columns[2, k] -= weight * (forward * slope[k] + tilt * tangent[k])
        columns[3, k] += weight * (off[k] - forward * tangent[k])


@kernel(inline="always")
def _cross(work: NDArray, turn: int, out: NDArray) -> None:
    """The derivative of the end's direction by an angle."""
    out[0, 0] = work[turn, 1] * work[Z, 2] - work[turn, 2] * work[Z, 1]
    out[0, 1] = work[turn, 2] * work[Z, 0] - work[turn, 0] * work[Z, 2]
    out[0, 2] = work[turn, 0] * work[Z, 1] - work[turn, 1] * work[Z, 0]
