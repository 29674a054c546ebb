"""The law that aims a section's end and its direction at the path, so that directions do not ring.

What `hognose.following.sections` adds to the equation of an end on the path: λ L across(T - t - ē). On a path of slowly
changing curvature, ends on the path and no ringing leave the direction of a stack of k joints beside the tangent by

    ē = -L t′/2k - L² t″ (1/12 - 1/4k²) ,

derivatives by arc length: the last link is behind the tangent by half a bend, and an arc turns too little or too much
where the path's curvature changes along it [derived]. t″ is taken from a second difference over the section's length.
"""

from __future__ import annotations

import math
from typing import Any

from numpy.typing import NDArray

from hognose.following.crossing import Traced
from hognose.kernels import kernel
from hognose.path.polynomial import evaluate, segment_at
from hognose.robot.sections.chain import TURN_ALPHA, Z


@kernel(fastmath={"contract"})
def _tangent(curve: Traced, u: float) -> Any:
    """Unit tangent at a parameter."""
    breaks, coefficients, _, _ = curve
    segment = segment_at(breaks, u)
    _, _, _, vx, vy, vz, _, _, _ = evaluate(coefficients, segment, u - breaks[segment])
    size = math.sqrt(vx * vx + vy * vy + vz * vz)
    return vx / size, vy / size, vz / size


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
    vx, vy, vz = path[1, 0], path[1, 1], path[1, 2]
    speed = math.sqrt(vx * vx + vy * vy + vz * vz)
    tx, ty, tz = vx / speed, vy / speed, vz / speed
    along = path[2, 0] * tx + path[2, 1] * ty + path[2, 2] * tz
    scale = 2.0 / speed  # of the tangent's slope by u
    sx, sy, sz = scale * (path[2, 0] - along * tx), scale * (path[2, 1] - along * ty), scale * (path[2, 2] - along * tz)
    bx, by, bz = _tangent(curve, u - 0.5 * length / speed)
    ax, ay, az = _tangent(curve, u + 0.5 * length / speed)
    first, second = 0.5 * inverse * length / speed, 1.0 / 3.0 - inverse * inverse
    zx, zy, zz = work[Z, 0], work[Z, 1], work[Z, 2]
    ox = zx + first * sx + second * (bx - 2.0 * tx + ax)
    oy = zy + first * sy + second * (by - 2.0 * ty + ay)
    oz = zz + first * sz + second * (bz - 2.0 * tz + az)
    for column in range(2):
        gx, gy, gz = work[TURN_ALPHA + column, 0], work[TURN_ALPHA + column, 1], work[TURN_ALPHA + column, 2]
        dx, dy, dz = gy * zz - gz * zy, gz * zx - gx * zz, gx * zy - gy * zx
        beside = dx * tx + dy * ty + dz * tz
        columns[column, 0] += weight * (dx - beside * tx)
        columns[column, 1] += weight * (dy - beside * ty)
        columns[column, 2] += weight * (dz - beside * tz)
    forward, tilt = ox * tx + oy * ty + oz * tz, ox * sx + oy * sy + oz * sz
    columns[2, 0] -= weight * (forward * sx + tilt * tx)
    columns[2, 1] -= weight * (forward * sy + tilt * ty)
    columns[2, 2] -= weight * (forward * sz + tilt * tz)
    columns[3, 0] += weight * (ox - forward * tx)
    columns[3, 1] += weight * (oy - forward * ty)
    columns[3, 2] += weight * (oz - forward * tz)
