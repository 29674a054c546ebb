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

import numpy as np
from numpy.typing import NDArray

from hognose.following.crossing import OVERRUN, REACH, Traced
from hognose.following.recall import recalled, remember
from hognose.following.section_search import FARTHEST, Arm, sought
from hognose.kernels import kernel
from hognose.path.polynomial import evaluate, evaluate_at, segment_at
from hognose.robot.sections.chain import ROWS

#: Newton's method ends with a step so small, in m and in lengths of the arc, or after so many: what the expansion
#: leaves out is of the order of the step's third power.
_LAST, _LAST_PART, _MOST = 1e-5, 1e-4, 12


# Inlined, or references to arrays would be counted in every call, which takes longer than the arc.
@kernel(inline="always")
def arc_solved(
    curve: Traced,
    length: float,
    sx: float,
    sy: float,
    sz: float,
    tx: float,
    ty: float,
    tz: float,
    guess: float,
    segment: int,
) -> tuple[int, float, float, float, float]:
    """Newton's method for the end of an arc that leaves S along T, from a guess of u and its segment.

    Returns the segment, or -1 where it does not converge; u; and the place.
    """
    breaks, coefficients, _, evaluations = curve
    u, last, enough = guess, coefficients.shape[0] - 1, min(_LAST, _LAST_PART * length) ** 2
    for _ in range(_MOST):
        evaluations[0] += 1
        while segment < last and u >= breaks[segment + 1]:
            segment += 1
        while segment > 0 and u < breaks[segment]:
            segment -= 1
        px, py, pz, vx, vy, vz, ax, ay, az = evaluate(coefficients, segment, u - breaks[segment])
        cx, cy, cz = px - sx, py - sy, pz - sz
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
            break
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
            return (
                segment,
                u + step,
                px + step * (vx + step * ax),
                py + step * (vy + step * ay),
                pz + step * (vz + step * az),
            )
        u += step
    return -1, u, 0.0, 0.0, 0.0


@kernel(inline="always")
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


@kernel(fastmath={"contract"}, error_model="numpy")
def _sought_along(
    curve: Traced, arm: Arm, i: int, before: float, start: NDArray, tangent: NDArray, found: NDArray
) -> bool:
    """As `sought`, from a place (3,) along a tangent (3,) alone: an arc bends alike to all sides."""
    frame, least = np.empty((3, 3)), 0
    for k in range(1, 3):
        if abs(tangent[k]) < abs(tangent[least]):
            least = k
    size = math.sqrt(1.0 - tangent[least] ** 2)
    for k in range(3):
        frame[0, k] = ((1.0 if k == least else 0.0) - tangent[least] * tangent[k]) / size
        frame[2, k] = tangent[k]
    for k in range(3):
        m, o = (k + 1) % 3, (k + 2) % 3
        frame[1, k] = frame[2, m] * frame[0, o] - frame[2, o] * frame[0, m]
    return sought(curve, arm, i, before, start, frame, found, np.empty((ROWS, 3)))


@kernel(fastmath={"contract"}, error_model="numpy")
def arcs_advanced(
    curve: Traced,
    arm: Arm,
    tracks: bool,
    bases: NDArray,
    axes: NDArray,
    feeds: NDArray,
    memory: tuple[NDArray, NDArray, NDArray],
    joints: NDArray,
) -> tuple[int, int]:
    """Place the ends of an arm of nothing but single arcs, all on the path; as `_advance` of `sections`.

    Of a frame nothing but the direction counts.
    """
    breaks, coefficients, fastest, _ = curve
    steps, segments, parameters = memory
    lengths = arm[3]
    top_speed, shortest, sections = fastest.max(), lengths.min(), lengths.size
    start, tangent, found = np.empty(3), np.empty(3), np.empty(6)
    for t in range(feeds.size):
        remembers, change, per_feed = recalled(steps[0], feeds[t], tracks)
        remembers = remembers and abs(change) < FARTHEST * shortest
        before, row = bases[t], min(t, axes.shape[0] - 1)
        x, y, z, _, _, _, _, _, _ = evaluate_at(breaks, coefficients, before)
        tx, ty, tz = axes[row, 2, 0], axes[row, 2, 1], axes[row, 2, 2]
        joints[t, 0, 0], joints[t, 0, 1], joints[t, 0, 2], parameters[t, 0] = x, y, z, before
        for i in range(sections):
            segment, px, py, pz = -1, 0.0, 0.0, 0.0
            u = before + steps[0, 0, i] + steps[0, 1, i] * change
            for attempt in range(2):
                if attempt == 0:
                    if not remembers:
                        continue
                    segment = segments[i]
                else:
                    start[0], start[1], start[2], tangent[0], tangent[1], tangent[2] = x, y, z, tx, ty, tz
                    segment = -1
                    if not _sought_along(curve, arm, i, before, start, tangent, found):
                        break
                    u = found[0]
                    segment = segment_at(breaks, u)
                segment, u, px, py, pz = arc_solved(curve, lengths[i], x, y, z, tx, ty, tz, u, segment)
                near = u > before and (u - before) * top_speed < REACH * lengths[i] and u <= breaks[-1] + OVERRUN
                if segment >= 0 and near:
                    break
            if segment < 0:
                steps[0, 0, sections] = math.nan
                return t, i
            remember(steps[0], i, u - before, per_feed)
            segments[i] = segment
            cx, cy, cz = px - x, py - y, pz - z
            along = 2.0 * (cx * tx + cy * ty + cz * tz) / (cx * cx + cy * cy + cz * cz)
            tx, ty, tz = along * cx - tx, along * cy - ty, along * cz - tz
            x, y, z, before = px, py, pz, u
            joints[t, i + 1, 0], joints[t, i + 1, 1], joints[t, i + 1, 2], parameters[t, i + 1] = x, y, z, u
        steps[0, 0, sections] = feeds[t]
    return -1, -1
