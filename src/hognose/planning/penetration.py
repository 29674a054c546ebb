"""How far links are from obstacles, and how deep they are inside solids."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.robot import Outline, Robot
from hognose.scene import MovingObstacle, Scene
from hognose.ties import ROUNDING, first_smallest

Array = NDArray[np.float64]

#: Places along a link, its ends among them, where it is looked how deep it is.
PLACES = 9
#: A surface so close (m) to a link's axis is cut by it.
CUTS = 1e-12


def section_clearance(scene: Scene, robot: Robot, vertices: Array, horizon: float) -> Array:
    """Clearance (T, n) m of every section, the smallest of its chords.

    Vertices are the ends (T, c+1, 3) m of the chords of `Robot.outline`, `horizon` as of `clearance_of`.
    """
    outline = robot.outline
    if not (robot.straight_links or outline.flat):
        first = np.searchsorted(outline.sections, np.arange(robot.sections))
        found = scene.clearance(vertices[:, :-1], vertices[:, 1:], outline.radii, horizon, first=first).value
        middles = 0.5 * (vertices[0, :-1] + vertices[0, 1:])
        if found.min() > 0 and (scene.inside(middles) < 0).all():
            return found
    return per_section(outline.sections, clearance_of(scene, vertices, outline.radii, horizon), np.minimum)


def per_section(owners: NDArray[np.int64], values: Array, which: np.ufunc) -> Array:
    """The smallest or the largest (T, n) of values (T, p) of the chords of each section, by `minimum` or `maximum`.

    The chords belong to sections (p,), 0-based and from the base on.
    """
    if len(owners) == owners[-1] + 1:
        return values
    return which.reduceat(values, np.searchsorted(owners, np.arange(owners[-1] + 1)), axis=1)


def clearance_of_all(
    scene: Scene, moving: Iterable[MovingObstacle], robot: Robot, vertices: Array, horizon: float, clock: Array
) -> Array:
    """As `section_clearance`, to obstacles that move, too, as they stand at times (T,) s of their clock."""
    found = [section_clearance(seen, robot, ends, horizon) for seen, ends, _ in _seen(scene, moving, vertices, clock)]
    return np.minimum.reduce(found)


def _seen(
    scene: Scene, moving: Iterable[MovingObstacle], vertices: Array, clock: Array
) -> Iterator[tuple[Scene, Array, MovingObstacle | None]]:
    """Places (T, p, 3) m at times (T,) s in the frame of what stands still, then of each obstacle that moves."""
    yield scene, vertices, None
    for obstacle in moving:
        yield obstacle.scene, np.ascontiguousarray(obstacle.motion.into_frame(vertices, clock)), obstacle


@dataclass(frozen=True, eq=False)
class Nearest:
    """What obstacles, as they stand, are nearest to q segments.

    Attributes
    ----------
    on_segment, on_mesh : (q, 3) m
        The closest points; NaN where nothing is close enough.
    value : (q,) m
        The distance; minus the depth where a segment is inside a solid, if that was looked for.
    """

    on_segment: Array
    on_mesh: Array
    value: Array
    _scenes: tuple[Scene, ...]
    _scene: NDArray[np.int64]
    _obstacle: NDArray[np.int64]

    def moves(self, row: int) -> bool:
        """Whether what is nearest to a segment is an obstacle that moves."""
        return bool(self._scene[row] > 0)

    def obstacle(self, row: int) -> str | None:
        """The name of what is nearest to a segment; None where nothing is close enough."""
        owner = int(self._obstacle[row])
        return None if owner < 0 else self._scenes[self._scene[row]].names[owner]


def nearest(
    scene: Scene,
    moving: Iterable[MovingObstacle],
    starts: Array,
    ends: Array,
    clock: Array,
    upper: float = np.inf,
    inside: NDArray[np.bool_] | None = None,
) -> Nearest:
    """What is nearest to segments from starts to ends (q, 3) m at times (q,) s of what stands still and what moves.

    Beyond `upper` m nothing is looked for. Of segments that are `inside` (q,) a solid, the point of the obstacle is the
    deepest place. Of obstacles that are equally near the first one is taken, that which stands still before all others.
    """
    count, scenes = len(starts), []
    on_segment, on_mesh, value = np.full((count, 3), np.nan), np.full((count, 3), np.nan), np.full(count, upper)
    of_scene, of_obstacle = np.zeros(count, np.int64), np.full(count, -1)
    for seen, lines, obstacle in _seen(scene, moving, np.stack([starts, ends], axis=1), clock):
        begins, stops = np.ascontiguousarray(lines.transpose(1, 0, 2))
        found = seen.distance(begins, stops, upper=upper)
        owner = np.where(found.triangle >= 0, seen.owner[found.triangle], -1) if len(seen.owner) else found.triangle
        points, away = found.on_mesh, found.value
        if inside is not None and inside.any():
            deep = penetration(seen, begins[inside], stops[inside])
            within = deep.obstacle >= 0
            rows = np.flatnonzero(inside)[within]
            away[rows], owner[rows], points[rows] = -deep.depth[within], deep.obstacle[within], deep.place[within]
        closer = away + (ROUNDING * np.abs(away) if scenes else 0.0) < value
        for held, there in ((on_segment, found.on_segment), (on_mesh, points)):
            held[closer] = there[closer] if obstacle is None else _back(obstacle, there[closer], clock[closer])
        of_scene[closer], of_obstacle[closer] = len(scenes), owner[closer]
        value = np.minimum(away, value)
        scenes.append(seen)
    return Nearest(on_segment, on_mesh, value, tuple(scenes), of_scene, of_obstacle)


def _back(obstacle: MovingObstacle, points: Array, clock: Array) -> Array:
    """Points (q, 3) m of an obstacle as placed, where they are at times (q,) s."""
    turned, places = obstacle.motion.poses(clock)
    return np.einsum("qij,qj->qi", turned, points - obstacle.motion.pivot) + places


@dataclass(frozen=True, eq=False)
class Contact:
    """Where a link and the obstacles come closest.

    Attributes
    ----------
    obstacle
        Its name; None if there is none.
    moves
        Whether it is one that moves.
    inside
        Whether the link's axis is inside it.
    on_axis, place : (3,) m
        The closest points of the axis and of the obstacle; if inside, the place is the deepest one.
    distance : m
        Between the axis and the obstacle; minus the depth if inside.
    """

    obstacle: str | None
    moves: bool
    inside: bool
    on_axis: Array
    place: Array
    distance: float


def contact(
    scene: Scene, moving: Iterable[MovingObstacle], robot: Robot, line: Array, time: float, link: int, clearance: float
) -> Contact:
    """Where a link of a body (p+1, 3) m, whose clearance (m) is known, and obstacles at a time (s) come closest."""
    outline = robot.outline
    chords = np.flatnonzero((outline.sections == link) & (outline.radii > 0.0))
    inside = bool(clearance < -outline.radii[chords].min())
    found = nearest(
        scene, moving, line[chords], line[chords + 1], np.full(len(chords), time), inside=np.full(len(chords), inside)
    )
    (row,) = first_smallest(found.value)
    axis, place, value = found.on_segment[row], found.on_mesh[row], float(found.value[row])
    return Contact(found.obstacle(row), found.moves(row), inside, axis, place, value)


def closest_chords(
    scene: Scene,
    moving: Iterable[MovingObstacle],
    outline: Outline,
    body: Array,
    steps: NDArray[np.int64],
    links: NDArray[np.int64],
    clock: Array,
) -> NDArray[np.int64]:
    """The chord (q,) of each link (q,) that comes closest to an obstacle at a step (q,).

    The body is (T, c+1, 3) m, its chords ending as those of the outline, and the steps are at times (T,) s.
    """
    moving, found = tuple(moving), np.empty(len(links), np.int64)
    for link in np.unique(links):
        chords = np.flatnonzero((outline.sections == link) & (outline.radii > 0.0))
        rows = np.flatnonzero(links == link)
        at, which = np.repeat(steps[rows], len(chords)), np.tile(chords, len(rows))
        away = nearest(scene, moving, body[at, which], body[at, which + 1], clock[at]).value - outline.radii[which]
        found[rows] = chords[np.argmin(away.reshape(len(rows), -1), axis=1)]
    return found


def clearance_of(scene: Scene, vertices: Array, radii: Array, horizon: float) -> Array:
    """Clearance (T, p) m of the chords of a body that end at `vertices` (T, p+1, 3) m, with radii (p,) m.

    Those with the radius 0 only connect others: theirs is infinite.

    Inside a solid it is minus the radius and the depth of the link's axis. A mesh is a shell, so a link deep inside
    would look clear. An arm that starts outside and never touches stays outside, so only the start and motions that
    touch need the (slower) inside test.
    """
    starts, ends = vertices[:, :-1], vertices[:, 1:]
    body = np.flatnonzero(radii)
    if len(body) < len(radii):
        out = np.full(starts.shape[:2], np.inf)
        out[:, body] = _clearance_of(scene, starts[:, body], ends[:, body], radii[body], horizon)
        return out
    return _clearance_of(scene, starts, ends, radii, horizon)


def _clearance_of(scene: Scene, starts: Array, ends: Array, radii: Array, horizon: float) -> Array:
    value = scene.clearance(starts, ends, radii, horizon).value
    tested = slice(None) if value.min() <= 0 else slice(0, 1)
    middles = 0.5 * (starts[tested] + ends[tested])
    inside = scene.inside(middles.reshape(-1, 3)).reshape(middles.shape[:2]) >= 0
    row, chord = np.nonzero(inside | (value[tested] <= -radii + CUTS))
    if len(row):
        deep = penetration(scene, starts[row, chord], ends[row, chord])
        value[row, chord] = -radii[chord] - deep.depth
    return value


@dataclass(frozen=True, eq=False)
class Penetration:
    """The deepest place of each of q links.

    Attributes
    ----------
    depth : (q,) m
        Distance of that place on the link's axis to the surface of the solid it is in; 0 where none is inside.
    obstacle : (q,)
        The solid's index; -1 where none is inside.
    place : (q, 3) m
    """

    depth: Array
    obstacle: NDArray[np.int64]
    place: Array


def penetration(scene: Scene, starts: Array, ends: Array) -> Penetration:
    """The deepest of some places along links from starts to ends (q, 3) m; meant for links that touch.

    The depth is that in the first obstacle that a place is in. Between places it may be deeper, by half their distance
    at most.
    """
    parts = np.linspace(0.0, 1.0, PLACES)[:, None]
    points = (starts[:, None] + parts * (ends - starts)[:, None]).reshape(-1, 3)
    owner = scene.inside(points)
    depth = np.zeros(len(points))
    for obstacle in np.unique(owner[owner >= 0]):
        within = np.flatnonzero(owner == obstacle)
        # Other obstacles may have surfaces in there, which are no way out.
        depth[within] = scene.alone(int(obstacle)).distance(points[within], points[within]).value
    depth, owner, points = depth.reshape(-1, PLACES), owner.reshape(-1, PLACES), points.reshape(-1, PLACES, 3)
    # On the surface itself a place counts as inside, too.
    rows, deepest = np.arange(len(starts)), np.argmax(np.where(owner >= 0, depth, -1.0), axis=1)
    return Penetration(depth[rows, deepest], owner[rows, deepest], points[rows, deepest])
