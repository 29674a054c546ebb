"""How points of the body move with errors: the axes of joints, and the errors of cables' zeros."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.robot import Robot
from hognose.robot.base import Base
from hognose.robot.cable_gains import angles_per_length

Array = NDArray[np.float64]


def joint_axes(base: Base, angles: Array, at: Array) -> Array:
    """Unit vectors (T, n, 2, 3), in the task's frame, about which α and β turn what is behind each joint.

    Parameters
    ----------
    base
    angles : (T, n, 2) rad
    at : (T, k)
        Coordinates of the base.
    """
    axes = np.empty((*angles.shape, 3))
    x, y, z = (np.broadcast_to(unit, (len(angles), 3)) for unit in np.eye(3))
    for i in range(angles.shape[1]):
        ca, sa, cb, sb = (f(angles[:, i, k])[:, None] for k in range(2) for f in (np.cos, np.sin))
        axes[:, i, 0] = y
        x, z = ca * x - sa * z, sa * x + ca * z
        axes[:, i, 1] = x
        y, z = cb * y + sb * z, cb * z - sb * y
    return base.turned(axes, at)


def by_angles(joints: Array, axes: Array, points: Array, links: NDArray[np.int64]) -> Array:
    """How points (q, 3) m on links (q,) move with all angles: (q, 3, n, 2) m/rad.

    Parameters
    ----------
    joints : (q, n+1, 3) m
    axes : (q, n, 2, 3)
        As of `joint_axes`.
    points : (q, 3) m
    links : (q,) int
        0-based; joints behind a link do not move it.
    """
    lever = points[:, None] - joints[:, :-1]
    before = np.arange(axes.shape[1]) <= links[:, None]
    moved = np.cross(axes, lever[:, :, None]) * before[:, :, None, None]
    return np.moveaxis(moved, 3, 1)


def by_zeros(robot: Robot, axes: Array, joints: Array, angles: Array) -> Array:
    """How all joints and the tip move with the length of every cable: (T, n+1, 3, c) m/m.

    Parameters
    ----------
    robot
    axes : (T, n, 2, 3)
        As of `joint_axes`.
    joints : (T, n+1, 3) m
    angles : (T, n, 2) rad
    """
    gains = angles_per_length(robot, angles)
    # The error of a link's direction is a rotation ψ, the sum of those of the joints up to it.
    turns = np.cumsum(np.einsum("tjka,tjkc->tjac", axes, gains, optimize=True), axis=1)
    links = np.diff(joints, axis=1)
    out = np.zeros((*joints.shape, robot.cables))
    np.cumsum(np.cross(turns, links[..., None], axis=2), axis=1, out=out[:, 1:])
    return out


def largest(columns: Array) -> Array:
    """The spread (...), in the worst direction, of errors with columns (..., 3, c) of unit standard deviation."""
    covariance = columns @ np.swapaxes(columns, -1, -2)
    return np.sqrt(np.maximum(np.linalg.eigvalsh(covariance)[..., -1], 0.0))
