"""The end of a single arc on the path, in closed form but for one unknown: what `sections` does of lone arcs.

The arc that leaves P in the direction T and ends at r(u), which is x ahead along T and y beside, has the length

    θ (x² + y²)/y = L ,   θ = atan2(y, x) ,

and its end points along 2 (û·T) û - T, with û the chord's direction. Newton's method finds u; its last step is carried
out on the second-order expansion of the length f(u). With q = θ/y, p = (x - (x² + y²) q)/y², and a = T·r', m = b·r' of
the chord's part b across T,

    f'  = (2xq - 1) a + (p + 2q) m ,
    f'' = 2 (aq + xq') a + (2xq - 1) T·r'' + (p' + 2q') m + (p + 2q) (r'·r' - a² + b·r'') ,
    q'  = (p m - a)/(x² + y²) ,   p' = 2 a (p + q)/x - m (2q + 3p)/y² .
"""

from __future__ import annotations

import math

from numpy.typing import NDArray

from hognose.following.crossing import Traced
from hognose.kernels import kernel
from hognose.path.polynomial import evaluate

#: Newton's method ends with a step so small, in m and in lengths of the arc, or after so many: what the expansion
#: leaves out is of the order of the step's third power.
_LAST, _LAST_PART, _MOST = 1e-5, 1e-4, 12


# Inlined, or references to arrays would be counted in every call, which takes longer than the arc.
@kernel(inline="always")
def arc_solved(
    curve: Traced, length: float, start: NDArray, frame: NDArray, guess: float, segment: int, found: NDArray
) -> int:
    """Newton's method for an arc's end from a guess of u and its segment; `found` (6,) gets u and the place.

    Returns the segment, or -1 where it does not converge.
    """
    breaks, coefficients, _, evaluations = curve
    u, last, enough = guess, coefficients.shape[0] - 1, min(_LAST, _LAST_PART * length) ** 2
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
            third = -per_x * per_x * per_x * (4 / 15 - t * (8 / 35 - t * 12 / 63))
        else:
            y = math.sqrt(yy)
            per_y = math.atan2(y, x) / y
            beside = (x - square * per_y) / yy
            third = (2.0 * per_y + 3.0 * beside) / yy
        ahead, across = tx * vx + ty * vy + tz * vz, bx * vx + by * vy + bz * vz
        by_x, by_across = 2.0 * x * per_y - 1.0, beside + 2.0 * per_y
        slope = by_x * ahead + by_across * across
        if not slope > 0.0:
            return -1
        step = (length - square * per_y) / slope
        speed = vx * vx + vy * vy + vz * vz
        if step * step * speed < enough:
            turned = (beside * across - ahead) / square  # q'
            bent = 2.0 * ahead * (beside + per_y) * per_x - across * third + 2.0 * turned
            second = (ahead * per_y + x * turned) * ahead + by_x * (tx * ax + ty * ay + tz * az)
            second += 0.5 * (bent * across + by_across * (speed - ahead * ahead))
            second += by_across * (bx * ax + by * ay + bz * az)  # half of f''
            part = second / slope * step
            step -= step * part * (1.0 - 2.0 * part)
            found[0] = u + step
            found[3] = px + step * (vx + step * ax)
            found[4] = py + step * (vy + step * ay)
            found[5] = pz + step * (vz + step * az)
            return segment
        u += step
    return -1


@kernel(inline="always")
def carry(frame: NDArray, start: NDArray, found: NDArray, first: int) -> None:
    """Turn the rows from the first on of a frame (3, 3) from an arc's start to its end, whose place is in `found`.

    By half a turn about T and then half a turn about the chord, which is twice the angle between them.
    """
    cx, cy, cz = found[3] - start[0], found[4] - start[1], found[5] - start[2]
    per = 2.0 / (cx * cx + cy * cy + cz * cz)
    frame[2, 0], frame[2, 1], frame[2, 2] = -frame[2, 0], -frame[2, 1], -frame[2, 2]
    for row in range(first, 3):
        along = per * (cx * frame[row, 0] + cy * frame[row, 1] + cz * frame[row, 2])
        frame[row, 0] -= along * cx
        frame[row, 1] -= along * cy
        frame[row, 2] -= along * cz
