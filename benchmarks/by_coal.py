"""Distances by Coal, and a dense check of motions with them: nothing here uses Hognose's kinematics or distances."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import coal as coal_module
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
coal: Any = coal_module  # it comes without types

#: Configurations between the ones that a first, coarse look measures.
COARSE = 100
#: How wrong (m) a distance of Coal's may be; nothing is left out that is only this much farther.
SPARE = 1e-6


class Obstacles:
    """Triangles (m, 3, 3) in a tree of Coal's."""

    def __init__(self, triangles: Array) -> None:
        self._model = coal.BVHModelOBBRSS()
        self._model.beginModel(len(triangles), 3 * len(triangles))
        for corners in triangles:
            self._model.addTriangle(*corners)
        self._model.endModel()  # forgotten, it makes Coal crash
        self._here = coal.Transform3s()
        self._request = coal.DistanceRequest()

    def distance(self, start: Array, end: Array, radius: float) -> float:
        """Distance (m) of a capsule; not above zero where it touches."""
        along = end - start
        length = float(np.sqrt(along @ along))
        capsule = coal.Capsule(radius, length)
        placed = coal.Transform3s(_turn_of_z_to(along / length), 0.5 * (start + end))
        result = coal.DistanceResult()
        return coal.distance(self._model, self._here, capsule, placed, self._request, result)


def _turn_of_z_to(direction: Array) -> Array:
    """A rotation matrix (3, 3) whose last column is a unit vector."""
    x, y, z = direction.tolist()
    s = 1.0 if z >= 0 else -1.0
    a = -1.0 / (s + z)
    b = x * y * a
    return np.array([[1 + s * x * x * a, b, x], [s * b, s + y * y * a, y], [-s * x, -y, z]])


def chain(angles: Array, feeds: Array, lengths: Array) -> tuple[Array, Array]:
    """Joints and tip (T, n+1, 3) m, and frames (T, n+1, 3, 3) before each joint and behind the last one.

    Of angles (T, n, 2) rad and feeds (T,) m; a frame's columns are its axes, and R_y(α) R_x(β) leads to the next one.
    """
    joints = np.zeros((len(feeds), len(lengths) + 1, 3))
    joints[:, 0, 2] = feeds
    frames = np.tile(np.eye(3), (len(feeds), len(lengths) + 1, 1, 1))
    for i, length in enumerate(lengths):
        frames[:, i + 1] = frames[:, i] @ _turns(angles[:, i])
        joints[:, i + 1] = joints[:, i] + length * frames[:, i + 1, :, 2]
    return joints, frames


def _turns(angles: Array) -> Array:
    """R_y(α) R_x(β), (T, 3, 3), of angles (T, 2)."""
    (ca, cb), (sa, sb) = np.cos(angles).T, np.sin(angles).T
    zero = np.zeros_like(ca)
    columns = (ca, zero, -sa), (sa * sb, cb, ca * sb), (sa * cb, -sb, ca * cb)
    return np.stack([np.stack(column, axis=-1) for column in columns], axis=-1)


@dataclass(frozen=True)
class Dense:
    """What a dense check found: the smallest distance (m), in how many configurations, by how many measurements."""

    smallest: float
    configurations: int
    measured: int


def dense_check(obstacles: Obstacles, joints: Array, radii: Array) -> Dense:
    """The smallest distance of any of the links' capsules in any configuration, joints (T, n+1, 3) m.

    Every configuration counts; those are not measured that cannot have the smallest distance. No point of a link
    moves farther than its farther end does, so a link that is d away cannot come closer than the smallest distance
    before its ends have moved by the difference.
    """
    steps, links = len(joints), len(radii)
    moves = np.linalg.norm(np.diff(joints, axis=0), axis=2)
    moved = np.zeros((steps, links))
    moved[1:] = np.cumsum(np.maximum(moves[:, :-1], moves[:, 1:]), axis=0)
    measured = 0

    def distance(step: int, link: int) -> float:
        nonlocal measured
        measured += 1
        return obstacles.distance(joints[step, link], joints[step, link + 1], float(radii[link]))

    coarse = [*range(0, steps, COARSE), steps - 1]
    smallest = min(distance(step, link) for link in range(links) for step in coarse)
    for link in range(links):
        step = 0
        while step < steps:
            here = distance(step, link)
            smallest = min(smallest, here)
            free = moved[step, link] + here - smallest - SPARE
            step = max(step + 1, int(np.searchsorted(moved[:, link], free)))
    return Dense(smallest, steps, measured)


def interpolated(rows: Array, feed: float) -> Array:
    """Rows (m, 1 + k) of feed (m) and angles, interpolated linearly to steps of at most `feed` m."""
    wanted = np.linspace(rows[0, 0], rows[-1, 0], int(np.ceil(abs(rows[-1, 0] - rows[0, 0]) / feed)) + 1)
    at = np.unique(np.concatenate([wanted, rows[:, 0]]))
    return np.stack([np.interp(at, rows[:, 0], column) for column in rows.T], axis=1)
