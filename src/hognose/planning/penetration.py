"""How far links are from obstacles, and how deep they are inside solids."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.robot import Robot
from hognose.scene import MovingObstacle, Scene

Array = NDArray[np.float64]

#: Places along a link, its ends among them, where it is looked how deep it is.
PLACES = 9
#: A surface so close (m) to a link's axis is cut by it.
CUTS = 1e-12


def section_clearance(scene: Scene, robot: Robot, vertices: Array, horizon: float) -> Array:
    """Clearance (T, n) m of every section, the smallest of its chords; arguments as of `clearance_of`."""
    found = clearance_of(scene, vertices, robot.chord_radii, horizon)
    return found.reshape(len(found), robot.sections, -1).min(axis=2)


def clearance_of_all(
    scene: Scene, moving: Iterable[MovingObstacle], robot: Robot, vertices: Array, horizon: float, clock: Array
) -> Array:
    """As `section_clearance`, to obstacles that move, too, as they stand at times (T,) s of their clock."""
    found = section_clearance(scene, robot, vertices, horizon)
    for obstacle in moving:
        seen = np.ascontiguousarray(obstacle.motion.into_frame(vertices, clock))
        found = np.minimum(found, section_clearance(obstacle.scene, robot, seen, horizon))
    return found


@dataclass(frozen=True, eq=False)
class Nearest:
    """The closest points (q, 3) m of q segments and of obstacles, as they stand; NaN where nothing is close enough."""

    on_segment: Array
    on_mesh: Array
    value: Array


def nearest(
    scene: Scene, moving: Iterable[MovingObstacle], starts: Array, ends: Array, clock: Array, upper: float
) -> Nearest:
    """What is nearest to segments from starts to ends (q, 3) m at times (q,) s of what stands still and what moves.

    Beyond `upper` m nothing is looked for.
    """
    found = scene.distance(starts, ends, upper=upper)
    on_segment, on_mesh, value = found.on_segment, found.on_mesh, found.value
    for obstacle in moving:
        seen = obstacle.motion.into_frame(np.stack([starts, ends], axis=1), clock)
        other = obstacle.scene.distance(*np.ascontiguousarray(seen.transpose(1, 0, 2)), upper=upper)
        turned, places = obstacle.motion.poses(clock)
        closer = other.value < value
        for held, points in ((on_segment, other.on_segment), (on_mesh, other.on_mesh)):
            back = np.einsum("qij,qj->qi", turned, points - obstacle.motion.pivot) + places
            held[closer] = back[closer]
        value = np.where(closer, other.value, value)
    return Nearest(on_segment, on_mesh, value)


def clearance_of(scene: Scene, vertices: Array, radii: Array, horizon: float) -> Array:
    """Clearance (T, p) m of the chords of a body that end at `vertices` (T, p+1, 3) m, with radii (p,) m.

    Inside a solid it is minus the radius and the depth of the link's axis. A mesh is a shell, so a link deep inside
    would look clear. An arm that starts outside and never touches stays outside, so only the start and motions that
    touch need the (slower) inside test.
    """
    value = scene.clearance(vertices[:, :-1], vertices[:, 1:], radii, horizon).value
    tested = slice(None) if value.min() <= 0 else slice(0, 1)
    middles = 0.5 * (vertices[tested, :-1] + vertices[tested, 1:])
    inside = scene.inside(middles.reshape(-1, 3)).reshape(middles.shape[:2]) >= 0
    row, chord = np.nonzero(inside | (value[tested] <= -radii + CUTS))
    if len(row):
        deep = penetration(scene, vertices[row, chord], vertices[row, chord + 1])
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


def deepest_place(scene: Scene, start: Array, end: Array) -> tuple[str | None, Array]:
    """The name of the solid that a link from start to end (3,) m is deepest in, None if in none, and where (3,) m."""
    found = penetration(scene, start[None], end[None])
    obstacle = int(found.obstacle[0])
    return (scene.names[obstacle] if obstacle >= 0 else None), found.place[0]
