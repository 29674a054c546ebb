"""Spaces with a known way through: obstacles wrapped round the body of a random motion that the arm can make.

Every space is solvable with its planted clearance, and the proof is at hand: a plan of the motion it was made from,
certified. The search for routes is measured on them; it sees the obstacles, the entrance and the target.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from hognose.errors import HognoseError, InputError
from hognose.following.exact import Exact
from hognose.path import Path
from hognose.planning.plan import Plan
from hognose.planning.planner import plan
from hognose.planning.task import SLIDER_DIRECTION, Task, TaskSpec
from hognose.robot import Robot
from hognose.route.motion import Motion, insertion, leading_links
from hognose.scene import Board, Box, Cylinder, Hole, Pipe, Scene, Sphere

Array = NDArray[np.float64]
Solid = Board | Box | Cylinder | Pipe | Sphere
Family = Literal["boards", "pillars", "pipes", "plates", "rubble", "duct"]
FAMILIES: tuple[Family, ...] = ("boards", "pillars", "pipes", "plates", "rubble", "duct")

#: What is kept besides the planted clearance (m): the certificate is tight to a quarter of a millimetre.
SPARE = 3e-4
#: Edge (m) of the board with the entrance, and of everything that closes a space off.
WIDE = 0.7


@dataclass(frozen=True, eq=False)
class Space:
    """Obstacles, and a motion that keeps clear of them by the planted clearance.

    Attributes
    ----------
    planted : m
    way_points : (m, 3) m
        Those of the planted motion.
    task
        The search for a way: entrance and target alone.
    """

    family: Family
    seed: int
    planted: float
    way_points: Array
    task: Task

    def proof(self) -> Plan:
        """The planted motion, planned and certified with the planted clearance.

        Raises
        ------
        InfeasibleError
            The space is not what it claims to be.
        """
        spec = self.task.spec.model_copy(update={"margin": self.planted})
        return plan(Task(spec, self.task.robot), way_points=self.way_points)


@dataclass(frozen=True, eq=False)
class _Swept:
    """The places that the links take in a motion: chords (c, 3) m and radii (c,) m; and the path inside."""

    starts: Array
    ends: Array
    radii: Array
    path: Path
    run: float

    def clearance(self, *solids: Solid) -> float:
        """Clearance (m) from solids, at most a metre."""
        found = Scene.from_obstacles([s.model_copy(update={"name": str(k)}) for k, s in enumerate(solids)])
        return float((found.distance(self.starts, self.ends, upper=1.0, threads=1).value - self.radii).min())

    def at(self, part: float) -> tuple[Array, Array]:
        """Place and tangent at a part of the way behind the entrance."""
        s = self.run + part * (self.path.length - self.run)
        return self.path.point(s), self.path.tangent(s)


def space(robot: Robot, family: Family, seed: int, planted: float = 0.010, margin: float = 0.005) -> Space:
    """A space of a family with a known way through.

    Parameters
    ----------
    robot
    family
        A name in `FAMILIES`.
    seed
        The same one gives the same space.
    planted : m
        Clearance of the known motion.
    margin : m
        Clearance that the task asks for.

    Raises
    ------
    InputError
        An unknown family, or a robot for which no random motion is found.
    """
    if family not in FAMILIES:
        raise InputError(f"family {family!r} is unknown. Families: {', '.join(FAMILIES)}")
    random = np.random.default_rng([seed, FAMILIES.index(family)])
    way_points, swept = _random_motion(robot, random)
    solids = _entrance(swept, planted + SPARE, random) + _WRAPPED[family](swept, planted + SPARE, random)
    spec = TaskSpec.model_validate(
        {
            "name": f"{family} {seed}",
            "robot": robot.name,
            "margin": margin,
            "path": {"target": tuple(way_points[-1].tolist())},
            "obstacle": [solid.model_dump() for solid in solids],
        }
    )
    return Space(family, seed, planted, way_points, Task(spec, robot))


def _random_motion(robot: Robot, random: np.random.Generator) -> tuple[Array, _Swept]:
    """Way-points of a motion that uses a good part of what the joints can bend, and what it sweeps."""
    for _ in range(2000):
        count = int(random.integers(4, 7))
        length = robot.length * random.uniform(0.82, 0.97)
        z = np.linspace(0.0, length, count + 1)
        turn = random.normal(scale=0.35, size=(count + 1, 2))
        turn[0] = 0.0
        offset = np.cumsum(np.cumsum(turn, axis=0) * 0.6, axis=0) * (length / count)
        way_points = np.concatenate([offset, z[:, None]], axis=1)
        way_points -= way_points[0]
        path = Path.through(way_points, 3, SLIDER_DIRECTION).with_run(robot.length)
        try:
            motion = insertion(path, robot)
        except HognoseError:
            continue
        if motion is not None and _moderate(motion, robot):
            return way_points, _swept(path, motion, robot)
    raise InputError(f"robot {robot.name!r}: no random motion was found that its joints can make")


def _moderate(motion: Motion, robot: Robot) -> bool:
    """Whether a motion is within the limits and bends enough to be worth a search."""
    bend = float((np.abs(motion.angles) / robot.bend_limits).max())
    rate = np.abs(np.diff(motion.angles, axis=0)).max() / (motion.feeds[1] - motion.feeds[0])
    speed = rate * 0.0035 / 0.15 / np.radians(robot.spec.limits.joint_speed_deg_s)
    reach = motion.feeds[-1] / robot.reach
    return bool(0.5 <= bend <= 0.85 and speed <= 0.9 and reach <= 0.985)


def _swept(path: Path, motion: Motion, robot: Robot) -> _Swept:
    """The links' chords, 2 mm of feed apart."""
    feeds = np.linspace(0.0, motion.feeds[-1] * (1 - 1e-12), int(motion.feeds[-1] / 0.002) + 2)
    joints = Exact(path, robot.link_lengths).run(feeds)
    links = leading_links(robot)
    starts = np.concatenate([joints[:, i] for i in links] + [joints[0, :-1]])
    ends = np.concatenate([joints[:, i + 1] for i in links] + [joints[0, 1:]])
    radii = np.concatenate([np.repeat(robot.body_radii[links], len(feeds)), robot.body_radii])
    return _Swept(starts, ends, radii, path, robot.length)


def _smallest(swept: _Swept, make: Callable[[float], Solid], low: float, high: float, gap: float) -> Solid | None:
    """The solid of the smallest size that still keeps the gap; None if the largest does not."""
    if swept.clearance(make(high)) < gap:
        return None
    while high - low > 5e-5:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if swept.clearance(make(middle)) >= gap else (middle, high)
    return make(high)


def _entrance(swept: _Swept, gap: float, random: np.random.Generator) -> list[Solid]:
    """A board with a round hole at the entrance."""
    board = _board(swept, 0.0, gap, random, tilt=0.0)
    return [] if board is None else [board]


def _board(swept: _Swept, part: float, gap: float, random: np.random.Generator, tilt: float) -> Solid | None:
    place, tangent = swept.at(part)
    normal = tangent + random.normal(scale=tilt, size=3)
    thickness = random.uniform(0.004, 0.012)

    def make(diameter: float) -> Solid:
        return Board(
            center=_point(place),
            normal=_point(normal),
            up=_point(_across(normal, random=None)),
            size=(WIDE, WIDE),
            thickness=thickness,
            hole=(Hole(center=(0.0, 0.0), diameter=diameter),),
        )

    return _smallest(swept, make, 0.03, 0.4, gap)


def _boards(swept: _Swept, gap: float, random: np.random.Generator) -> list[Solid]:
    """Two to four boards with a hole each."""
    count = int(random.integers(2, 5))
    parts = (np.arange(1, count + 1) + random.uniform(-0.15, 0.15, count)) / (count + 0.7)
    made = (_board(swept, float(part), gap, random, tilt=0.15) for part in parts)
    return [board for board in made if board is not None]


def _against(
    swept: _Swept, gap: float, random: np.random.Generator, count: int, build: Callable[[Array, Array, Array], Solid]
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

        found = _smallest(swept, make, 0.02, 0.4, gap)
        make(0.0)
        if found is not None:
            out.append(found)
    return out


def _pillars(swept: _Swept, gap: float, random: np.random.Generator) -> list[Solid]:
    """Round pillars across the way, from random sides."""

    def build(place: Array, side: Array, tangent: Array) -> Solid:
        axis = np.cross(side, tangent) + random.normal(scale=0.25, size=3)
        axis /= np.linalg.norm(axis)
        diameter = random.uniform(0.03, 0.09)
        place = place + 0.5 * diameter * side
        return Cylinder(start=_point(place - 0.4 * axis), end=_point(place + 0.4 * axis), diameter=diameter)

    return _against(swept, gap, random, 14, build)


def _pipes(swept: _Swept, gap: float, random: np.random.Generator) -> list[Solid]:
    """Rows of parallel pipes across the space, those left out that are in the way; some pushed against the body."""
    out: list[Solid] = []
    turn = random.uniform(0, np.pi)
    axis = np.array([np.cos(turn), np.sin(turn), random.normal(scale=0.1)])
    across = np.array([-np.sin(turn), np.cos(turn), 0.0])
    pitch = random.uniform(0.10, 0.13)
    for row in np.arange(0.15, float(swept.path.point(swept.path.length)[2]), pitch):
        for k in range(-3, 4):
            place = np.array([0.0, 0.0, row]) + (k + random.uniform(0, 0.5)) * pitch * across
            diameter = random.uniform(0.02, 0.05)
            ends = (_point(place - 0.4 * axis), _point(place + 0.4 * axis))
            pipe = Pipe(start=ends[0], end=ends[1], diameter=diameter, wall=0.003)
            if swept.clearance(pipe) >= gap:
                out.append(pipe)

    def build(place: Array, side: Array, tangent: Array) -> Solid:
        along = np.cross(side, tangent) + random.normal(scale=0.1, size=3)
        place = place + 0.02 * side
        return Pipe(start=_point(place - 0.4 * along), end=_point(place + 0.4 * along), diameter=0.04, wall=0.003)

    return out + _against(swept, gap, random, 6, build)


def _plates(swept: _Swept, gap: float, random: np.random.Generator) -> list[Solid]:
    """Plates that reach from one side across the way, with an edge at the body: baffles."""

    def build(place: Array, side: Array, tangent: Array) -> Solid:
        # The plate's local y points to the side it comes from.
        turn = np.degrees(np.arctan2(-side[0], side[1]))
        tilt = random.uniform(-12.0, 12.0)
        rotation = _rotation(turn)
        middle = place + 0.25 * rotation[:, 1]
        return Box(center=_point(middle), size=(WIDE, 0.5, 0.006), rotation_deg=(tilt, 0.0, float(turn)))

    return _against(swept, gap, random, 7, build)


def _rubble(swept: _Swept, gap: float, random: np.random.Generator) -> list[Solid]:
    """Balls and blocks strewn round the way, as large as they fit."""
    out: list[Solid] = []
    while len(out) < 90:
        place, tangent = swept.at(float(random.uniform(0.08, 1.0)))
        place = place + _across(tangent, random) * random.uniform(0.05, 0.25)
        size, turn = random.uniform(0.03, 0.12), tuple(random.uniform(-180, 180, 3).tolist())
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


def _duct(swept: _Swept, gap: float, random: np.random.Generator) -> list[Solid]:
    """A duct of straight tubes round the whole way."""
    pieces = int(random.integers(6, 10))
    places = [swept.at(part)[0] for part in np.linspace(0.02, 1.0, pieces + 1)]
    out: list[Solid] = []
    for first, last in itertools.pairwise(places):

        def make(bore: float, first: Any = first, last: Any = last) -> Solid:
            return Pipe(start=_point(first), end=_point(last), diameter=bore + 0.006, wall=0.003)

        found = _smallest(swept, make, 0.04, 0.5, gap)
        if found is not None:
            out.append(found)
    return out


_WRAPPED: dict[str, Callable[[_Swept, float, np.random.Generator], list[Solid]]] = {
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
