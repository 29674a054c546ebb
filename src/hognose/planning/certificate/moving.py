"""A continuous motion between set-points, as certificates see it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.robot import Outline
from hognose.robot.base import FORWARD, Base, Mount, mounted

Array = NDArray[np.float64]


@kernel()
def _apart(first: NDArray, second: NDArray, out: NDArray) -> None:
    for i in range(first.shape[0]):
        for j in range(first.shape[1]):
            x = second[i, j, 0] - first[i, j, 0]
            y = second[i, j, 1] - first[i, j, 1]
            z = second[i, j, 2] - first[i, j, 2]
            out[i, j] = math.sqrt(x * x + y * y + z * z)


def apart(first: Array, second: Array) -> Array:
    """Distances (m, p) m of places (m, p, 3) m from others: what `numpy.linalg.norm` says, a tenth of its time."""
    out = np.empty(first.shape[:2])
    _apart(np.ascontiguousarray(first), np.ascontiguousarray(second), out)
    return out


@dataclass(frozen=True)
class OneChord:
    """A body that is a single chord, its section 0: the mount."""

    radius: float

    @property
    def outline(self) -> Outline:
        """As of a `Robot`."""
        radius, none = np.array([self.radius]), np.zeros((1, 2))
        return Outline(np.zeros(1, np.int64), radius, radius, none, none)


@dataclass(frozen=True)
class Pieces:
    """Intervals of the motion: parameters (m, k), ends of chords (m, p+1, 3) m, clearances (m, p) m at both ends."""

    step: NDArray[np.int64]
    low: Array
    high: Array
    low_body: Array
    high_body: Array
    low_clearance: Array
    high_clearance: Array

    @property
    def gone(self) -> Array:
        """How far (m, p+1) m every end of a chord is at the one end of the interval from where it is at the other."""
        return apart(self.low_body, self.high_body)

    @classmethod
    def between(cls, parameters: Array, vertices: Array, clearance: Array) -> Pieces:
        """The intervals from step to step of T steps."""
        rows = np.arange(len(parameters) - 1)
        ends = (side for values in (parameters, vertices, clearance) for side in (values[:-1], values[1:]))
        return cls(rows, *ends)

    def chosen(self, rows: NDArray[np.bool_] | NDArray[np.int64]) -> Pieces:
        """Some of the intervals."""
        return Pieces(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))

    def halved(self, middle: Array, body: Array, clearance: Array) -> Pieces:
        """Both halves of every interval, in the order of time."""
        halves = (
            (self.step, self.step),
            (self.low, middle),
            (middle, self.high),
            (self.low_body, body),
            (body, self.high_body),
            (self.low_clearance, clearance),
            (clearance, self.high_clearance),
        )
        return Pieces(*(_interleaved(first, second) for first, second in halves))


@dataclass(frozen=True, eq=False)
class Moving:
    """A motion between T set-points.

    Attributes
    ----------
    parameters : (T, k)
        At the set-points.
    place
        Makes parameters and ends of the chords of given parameters: in the middle of intervals.
    travel
        Makes of pieces how far (m, p+1) the ends of the chords move, and how far they bulge.
    straight
        Whether ends of chords move along straight lines at a steady speed but for their bulge, so that the motions of
        two chords may be subtracted; else only how far each goes is known.
    on_base
        How many of the parameters, the first ones, are coordinates of the base; 0 if they are arcs of joints on a path.
    turn : (n,) rad/m
        Of joints on a path: how far each link turns at most for each metre that both its ends go together.
    bend_slack : (T-1, n) rad or 0.0
        Within a step, the bends of successive joints sum up to no more than at one of its ends and this sum.
    """

    parameters: Array
    place: Callable[[Array], tuple[Array, Array]]
    travel: Callable[[Pieces], tuple[Array, Array]]
    straight: bool
    on_base: int = 0
    turn: Array = field(default_factory=lambda: np.zeros(1))
    bend_slack: Array | float = 0.0

    def bends_within(self, bends: Array) -> Array:
        """Of bends (T, n) rad at the set-points, some of which sums are as large as those within the steps beside."""
        if isinstance(self.bend_slack, float):
            return bends
        beside = np.zeros_like(bends)
        beside[:-1] = self.bend_slack
        beside[1:] = np.maximum(beside[1:], self.bend_slack)
        return bends + beside


def first_joint_motion(base: Base, at: Array) -> Moving:
    """The motion of the first joint alone, on a base whose coordinates (T, k) are interpolated; no chord yet."""

    def place(parameters: Array) -> tuple[Array, Array]:
        where = base.settled(parameters)
        return where, base.placed(base.along(where)[:, None, None] * np.array(FORWARD), where)

    def travel(pieces: Pieces) -> tuple[Array, Array]:
        bulge = base.swing(pieces.low, pieces.high) / 8
        return pieces.gone, bulge[:, None]

    return Moving(at, place, travel, straight=True, on_base=at.shape[1])


def standing(vertices: Array) -> Moving:
    """The motion of chords that end at vertices (p+1, 3) m and stay where they are, over one interval."""

    def place(parameters: Array) -> tuple[Array, Array]:
        return parameters, np.repeat(vertices[None], len(parameters), axis=0)

    def travel(pieces: Pieces) -> tuple[Array, Array]:
        still = np.zeros((len(pieces.step), len(vertices)))
        return still, still

    return Moving(np.zeros((2, 1)), place, travel, straight=True)


def mount_motion(moving: Moving, base: Base) -> Moving:
    """The motion of the mount alone, which a base must have: of its far end and the first joint."""
    whole = with_mount(moving, base)

    def place(parameters: Array) -> tuple[Array, Array]:
        parameters, body = whole.place(parameters)
        return parameters, body[:, :2]

    def travel(pieces: Pieces) -> tuple[Array, Array]:
        gone, bulge = whole.travel(pieces)
        return gone[:, :2], bulge[:, :2]

    return replace(whole, place=place, travel=travel)


def with_mount(moving: Moving, base: Base) -> Moving:
    """The same motion with the far end of the mount in front of the p+1 ends of the chords."""
    mount = base.mount
    if mount is None:
        return moving

    def place(parameters: Array) -> tuple[Array, Array]:
        parameters, body = moving.place(parameters)
        return parameters, mounted(base, body, coordinates_of(moving, base, parameters, body))

    def travel(pieces: Pieces) -> tuple[Array, Array]:
        low, high = pieces.low_body, pieces.high_body
        of_arm = replace(pieces, low_body=low[:, 1:], high_body=high[:, 1:])
        gone, bulge = moving.travel(of_arm)
        far = (np.linalg.norm(high[:, 0] - low[:, 0], axis=1), _bulge(moving, base, mount, pieces))
        if not moving.straight:
            swept = mount.length * float(moving.turn[0]) * gone[:, :2].sum(axis=1) if mount.turns else 0.0
            far = (gone[:, 0] + swept, far[1])
        return np.column_stack([far[0], gone]), np.column_stack([far[1], bulge])

    return replace(moving, place=place, travel=travel)


def mounted_body(moving: Moving, base: Base, vertices: Array) -> Array:
    """Ends (T, p+1, 3) m of the chords at the set-points, with the far end of the mount in front of them."""
    return mounted(base, vertices, coordinates_of(moving, base, moving.parameters, vertices))


def coordinates_of(moving: Moving, base: Base, parameters: Array, body: Array) -> Array:
    """Coordinates (m, k) of the base."""
    if moving.on_base:
        return parameters[:, : moving.on_base]
    return base.coordinates(parameters[:, 0], body)


def _bulge(moving: Moving, base: Base, mount: Mount, pieces: Pieces) -> Array:
    """How far (m,) m the far end of a mount leaves its straight line: an eighth of its acceleration."""
    if not moving.on_base:
        return np.zeros(len(pieces.step))
    low, high = pieces.low[:, : moving.on_base], pieces.high[:, : moving.on_base]
    turning = (base.spin(low, high) ** 2).sum(axis=1)
    return (base.swing(low, high) + mount.length * turning) / 8


def _interleaved(first: NDArray[Any], second: NDArray[Any]) -> NDArray[Any]:
    """First halves and second halves in the order of time, which keeps the distance queries warm."""
    return np.stack([first, second], axis=1).reshape(-1, *first.shape[1:])
