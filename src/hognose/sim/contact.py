"""What the arm runs into: the links as capsules against the triangles of the obstacles, a spring where they overlap."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.robot import Robot
from hognose.scene import Scene
from hognose.scene.distance import nearest

Array = NDArray[np.float64]

#: [assumed] How hard (N/m) and with how much damping (N s/m) obstacles resist.
STIFFNESS, DAMPING = 1e4, 15.0
#: Every link touches in so many places at most: the closest of each part of it.
PARTS = 3
#: An axis this close (m) to a surface has crossed it, or is about to: no spring says any more on which side it is.
CROSSED = 1e-3


@kernel()
def _look(
    boxes: NDArray,
    child: NDArray,
    faces: NDArray,
    grown: NDArray,
    index: NDArray,
    joints: NDArray,
    radii: NDArray,
    starts: NDArray,
    ends: NDArray,
    value: NDArray,
    on_segment: NDArray,
    on_mesh: NDArray,
    triangle: NDArray,
) -> int:
    """Look again at parts that may touch by now; how many do.

    Of each part, ends and value are those at which it was looked at last. The closest that it can be now is that value
    less how far its ends have moved.
    """
    touching, parts = 0, starts.shape[0] // radii.size
    for i in range(starts.shape[0]):
        link, k = i // parts, i % parts
        moved = 0.0
        for a in range(3):
            along = joints[link + 1, a] - joints[link, a]
            moved += (joints[link, a] + k / parts * along - starts[i, a]) ** 2
        further = 0.0
        for a in range(3):
            along = joints[link + 1, a] - joints[link, a]
            further += (joints[link, a] + (k + 1) / parts * along - ends[i, a]) ** 2
        if value[i] - math.sqrt(max(moved, further)) > radii[link]:
            continue
        for a in range(3):
            along = joints[link + 1, a] - joints[link, a]
            starts[i, a] = joints[link, a] + k / parts * along
            ends[i, a] = joints[link, a] + (k + 1) / parts * along
        nearest(
            boxes, child, faces, grown, index, starts, ends, np.inf, (i, i + 1), value, on_segment, on_mesh, triangle
        )
        if value[i] < radii[link]:
            touching += 1
    return touching


@dataclass(frozen=True, eq=False)
class Touch:
    """One place where a link touches an obstacle.

    Attributes
    ----------
    link
        0-based.
    obstacle
        Its name.
    place : (3,) m
        On the axis of the link.
    normal : (3,)
        Out of the obstacle.
    depth : m
        How far the body is in it.
    """

    link: int
    obstacle: str
    place: Array
    normal: Array
    depth: float


class Contact:
    """The links of an arm in a scene; it remembers how far away they were, so that most need no second look.

    Attributes
    ----------
    crossed
        The link (0-based) whose axis has crossed a surface, and the obstacle's name; None if none has.
    """

    crossed: tuple[int, str] | None

    def __init__(self, robot: Robot, scene: Scene) -> None:
        """The contact of a robot's links with a scene."""
        count = PARTS * robot.sections
        self.crossed = None
        self._scene, self._radii = scene, np.array(robot.body_radii)
        self._ends = np.zeros((count, 3)), np.zeros((count, 3))
        self._value = np.zeros(count)  # so that all are looked at first
        self._found = np.zeros((count, 3)), np.zeros((count, 3)), np.full(count, -1, np.int32)

    def touches(self, joints: Array) -> list[Touch]:
        """Where links touch whose joints and tip are at (n+1, 3) m; sets `crossed` if an axis crosses a surface."""
        tree = self._scene.tree
        if tree is None or not _look(*tree.arrays, joints, self._radii, *self._ends, self._value, *self._found):
            return []
        touches = []
        for part in np.flatnonzero(self._value < np.repeat(self._radii, PARTS)).tolist():
            link, away = part // PARTS, float(self._value[part])
            obstacle = self._scene.obstacle_of(int(self._found[2][part])) or ""
            if away < CROSSED:
                self.crossed = link, obstacle
                continue
            place = self._found[0][part].copy()
            out = place - self._found[1][part]
            normal = out / np.linalg.norm(out)
            touches.append(Touch(link, obstacle, place, normal, float(self._radii[link]) - away))
        return touches
