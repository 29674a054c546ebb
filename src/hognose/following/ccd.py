"""Cyclic coordinate descent: one joint after another points the tip at its goal (paper ref. 19; Wang & Chen 1991).

From the last joint to the base, all links behind each joint are turned by the smallest rotation that brings the tip
onto the line from the joint to the goal, within the bend limit; pass after pass, until the tip is close enough. The
rotations of a pass are collected and applied to the links once, so a pass costs O(n), not O(n²). The goal is the tip of
exact following at the same feed.

Cost a step: O(n) a pass; tens to thousands of passes. Known weakness: only the tip is on the path, and the joints next
to it take most of the bend, up to their limits; the body leaves the path.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.following.fabrik import within_cone
from hognose.following.tip_only import Cones, Goals, Progress, TipOnly, under_way
from hognose.kernels import kernel


@kernel(inline="always")
def _turn_between(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> Any:
    """The smallest rotation from the unit direction a to b, as a unit quaternion (w, x, y, z); none if opposite."""
    w = 1.0 + ax * bx + ay * by + az * bz
    if w < 1e-12:
        return 1.0, 0.0, 0.0, 0.0
    x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    size = math.sqrt(w * w + x * x + y * y + z * z)
    return w / size, x / size, y / size, z / size


@kernel(inline="always")
def _rotated(w: float, x: float, y: float, z: float, vx: float, vy: float, vz: float) -> Any:
    """A vector turned by a unit quaternion."""
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return (
        vx + w * tx + y * tz - z * ty,
        vy + w * ty + z * tx - x * tz,
        vz + w * tz + x * ty - y * tx,
    )


@kernel()
def _point_at_goal(
    chain: NDArray, frame: NDArray, cosines: NDArray, sines: NDArray, goal: NDArray, turns: NDArray
) -> None:
    """One pass from the last joint to the base: fill the turns (n, 4) of the joints."""
    links = cosines.size
    tx, ty, tz = chain[links, 0], chain[links, 1], chain[links, 2]
    for i in range(links - 1, -1, -1):
        px, py, pz = chain[i, 0], chain[i, 1], chain[i, 2]
        dx, dy, dz = chain[i + 1, 0] - px, chain[i + 1, 1] - py, chain[i + 1, 2] - pz
        size = math.sqrt(dx * dx + dy * dy + dz * dz)
        dx, dy, dz = dx / size, dy / size, dz / size
        ax, ay, az = frame[2, 0], frame[2, 1], frame[2, 2]
        if i > 0:
            ax, ay, az = px - chain[i - 1, 0], py - chain[i - 1, 1], pz - chain[i - 1, 2]
            size = math.sqrt(ax * ax + ay * ay + az * az)
            ax, ay, az = ax / size, ay / size, az / size
        ex, ey, ez = tx - px, ty - py, tz - pz
        gx, gy, gz = goal[0] - px, goal[1] - py, goal[2] - pz
        far, near = math.sqrt(gx * gx + gy * gy + gz * gz), math.sqrt(ex * ex + ey * ey + ez * ez)
        w, x, y, z = 1.0, 0.0, 0.0, 0.0
        if far > 1e-12 and near > 1e-12:
            w, x, y, z = _turn_between(ex / near, ey / near, ez / near, gx / far, gy / far, gz / far)
        nx, ny, nz = _rotated(w, x, y, z, dx, dy, dz)
        if nx * ax + ny * ay + nz * az < cosines[i]:
            nx, ny, nz = within_cone(nx, ny, nz, ax, ay, az, cosines[i], sines[i])
            w, x, y, z = _turn_between(dx, dy, dz, nx, ny, nz)
        turns[i, 0], turns[i, 1], turns[i, 2], turns[i, 3] = w, x, y, z
        ex, ey, ez = _rotated(w, x, y, z, ex, ey, ez)
        tx, ty, tz = px + ex, py + ey, pz + ez


@kernel()
def _apply(chain: NDArray, lengths: NDArray, turns: NDArray) -> None:
    """Turn the links: link k by the turns of all joints up to joint k, its own first."""
    w, x, y, z = 1.0, 0.0, 0.0, 0.0
    ox, oy, oz = chain[0, 0], chain[0, 1], chain[0, 2]
    for i in range(lengths.size):
        a, b, c, d = turns[i, 0], turns[i, 1], turns[i, 2], turns[i, 3]
        w, x, y, z = (
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        )
        dx, dy, dz = chain[i + 1, 0] - ox, chain[i + 1, 1] - oy, chain[i + 1, 2] - oz
        ox, oy, oz = chain[i + 1, 0], chain[i + 1, 1], chain[i + 1, 2]
        dx, dy, dz = _rotated(w, x, y, z, dx, dy, dz)
        # Back to the link's length, so that rounding does not gather over thousands of passes.
        scale = lengths[i] / math.sqrt(dx * dx + dy * dy + dz * dz)
        chain[i + 1, 0] = chain[i, 0] + scale * dx
        chain[i + 1, 1] = chain[i, 1] + scale * dy
        chain[i + 1, 2] = chain[i, 2] + scale * dz


@kernel()
def _solve(cones: Cones, goals: Goals, progress: Progress, joints: NDArray) -> None:
    """Repeat the passes, step after step, until `under_way` ends."""
    lengths, cosines, sines = cones
    _, frames, tips = goals
    _, count, evaluations = progress
    turns = np.empty((lengths.size, 4))
    while under_way(goals, progress, 0, joints):
        t = count[0]
        evaluations[0] += lengths.size
        _point_at_goal(joints[t], frames[t], cosines, sines, tips[t], turns)
        _apply(joints[t], lengths, turns)


class Ccd(TipOnly):
    """Cyclic coordinate descent: the tip on the path, joint after joint; the body is free."""

    name = "ccd"
    _kernel = staticmethod(_solve)
