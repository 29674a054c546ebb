"""Rotations as matrices, and as what else says them: angles in degrees, vectors, quaternions, directions."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.ties import first_largest

Array = NDArray[np.float64]


def rotation_of_degrees(angles_deg: tuple[float, float, float]) -> Array:
    """The rotation Rz Ry Rx, (3, 3), for the angles (rx, ry, rz) in degrees."""
    (cx, sx), (cy, sy), (cz, sz) = ((math.cos(a), math.sin(a)) for a in np.radians(angles_deg))
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def degrees_of_rotation(R: Array) -> tuple[float, float, float]:
    """Angles (rx, ry, rz) in degrees for which Rz Ry Rx is a rotation (3, 3); ry is at most a quarter turn."""
    about_x = np.degrees(np.arctan2(R[2, 1], R[2, 2]))
    about_y = np.degrees(np.arctan2(-R[2, 0], np.hypot(R[2, 1], R[2, 2])))
    # What is left is a turn about z, also where x and z coincide and the turn about x may be any.
    left = R @ rotation_of_degrees((about_x, about_y, 0.0)).T
    about_z = np.degrees(np.arctan2(left[1, 0] - left[0, 1], left[0, 0] + left[1, 1]))
    return float(about_x), float(about_y), float(about_z)


def rotations_of_vectors(vectors: Array) -> Array:
    """Rotations (m, 3, 3) of rotation vectors (m, 3) rad."""
    angle = np.linalg.norm(vectors, axis=1)
    x, y, z = (vectors / np.where(angle > 0, angle, 1.0)[:, None]).T
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    sine, rest = np.sin(angle)[:, None, None], 2.0 * np.sin(0.5 * angle)[:, None, None] ** 2
    return np.eye(3) + sine * cross + rest * (cross @ cross)


def vector_of_rotation(R: Array) -> Array:
    """Rotation vector (3,) rad of a rotation (3, 3) by less than half a turn."""
    off = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine = float(np.linalg.norm(off))
    angle = np.arctan2(sine, 0.5 * (np.trace(R) - 1.0))
    return off if sine == 0.0 else off * (angle / sine)


def quaternion_of_rotation(R: Array) -> Array:
    """The unit quaternion (4,), w first, of a rotation (3, 3), its largest part positive.

    It is worked out from that part, which is never close to 0. Of parts that only rounding tells apart, the first
    counts.
    """
    squares = np.array([1 + R[0, 0] + R[1, 1] + R[2, 2], 1 + R[0, 0] - R[1, 1] - R[2, 2],
                        1 - R[0, 0] + R[1, 1] - R[2, 2], 1 - R[0, 0] - R[1, 1] + R[2, 2]])  # fmt: skip
    (largest,) = first_largest(squares)
    rows = [
        [squares[0], R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]],
        [R[2, 1] - R[1, 2], squares[1], R[0, 1] + R[1, 0], R[0, 2] + R[2, 0]],
        [R[0, 2] - R[2, 0], R[0, 1] + R[1, 0], squares[2], R[1, 2] + R[2, 1]],
        [R[1, 0] - R[0, 1], R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], squares[3]],
    ]
    row = np.array(rows[largest])
    return row / np.linalg.norm(row)


def shortest_turn(direction: Array) -> Array:
    """The rotation (3, 3) that turns +z to a direction (3,) the shortest way; half a turn about x for -z."""
    x, y, z = (direction / np.linalg.norm(direction)).tolist()
    across = math.hypot(x, y)
    if across < 1e-12:
        return np.eye(3) if z > 0 else np.diag([1.0, -1.0, -1.0])
    part = (1.0 - z) / across**2
    return np.array(
        [
            [1.0 - part * x * x, -part * x * y, x],
            [-part * x * y, 1.0 - part * y * y, y],
            [-x, -y, z],
        ]
    )
