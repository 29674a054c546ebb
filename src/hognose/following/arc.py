"""The end of a single arc on the path, in closed form but for one unknown: what `sections` does of lone arcs.

The arc that leaves P in the direction T and ends at r(u), which is x ahead along T and y beside, has the length

    θ (x² + y²)/y = L ,   θ = atan2(y, x) ,

and its end points along 2 (û·T) û - T, with û the chord's direction. Newton's method finds u.
"""

from __future__ import annotations

import math

from numpy.typing import NDArray

from hognose.following.crossing import Traced
from hognose.kernels import kernel
from hognose.path.polynomial import evaluate

#: Newton's method ends with a step of which the square is so small a part of the arc's, or after so many.
_LAST, _MOST = 1e-14, 12


@kernel(fastmath={"contract"}, error_model="numpy")
def arc_solved(
    curve: Traced, length: float, start: NDArray, frame: NDArray, guess: float, segment: int, found: NDArray
) -> int:
    """Newton's method for an arc's end from a guess of u and its segment; `found` (6,) gets u and the place.

    Returns the segment, or -1 where it does not converge.
    """
    breaks, coefficients, _, evaluations = curve
    u, last = guess, coefficients.shape[0] - 1
    tx, ty, tz = frame[2, 0], frame[2, 1], frame[2, 2]
    for _ in range(_MOST):
        evaluations[0] += 1
        while segment < last and u >= breaks[segment + 1]:
            segment += 1
        while segment > 0 and u < breaks[segment]:
            segment -= 1
        px, py, pz, vx, vy, vz, ax, ay, az = evaluate(coefficients, segment, u - breaks[segment])
        cx, cy, cz = px - start[0], py - start[1], pz - start[2]
        x = cx * tx + cy * ty + cz * tz
        bx, by, bz = cx - x * tx, cy - x * ty, cz - x * tz
        yy = bx * bx + by * by + bz * bz
        square = x * x + yy
        per_x = 1.0 / x
        t = yy * per_x * per_x
        if x > 0.0 and t < 0.02:  # series of θ/y and of (x - D θ/y)/y², D = x² + y²
            per_y = 1 / 9 - t * (1 / 11 - t * (1 / 13 - t * (1 / 15 - t / 17)))
            per_y = per_x * (1.0 - t * (1 / 3 - t * (1 / 5 - t * (1 / 7 - t * per_y))))
            beside = -per_x * (2 / 3 - t * (2 / 15 - t * (2 / 35 - t * (2 / 63 - t * 2 / 99))))
        else:
            y = math.sqrt(yy)
            per_y = math.atan2(y, x) / y
            beside = (x - square * per_y) / yy
        ahead = tx * vx + ty * vy + tz * vz
        slope = (2.0 * x * per_y - 1.0) * ahead + (beside + 2.0 * per_y) * (bx * vx + by * vy + bz * vz)
        if not slope > 0.0:
            return -1
        step = (length - square * per_y) / slope
        u += step
        if step * step * (vx * vx + vy * vy + vz * vz) < _LAST * length * length:
            found[0] = u
            found[3] = px + step * (vx + step * ax)
            found[4] = py + step * (vy + step * ay)
            found[5] = pz + step * (vz + step * az)
            return segment
    return -1


@kernel(fastmath={"contract"}, error_model="numpy")
def carry(frame: NDArray, start: NDArray, found: NDArray) -> None:
    """Turn a frame (3, 3), axes in rows, from an arc's start to its end, whose place is in `found`.

    By half a turn about T and then half a turn about the chord, which is twice the angle between them.
    """
    cx, cy, cz = found[3] - start[0], found[4] - start[1], found[5] - start[2]
    per = 2.0 / (cx * cx + cy * cy + cz * cz)
    frame[2, 0], frame[2, 1], frame[2, 2] = -frame[2, 0], -frame[2, 1], -frame[2, 2]
    for row in range(3):
        along = per * (cx * frame[row, 0] + cy * frame[row, 1] + cz * frame[row, 2])
        frame[row, 0] -= along * cx
        frame[row, 1] -= along * cy
        frame[row, 2] -= along * cz
