"""What the arm runs into: the links as capsules against the triangles of the obstacles, a spring where they overlap."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.robot import Robot
from hognose.scene import MovingObstacle, Scene
from hognose.scene.distance import nearest
from hognose.scene.rigid_motion import RigidMotion
from hognose.sim.moving_frame import MovingFrame

Array = NDArray[np.float64]

#: [assumed] How hard (N/m) and with how much damping (N s/m) obstacles resist.
STIFFNESS, DAMPING = 1e4, 15.0
#: Every link touches in so many places at most: the closest of each part of it.
PARTS = 3
#: An axis this close (m) to a surface has crossed it, or is about to: no spring says any more on which side it is.
CROSSED = 1e-3
#: The velocity of what moves is a difference over this (s).
_SOON = 1e-4


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
    chord
        Of the body's centre line, 0-based; of an arm of links alone, the link.
    place : (3,) m
        On the axis of the link.
    normal : (3,)
        Out of the obstacle.
    depth : m
        How far the body is in it.
    velocity : (3,) m/s
        Of the obstacle there.
    """

    link: int
    obstacle: str
    chord: int
    place: Array
    normal: Array
    depth: float
    velocity: Array


class _Met:
    """A scene that stands still or moves as a whole, and how far away the parts of the links were."""

    def __init__(self, scene: Scene, count: int, motion: RigidMotion | None, joints: int) -> None:
        self.scene, self.frame = scene, None if motion is None else MovingFrame.of(motion, joints)
        self.arrays = None if scene.tree is None else scene.tree.arrays
        self.ends = np.zeros((count, 3)), np.zeros((count, 3))
        self.value = np.zeros(count)  # so that all are looked at first
        self.found = np.zeros((count, 3)), np.zeros((count, 3)), np.full(count, -1, np.int32)

    def looks(self, joints: Array, time: float, radii: Array) -> int:
        """How many parts touch it; `value` and `found` say where, as it was placed."""
        if self.arrays is None:
            return 0
        seen = joints if self.frame is None else self.frame.seen(joints, time)
        return _look(*self.arrays, seen, radii, *self.ends, self.value, *self.found)

    def touch(self, part: int, link: int, name: str, chord: int, radius: float, time: float) -> Touch:
        """The touch of a part."""
        place, on_mesh = self.found[0][part].copy(), self.found[1][part]
        out = (place - on_mesh) / np.linalg.norm(place - on_mesh)
        depth, drift = radius - float(self.value[part]), np.zeros(3)
        if self.frame is not None:
            motion, seen = self.frame.motion, on_mesh
            out = self.frame.R_task_placed @ out
            place = motion.out_of_frame(place, time)
            drift = (motion.out_of_frame(seen, time + _SOON) - motion.out_of_frame(seen, time)) / _SOON
        return Touch(link, name, chord, place, out, depth, drift)


class Contact:
    """The links of an arm in a space; it remembers how far away they were, so that most need no second look.

    Attributes
    ----------
    crossed
        The link (0-based) whose axis has crossed a surface, and the obstacle's name; None if none has.
    """

    crossed: tuple[int, str] | None

    def __init__(self, robot: Robot, scene: Scene, moving: Iterable[MovingObstacle] = ()) -> None:
        """The contact of a robot's links with a scene, and with obstacles that move."""
        self._owners = robot.chord_sections.tolist()
        count = PARTS * len(self._owners)
        self.crossed = None
        self._radii = np.array(robot.body_radii[robot.chord_sections])
        met = [(scene, None), *((each.scene, each.motion) for each in moving)]
        self._met = [_Met(scene, count, motion, len(self._owners) + 1) for scene, motion in met]
        self._names = [None, *(each.name for each in moving)]

    def inside(self, joints: Array, time: float = 0.0) -> tuple[int, str] | None:
        """The first link (0-based) inside a solid, and the obstacle's name; None if none is.

        The ends of the body's chords, joints and tip of links, are at (p+1, 3) m, at a time (s); looked at there and in
        the middles. A surface alone does not tell: its distance has no sign.
        """
        places = np.empty((2 * len(joints) - 1, 3))
        places[::2], places[1::2] = joints, 0.5 * (joints[:-1] + joints[1:])
        found = []
        for met, name in zip(self._met, self._names, strict=True):
            frame = met.frame
            seen = places if frame is None else frame.motion.into_frame(places[None], [time])[0]
            owner = met.scene.inside(seen)
            for place in np.flatnonzero(owner >= 0)[:1].tolist():
                found.append((self._owners[min(place // 2, len(joints) - 2)], name or met.scene.names[owner[place]]))
        return min(found, key=lambda each: each[0], default=None)

    def touches(self, joints: Array, time: float = 0.0) -> list[Touch]:
        """Where links touch whose chords have their ends at (p+1, 3) m, at a time (s) on the clock of what moves.

        Sets `crossed` if an axis crosses a surface.
        """
        touches = []
        for met, name in zip(self._met, self._names, strict=True):
            if met.looks(joints, time, self._radii):
                touches += self._touched(met, name, time)
        return touches

    def _touched(self, met: _Met, name: str | None, time: float) -> list[Touch]:
        touches = []
        for part in np.flatnonzero(met.value < np.repeat(self._radii, PARTS)).tolist():
            chord = part // PARTS
            link = self._owners[chord]
            obstacle = name or met.scene.obstacle_of(int(met.found[2][part])) or ""
            if met.value[part] < CROSSED:
                self.crossed = link, obstacle
                continue
            touches.append(met.touch(part, link, obstacle, chord, float(self._radii[chord]), time))
        return touches
