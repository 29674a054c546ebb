"""How points of the body move with errors: the axes of joints, and the errors of cables' zeros."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.robot.base import Base
from hognose.robot.kinematics import axes_of_joints

Array = NDArray[np.float64]


@kernel(fastmath={"contract"})
def _moved(axes: NDArray, gains: NDArray, links: NDArray, out: NDArray) -> None:
    """How joints move (T, n+1, 3, c), with axes (T, n, 2, 3), gains (T, n, 2, c) and links (T, n, 3); `out` is zero.

    The error of a link's direction is a rotation ψ, the sum of those of the joints up to it.
    """
    turns = np.empty((3, out.shape[3]))
    for t in range(out.shape[0]):
        turns[:] = 0.0
        for j in range(links.shape[1]):
            ux, uy, uz = axes[t, j, 0, 0], axes[t, j, 0, 1], axes[t, j, 0, 2]
            vx, vy, vz = axes[t, j, 1, 0], axes[t, j, 1, 1], axes[t, j, 1, 2]
            lx, ly, lz = links[t, j, 0], links[t, j, 1], links[t, j, 2]
            for c in range(out.shape[3]):
                a, b = gains[t, j, 0, c], gains[t, j, 1, c]
                turns[0, c] += a * ux + b * vx
                turns[1, c] += a * uy + b * vy
                turns[2, c] += a * uz + b * vz
                x, y, z = turns[0, c], turns[1, c], turns[2, c]
                out[t, j + 1, 0, c] = out[t, j, 0, c] + y * lz - z * ly
                out[t, j + 1, 1, c] = out[t, j, 1, c] + z * lx - x * lz
                out[t, j + 1, 2, c] = out[t, j, 2, c] + x * ly - y * lx


@kernel(fastmath={"contract"})
def _largest(columns: NDArray, out: NDArray) -> None:
    """Root (T, m) of the largest eigenvalue of C Cᵀ, for C in columns (T, m, 3, c): the closed form for 3 × 3."""
    for t in range(columns.shape[0]):
        for m in range(columns.shape[1]):
            xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for c in range(columns.shape[3]):
                x, y, z = columns[t, m, 0, c], columns[t, m, 1, c], columns[t, m, 2, c]
                xx, yy, zz = xx + x * x, yy + y * y, zz + z * z
                xy, xz, yz = xy + x * y, xz + x * z, yz + y * z
            mean = (xx + yy + zz) / 3.0
            a, b, c3 = xx - mean, yy - mean, zz - mean
            off = xy * xy + xz * xz + yz * yz
            size = math.sqrt((a * a + b * b + c3 * c3 + 2.0 * off) / 6.0)
            if size == 0.0:
                out[t, m] = math.sqrt(mean)
                continue
            half = a * b * c3 + 2.0 * xy * xz * yz - a * yz * yz - b * xz * xz - c3 * xy * xy
            ratio = min(max(half / (2.0 * size * size * size), -1.0), 1.0)
            out[t, m] = math.sqrt(mean + 2.0 * size * math.cos(math.acos(ratio) / 3.0))


@kernel(fastmath={"contract"})
def _changes(columns: NDArray, out: NDArray) -> None:
    """Frobenius norms (T-1, m) of how columns (T, m, 3, c) change from each row to the next."""
    for t in range(out.shape[0]):
        for m in range(out.shape[1]):
            found = 0.0
            for k in range(columns.shape[2]):
                for c in range(columns.shape[3]):
                    change = columns[t + 1, m, k, c] - columns[t, m, k, c]
                    found += change * change
            out[t, m] = math.sqrt(found)


def joint_axes(base: Base, angles: Array, at: Array) -> Array:
    """Unit vectors (T, n, 2, 3), in the task's frame, about which α and β turn what is behind each joint.

    Parameters
    ----------
    base
    angles : (T, n, 2) rad
    at : (T, k)
        Coordinates of the base.
    """
    return base.turned(axes_of_joints(angles), at)


def by_zeros(axes: Array, joints: Array, gains: Array) -> Array:
    """How all joints and the tip move with the length of every cable: (T, n+1, 3, c) m/m.

    Parameters
    ----------
    axes : (T, n, 2, 3)
        As of `joint_axes`.
    joints : (T, n+1, 3) m
    gains : (T, n, 2, c) rad/m
        As of `angles_per_length`.
    """
    out = np.zeros((*joints.shape, gains.shape[3]))
    _moved(np.ascontiguousarray(axes), gains, np.diff(joints, axis=1), out)
    return out


def largest(columns: Array) -> Array:
    """The spread (T, m), in the worst direction, of errors with columns (T, m, 3, c) of unit standard deviation."""
    out = np.empty(columns.shape[:2])
    _largest(columns, out)
    return out


def changes(columns: Array) -> Array:
    """How much (T-1, m) of columns (T, m, k, c) changes from each row to the next: the root of the sum of squares."""
    out = np.empty((len(columns) - 1, columns.shape[1]))
    _changes(columns, out)
    return out
