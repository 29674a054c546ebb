"""Obstacles wrapped round the body of a motion, as closely as a gap allows: the families of spaces."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.path import Path
from hognose.scene import Board, Box, Cylinder, Hole, Pipe, Scene, Sphere

Array = NDArray[np.float64]
Solid = Board | Box | Cylinder | Pipe | Sphere

#: Edge of the board with the entrance, and of everything that closes a space off; in m for an arm of size 1, like all.
WIDE = 0.7


@dataclass(frozen=True, eq=False)
class Swept:
    """The places that the links take in a motion: chords (c, 3) m and radii (c,) m; the path inside, and its size."""

    starts: Array
    ends: Array
    radii: Array
    path: Path
    run: float
    size: float

    def clearance(self, *solids: Solid) -> float:
        """Clearance (m) from solids, at most about the arm's length."""
        found = Scene.from_obstacles([s.model_copy(update={"name": str(k)}) for k, s in enumerate(solids)])
        return float((found.distance(self.starts, self.ends, upper=self.size, threads=1).value - self.radii).min())

    def at(self, part: float) -> tuple[Array, Array]:
        """Place and tangent at a part of the way behind the entrance."""
        s = self.run + part * (self.path.length - self.run)
        return self.path.point(s), self.path.tangent(s)


def _smallest(swept: Swept, make: Callable[[float], Solid], low: float, high: float, gap: float) -> Solid | None:
    """The solid of the smallest size that still keeps the gap; None if the largest does not."""
    if swept.clearance(make(high)) < gap:
        return None
    while high - low > 5e-5 * swept.size:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if swept.clearance(make(middle)) >= gap else (middle, high)
    return make(high)


def entrance(swept: Swept, gap: float, random: np.random.Generator) -> list[Solid]:
    """A board with a round hole at the entrance."""
    board = _board(swept, 0.0, gap, random, tilt=0.0)
    return [] if board is None else [board]


def _board(swept: Swept, part: float, gap: float, random: np.random.Generator, tilt: float) -> Solid | None:
    place, tangent = swept.at(part)
    normal = tangent + random.normal(scale=tilt, size=3)
    thickness = swept.size * random.uniform(0.004, 0.012)

    def make(diameter: float) -> Solid:
        return Board(
            center=_point(place),
            normal=_point(normal),
            up=_point(_across(normal, random=None)),
            size=(WIDE * swept.size, WIDE * swept.size),
            thickness=thickness,
            hole=(Hole(center=(0.0, 0.0), diameter=diameter),),
        )

    return _smallest(swept, make, 0.03 * swept.size, 0.4 * swept.size, gap)


def _boards(swept: Swept, gap: float, random: np.random.Generator) -> list[Solid]:
    """Two to four boards with a hole each."""
    count = int(random.integers(2, 5))
    parts = (np.arange(1, count + 1) + random.uniform(-0.15, 0.15, count)) / (count + 0.7)
    made = (_board(swept, float(part), gap, random, tilt=0.15) for part in parts)
    return [board for board in made if board is not None]


def _against(
    swept: Swept, gap: float, random: np.random.Generator, count: int, build: Callable[[Array, Array, Array], Solid]
) -> list[Solid]:
    """Solids pushed against the body from random sides; `build` makes one of place, side and tangent."""
    out: list[Solid] = []
    for _ in range(count):
        place, tangent = swept.at(float(random.uniform(0.1, 0.97)))
        side = _across(tangent, random)
        state = random.bit_generator.state

        def make(offset: float, place: Any = place, side: Any = side, tangent: Any = tangent, s: Any = state) -> Solid:
            random.bit_generator.state = s  # the same solid at every offset
            return build(place + offset * side, side, tangent)

        found = _smallest(swept, make, 0.02 * swept.size, 0.4 * swept.size, gap)
        make(0.0)
        if found is not None:
            out.append(found)
    return out


def _pillars(swept: Swept, gap: float, random: np.random.Generator) -> list[Solid]:
    """Round pillars across the way, from random sides."""

    def build(place: Array, side: Array, tangent: Array) -> Solid:
        axis = np.cross(side, tangent) + random.normal(scale=0.25, size=3)
        axis /= np.linalg.norm(axis)
        diameter = swept.size * random.uniform(0.03, 0.09)
        place = place + 0.5 * diameter * side
        half = 0.4 * swept.size * axis
        return Cylinder(start=_point(place - half), end=_point(place + half), diameter=diameter)

    return _against(swept, gap, random, 14, build)


def _pipes(swept: Swept, gap: float, random: np.random.Generator) -> list[Solid]:
    """Rows of parallel pipes across the space, those left out that are in the way; some pushed against the body."""
    out: list[Solid] = []
    turn = random.uniform(0, np.pi)
    axis = np.array([np.cos(turn), np.sin(turn), random.normal(scale=0.1)])
    across = np.array([-np.sin(turn), np.cos(turn), 0.0])
    size = swept.size
    pitch = size * random.uniform(0.10, 0.13)
    for row in np.arange(0.15 * size, float(swept.path.point(swept.path.length)[2]), pitch):
        for k in range(-3, 4):
            place = np.array([0.0, 0.0, row]) + (k + random.uniform(0, 0.5)) * pitch * across
            diameter = size * random.uniform(0.02, 0.05)
            ends = (_point(place - 0.4 * size * axis), _point(place + 0.4 * size * axis))
            pipe = Pipe(start=ends[0], end=ends[1], diameter=diameter, wall=0.003 * size)
            if swept.clearance(pipe) >= gap:
                out.append(pipe)

    def build(place: Array, side: Array, tangent: Array) -> Solid:
        along = np.cross(side, tangent) + random.normal(scale=0.1, size=3)
        place, half = place + 0.02 * size * side, 0.4 * size * along
        return Pipe(start=_point(place - half), end=_point(place + half), diameter=0.04 * size, wall=0.003 * size)

    return out + _against(swept, gap, random, 6, build)


def _plates(swept: Swept, gap: float, random: np.random.Generator) -> list[Solid]:
    """Plates that reach from one side across the way, with an edge at the body: baffles."""

    def build(place: Array, side: Array, tangent: Array) -> Solid:
        # The plate's local y points to the side it comes from.
        turn = np.degrees(np.arctan2(-side[0], side[1]))
        tilt = random.uniform(-12.0, 12.0)
        rotation = _rotation(turn)
        middle, size = place + 0.25 * swept.size * rotation[:, 1], swept.size
        return Box(
            center=_point(middle), size=(WIDE * size, 0.5 * size, 0.006 * size), rotation_deg=(tilt, 0.0, float(turn))
        )

    return _against(swept, gap, random, 7, build)


def _rubble(swept: Swept, gap: float, random: np.random.Generator) -> list[Solid]:
    """Balls and blocks strewn round the way, as large as they fit."""
    out: list[Solid] = []
    while len(out) < 90:
        place, tangent = swept.at(float(random.uniform(0.08, 1.0)))
        place = place + _across(tangent, random) * (swept.size * random.uniform(0.05, 0.25))
        size, turn = swept.size * random.uniform(0.03, 0.12), tuple(random.uniform(-180, 180, 3).tolist())
        shape = tuple((random.uniform(0.5, 1.0, 3)).tolist())
        ball = bool(random.random() < 0.5)

        def make(small: float, place: Any = place, size: Any = size, turn: Any = turn, s: Any = shape, b: Any = ball):
            edge = size * (1.0 - small)
            if b:
                return Sphere(center=_point(place), diameter=edge)
            return Box(center=_point(place), size=(edge * s[0], edge * s[1], edge * s[2]), rotation_deg=turn)

        solid = make(0.0)
        if swept.clearance(solid) < gap:
            shrunk = _smallest(swept, make, 0.0, 0.8, gap)
            if shrunk is None:
                continue
            solid = shrunk
        out.append(solid)
    return out


def _duct(swept: Swept, gap: float, random: np.random.Generator) -> list[Solid]:
    """A duct of straight tubes round the whole way."""
    pieces = int(random.integers(6, 10))
    places = [swept.at(part)[0] for part in np.linspace(0.02, 1.0, pieces + 1)]
    out: list[Solid] = []
    wall = 0.003 * swept.size
    for first, last in itertools.pairwise(places):

        def make(bore: float, first: Any = first, last: Any = last) -> Solid:
            return Pipe(start=_point(first), end=_point(last), diameter=bore + 2 * wall, wall=wall)

        found = _smallest(swept, make, 0.04 * swept.size, 0.5 * swept.size, gap)
        if found is not None:
            out.append(found)
    return out


WRAPPED: dict[str, Callable[[Swept, float, np.random.Generator], list[Solid]]] = {
    "boards": _boards,
    "pillars": _pillars,
    "pipes": _pipes,
    "plates": _plates,
    "rubble": _rubble,
    "duct": _duct,
}


def _across(tangent: Array, random: np.random.Generator | None) -> Array:
    """A unit vector across a direction: a random one, or the one closest to y."""
    direction = tangent / np.linalg.norm(tangent)
    helper = np.array([0.0, 1.0, 0.0]) if random is None else random.normal(size=3)
    side = helper - (helper @ direction) * direction
    return side / np.linalg.norm(side)


def _rotation(turn: float) -> Array:
    """Turn about z by degrees."""
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _point(values: Array) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in values)
    return x, y, z
