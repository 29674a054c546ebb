"""Compiled parts of arms whose sections are rows of pieces: where a section ends, and which angles lead where.

The pieces of an arm are a table (q, 4): the shares of α and β, the length (m), and 1 where it is curved. A section has
the rows from `low` to `high`. What a piece is: `hognose.robot.sections.kind.Piece`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.robot.kinematics import turned

#: Rows of what `end_of` finds: the end, the axes of its frame, derivatives of the end by α and β, turns by α and β.
END, X, Y, Z, BY_ALPHA, BY_BETA, TURN_ALPHA, TURN_BETA, ROWS = 0, 1, 2, 3, 4, 5, 6, 7, 8
#: Newton's method for the angles of a direction ends with a step (rad) so small, or after so many; none is longer.
_SMALL, _MOST, _LONGEST = 1e-8, 40, 0.5


@kernel(inline="always")
def arc_terms(t: float) -> Any:
    """(1 - cos θ)/θ², sin θ/θ, (θ - sin θ)/θ³, and the derivatives of the first two by t, for θ² = t."""
    if t < 0.1:
        a = 0.5 - t * (1 / 24 - t * (1 / 720 - t * (1 / 40320 - t * (1 / 3628800 - t / 479001600))))
        b = 1.0 - t * (1 / 6 - t * (1 / 120 - t * (1 / 5040 - t * (1 / 362880 - t / 39916800))))
        c = 1 / 6 - t * (1 / 120 - t * (1 / 5040 - t * (1 / 362880 - t * (1 / 39916800 - t / 6227020800))))
        da = -1 / 24 + t * (2 / 720 - t * (3 / 40320 - t * (4 / 3628800 - t * 5 / 479001600)))
        db = -1 / 6 + t * (2 / 120 - t * (3 / 5040 - t * (4 / 362880 - t * 5 / 39916800)))
        return a, b, c, da, db
    angle = math.sqrt(t)
    half = math.sin(0.5 * angle)
    a, b = 2.0 * half * half / t, math.sin(angle) / angle
    return a, b, (1.0 - b) / t, (0.5 * b - a) / t, 0.5 * (1.0 - a * t - b) / t


@kernel(inline="always")
def moved(out: NDArray, row: int, x: float, y: float, z: float) -> None:
    """Add the vector (x, y, z) of the frame's axes to a row."""
    for k in range(3):
        out[row, k] += x * out[X, k] + y * out[Y, k] + z * out[Z, k]


@kernel(inline="always")
def crossed(out: NDArray, row: int, turn: int, x: float, y: float, z: float) -> None:
    """Add turn × (x, y, z) to a row, both in the axes of the section's beginning."""
    out[row, 0] += out[turn, 1] * z - out[turn, 2] * y
    out[row, 1] += out[turn, 2] * x - out[turn, 0] * z
    out[row, 2] += out[turn, 0] * y - out[turn, 1] * x


@kernel(inline="always")
def turn_frame(out: NDArray, a: float, b: float) -> None:
    """Turn the frame of `out` by R_y(a) R_x(b)."""
    xx, xy, xz, yx, yy, yz, zx, zy, zz = turned(
        out[1, 0], out[1, 1], out[1, 2], out[2, 0], out[2, 1], out[2, 2], out[3, 0], out[3, 1], out[3, 2], a, b
    )
    out[1, 0], out[1, 1], out[1, 2] = xx, xy, xz
    out[2, 0], out[2, 1], out[2, 2] = yx, yy, yz
    out[3, 0], out[3, 1], out[3, 2] = zx, zy, zz


@kernel(inline="always")
def bend_frame(out: NDArray, a: float, b: float, ca: float, cb: float) -> None:
    """Turn the frame of `out` by exp(a e_y + b e_x); ca and cb are the first two of `arc_terms`."""
    for k in range(3):
        x, y, z = out[X, k], out[Y, k], out[Z, k]
        out[X, k] = (1.0 - ca * a * a) * x + ca * a * b * y - cb * a * z
        out[Y, k] = ca * a * b * x + (1.0 - ca * b * b) * y + cb * b * z
        out[Z, k] = cb * a * x - cb * b * y + (1.0 - ca * (a * a + b * b)) * z


@kernel()
def passed(sa: float, sb: float, length: float, curved: bool, alpha: float, beta: float, out: NDArray) -> None:
    """Carry `out`, which is at the beginning of a piece, to the piece's end: see `end_of`."""
    a, b = sa * alpha, sb * beta
    if not curved:
        if sa != 0.0:
            for k in range(3):
                out[TURN_ALPHA, k] += sa * out[Y, k]
        turn_frame(out, a, b)
        if sb != 0.0:
            for k in range(3):
                out[TURN_BETA, k] += sb * out[X, k]
        x, y, z = length * out[Z, 0], length * out[Z, 1], length * out[Z, 2]
        crossed(out, BY_ALPHA, TURN_ALPHA, x, y, z)
        crossed(out, BY_BETA, TURN_BETA, x, y, z)
        out[END, 0], out[END, 1], out[END, 2] = out[END, 0] + x, out[END, 1] + y, out[END, 2] + z
    else:
        ca, cb, cc, da, db = arc_terms(a * a + b * b)
        ex, ey, ez = length * a * ca, -length * b * ca, length * cb
        x = ex * out[X, 0] + ey * out[Y, 0] + ez * out[Z, 0]
        y = ex * out[X, 1] + ey * out[Y, 1] + ez * out[Z, 1]
        z = ex * out[X, 2] + ey * out[Y, 2] + ez * out[Z, 2]
        crossed(out, BY_ALPHA, TURN_ALPHA, x, y, z)
        crossed(out, BY_BETA, TURN_BETA, x, y, z)
        la, lb = sa * length, sb * length
        moved(out, BY_ALPHA, la * (ca + 2.0 * a * a * da), -la * 2.0 * a * b * da, la * 2.0 * a * db)
        moved(out, BY_BETA, lb * 2.0 * a * b * da, -lb * (ca + 2.0 * b * b * da), lb * 2.0 * b * db)
        moved(out, TURN_ALPHA, sa * cc * a * b, sa * (1.0 - cc * b * b), sa * ca * b)
        moved(out, TURN_BETA, sb * (1.0 - cc * a * a), sb * cc * a * b, -sb * ca * a)
        out[END, 0], out[END, 1], out[END, 2] = out[END, 0] + x, out[END, 1] + y, out[END, 2] + z
        bend_frame(out, a, b, ca, cb)


@kernel()
def end_of(table: NDArray, low: int, high: int, alpha: float, beta: float, out: NDArray) -> None:
    """Fill `out` (ROWS, 3) with where a section ends, seen from its beginning, and how that changes with its angles."""
    out[:ROWS] = 0.0
    out[X, 0], out[Y, 1], out[Z, 2] = 1.0, 1.0, 1.0
    for p in range(low, high):
        passed(table[p, 0], table[p, 1], table[p, 2], table[p, 3] != 0.0, alpha, beta, out)


@kernel(inline="always")
def first_guess(table: NDArray, low: int, high: int, gain_a: float, gain_b: float, x: float, y: float, z: float) -> Any:
    """Angles with which a section ends about in the direction (x, y, z); and whether they are exactly right."""
    alone = high - low == 1 and table[low, 0] == 1.0 and table[low, 1] == 1.0
    across = math.sqrt(x * x + y * y)
    if (alone and table[low, 3] == 0.0) or table[low, 1] == 0.0:
        return math.atan2(x, z), math.atan2(-y, math.sqrt(x * x + z * z)) / gain_b, alone
    angle = math.atan2(across, z)
    if across == 0.0:
        return (0.0 if z > 0.0 else math.pi), 0.0, alone
    return angle * x / across / gain_a, -angle * y / across / gain_b, alone


@kernel()
def towards(
    table: NDArray, low: int, high: int, gains: NDArray, x: float, y: float, z: float, out: NDArray
) -> tuple[float, float, float]:
    """Angles with which a section ends in a direction, and how far away it ends then; NaN if none are found.

    `gains` (2,) are how far the direction of the end turns with α and β near zero; `out` as of `end_of`.
    """
    size = math.sqrt(x * x + y * y + z * z)
    x, y, z = x / size, y / size, z / size
    alpha, beta, exact = first_guess(table, low, high, gains[0], gains[1], x, y, z)
    for _ in range(_MOST):
        end_of(table, low, high, alpha, beta, out)
        along = out[END, 0] * x + out[END, 1] * y + out[END, 2] * z
        if exact:
            return alpha, beta, along
        fx, fy, fz = out[END, 0] - along * x, out[END, 1] - along * y, out[END, 2] - along * z
        ax, ay, az = out[BY_ALPHA, 0], out[BY_ALPHA, 1], out[BY_ALPHA, 2]
        bx, by, bz = out[BY_BETA, 0], out[BY_BETA, 1], out[BY_BETA, 2]
        a_along, b_along = ax * x + ay * y + az * z, bx * x + by * y + bz * z
        ax, ay, az = ax - a_along * x, ay - a_along * y, az - a_along * z
        bx, by, bz = bx - b_along * x, by - b_along * y, bz - b_along * z
        aa, ab, bb = ax * ax + ay * ay + az * az, ax * bx + ay * by + az * bz, bx * bx + by * by + bz * bz
        fa, fb = ax * fx + ay * fy + az * fz, bx * fx + by * fy + bz * fz
        square = aa * bb - ab * ab
        if not square > 1e-12 * (aa + bb) * (aa + bb):
            break
        step_a, step_b = (ab * fb - bb * fa) / square, (ab * fa - aa * fb) / square
        step = math.sqrt(step_a * step_a + step_b * step_b)
        scale = min(1.0, _LONGEST / step) if step > 0.0 else 1.0
        alpha, beta = alpha + scale * step_a, beta + scale * step_b
        if step < _SMALL:
            ahead = along + a_along * step_a + b_along * step_b
            return (alpha, beta, ahead) if ahead > 0.0 else (math.nan, math.nan, math.nan)
    return math.nan, math.nan, math.nan


@kernel()
def angles_along(
    joints: NDArray, table: NDArray, first: NDArray, gains: NDArray, out: NDArray, work: NDArray
) -> tuple[int, int]:
    """Angles (T, n, 2) of joints (T, n+1, 3). Returns the step and the section that has none, or (-1, -1)."""
    frame = work[ROWS:]
    for t in range(joints.shape[0]):
        frame[:] = 0.0
        frame[0, 0], frame[1, 1], frame[2, 2] = 1.0, 1.0, 1.0
        for i in range(out.shape[1]):
            dx = joints[t, i + 1, 0] - joints[t, i, 0]
            dy = joints[t, i + 1, 1] - joints[t, i, 1]
            dz = joints[t, i + 1, 2] - joints[t, i, 2]
            if dx * dx + dy * dy + dz * dz < 1e-18:
                return t, i
            x = dx * frame[0, 0] + dy * frame[0, 1] + dz * frame[0, 2]
            y = dx * frame[1, 0] + dy * frame[1, 1] + dz * frame[1, 2]
            z = dx * frame[2, 0] + dy * frame[2, 1] + dz * frame[2, 2]
            alpha, beta, _ = towards(table, first[i], first[i + 1], gains[i], x, y, z, work)
            if math.isnan(alpha):
                return t, i
            out[t, i, 0], out[t, i, 1] = alpha, beta
            end_of(table, first[i], first[i + 1], alpha, beta, work)
            frame_after(frame, work)
    return -1, -1


@kernel(inline="always")
def frame_after(frame: NDArray, work: NDArray) -> None:
    """Turn a frame (3, 3), whose rows are its axes, by that of a section's end."""
    for k in range(3):
        x, y, z = frame[0, k], frame[1, k], frame[2, k]
        frame[0, k] = work[X, 0] * x + work[X, 1] * y + work[X, 2] * z
        frame[1, k] = work[Y, 0] * x + work[Y, 1] * y + work[Y, 2] * z
        frame[2, k] = work[Z, 0] * x + work[Z, 1] * y + work[Z, 2] * z


@kernel()
def placed_along(
    angles: NDArray,
    feeds: NDArray,
    table: NDArray,
    first: NDArray,
    work: NDArray,
    joints: NDArray,
    frames: NDArray,
    scales: NDArray | None = None,
) -> None:
    """Joints (T, n+1, 3) and frames of the tip (T, 3, 3), axes in columns, of angles (T, n, 2) and feeds (T,).

    Sections are `scales` (T, n) times as long as in the table, if that is given.
    """
    frame = work[ROWS:]
    for t in range(angles.shape[0]):
        frame[:] = 0.0
        frame[0, 0], frame[1, 1], frame[2, 2] = 1.0, 1.0, 1.0
        joints[t, 0, 0], joints[t, 0, 1], joints[t, 0, 2] = 0.0, 0.0, feeds[t]
        for i in range(angles.shape[1]):
            end_of(table, first[i], first[i + 1], angles[t, i, 0], angles[t, i, 1], work)
            if scales is not None:
                for k in range(3):
                    work[END, k] *= scales[t, i]
            for k in range(3):
                joints[t, i + 1, k] = joints[t, i, k] + (
                    work[END, 0] * frame[0, k] + work[END, 1] * frame[1, k] + work[END, 2] * frame[2, k]
                )
            frame_after(frame, work)
        for j in range(3):
            for k in range(3):
                frames[t, k, j] = frame[j, k]


@kernel()
def vertices_along(
    angles: NDArray,
    joints: NDArray,
    table: NDArray,
    counts: NDArray,
    first: NDArray,
    out: NDArray,
    scales: NDArray | None = None,
) -> None:
    """Ends (T, p+1, 3) of the chords, `counts` (q,) a piece; a section's own begin at its joint (T, n+1, 3).

    Sections are `scales` (T, n) times as long as in the table, if that is given.
    """
    state = np.empty((ROWS, 3))
    for t in range(angles.shape[0]):
        state[:] = 0.0
        state[X, 0], state[Y, 1], state[Z, 2] = 1.0, 1.0, 1.0
        out[t, 0] = joints[t, 0]
        at = 0
        for i in range(angles.shape[1]):
            state[END] = joints[t, i]
            for p in range(first[i], first[i + 1]):
                a, b, length = table[p, 0] * angles[t, i, 0], table[p, 1] * angles[t, i, 1], table[p, 2]
                if scales is not None:
                    length *= scales[t, i]
                count = counts[p]
                if table[p, 3] == 0.0:
                    turn_frame(state, a, b)
                    moved(state, END, 0.0, 0.0, length)
                    at += 1
                    out[t, at] = state[END]
                    continue
                for j in range(1, count + 1):
                    part = j / count
                    ca, cb, _, _, _ = arc_terms((a * a + b * b) * part * part)
                    state[BY_ALPHA] = state[END]
                    reach = length * part
                    moved(state, BY_ALPHA, reach * a * part * ca, -reach * b * part * ca, reach * cb)
                    at += 1
                    out[t, at] = state[BY_ALPHA]
                ca, cb, _, _, _ = arc_terms(a * a + b * b)
                state[END] = out[t, at]
                bend_frame(state, a, b, ca, cb)
            out[t, at] = joints[t, i + 1]
