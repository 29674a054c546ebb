"""The detour past obstacles that move: a way-point beside each place where the arm meets one.

A place on the path matters from when the tip comes there until the motion ends. The obstacle is looked at where it
stands in that time, so closely that between two of these places none of its points goes far; half of that is added
to the body, and how far its timing can shift it, as certificates take it off. Beside the deepest place the nearest
way-point with which the whole path comes clear is taken. Whether the motion is good is for the checks to say.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.cached import cached_property
from hognose.errors import InputError
from hognose.path import Path
from hognose.path.detour import SAMPLE_SPACING, arcs_of
from hognose.planning.places import places
from hognose.planning.plan import Plan
from hognose.planning.task import Task
from hognose.robot import Robot
from hognose.scene import MovingObstacle
from hognose.ties import first_largest, first_smallest
from hognose.wording import point

Array = NDArray[np.float64]

#: Between two places at which an obstacle is looked at none of its points goes farther (m) …
APART = 0.004
#: … unless it would be looked at more often than this.
MOST_PLACES = 400
#: Way-points that are tried: in so many directions across the path, in rings of half the body's width.
DIRECTIONS, RINGS = 16, 16
#: The straight arm is looked at in places so far (m) apart.
LYING = 0.01
#: Paths that are drawn in each round, and rounds.
MOST_DRAWN, MOST_ROUNDS = 20, 4


def led_past(plan: Plan) -> Array | None:
    """Way-points (m, 3) m of a path past the moving obstacles that an insertion meets; None if none is found.

    They are those of the plan, and others between them.
    """
    timetable, way_points = _Timetable(plan), plan.way_points
    path, hit = plan.path, timetable.hits(plan.path)
    for _ in range(MOST_ROUNDS):
        if not hit.depth.max() > 0:
            return way_points if way_points is not plan.way_points else None
        best = None
        for place in _beside(timetable, path, hit):
            tried = _inserted(path, way_points, hit, place)
            drawn = plan.task.path_through(tried)
            found = timetable.hits(drawn)
            if found.count < (hit if best is None else best[2]).count:
                best = (tried, drawn, found)
            if not found.count:
                break
        if best is None:
            return None
        way_points, path, hit = best
    return None


def refuse_covered_start(task: Task) -> None:
    """Raise an InputError that names a moving obstacle in which the straight arm lies as its clock begins."""
    if not task.moving:
        return
    base, length = task.base, task.robot.length
    passed = [task.way_points[:1], base.start[None]]
    if base.straight:
        passed.append(base.start + np.linspace(0.0, length, math.ceil(length / LYING) + 1)[:, None] * base.direction)
    points = np.concatenate(passed)
    for each in task.moving:
        seen = each.motion.into_frame(points[None], np.zeros(1))[0]
        covered = np.flatnonzero(each.scene.inside(seen) >= 0)
        if len(covered):
            what = (places(task)[0].words, "the first joint", "the arm")[min(covered[0], 2)]
            raise InputError(
                f"obstacle {each.name!r} moves, and at 0 s, when the insertion begins, {what} at "
                f"{point(points[covered[0]], 'g')} lies inside it. Place it elsewhere, or let it be out of the way by "
                "then: poses may have a `time_s` before 0"
            )


@dataclass(frozen=True, eq=False)
class _Hits:
    """Places of a path, equally far apart from the entrance on, and how deep obstacles come into a body round them."""

    arcs: Array
    points: Array
    depth: Array

    @property
    def count(self) -> int:
        """At how many places they do."""
        return int((self.depth > 0).sum())


class _Timetable:
    """When the arm of a plan is where."""

    def __init__(self, plan: Plan) -> None:
        self.task, self.plan = plan.task, plan
        self.start = plan.task.base.run
        self.length = plan.path.length
        # The tip's arc is longer than the links are: it is ahead of the feed by no more than this.
        self.ahead = max(self.length - self.start - float(plan.feed[-1]), 0.0)
        self.speed = float(plan.feed[-1] / plan.time[-1])

    @cached_property
    def needed(self) -> tuple[Array, float]:
        """How far (n,) m places of the path must be from obstacles for each link, and how far they lie apart (m)."""
        robot: Robot = self.plan.robot
        beside = float(self.plan.body_deviation.max()) + SAMPLE_SPACING / 2
        return robot.body_radii + self.task.clearances_wanted + beside, SAMPLE_SPACING

    def hits(self, path: Path) -> _Hits:
        """How deep obstacles, still and moving, come into the body on a path."""
        needed, spacing = self.needed
        arcs = np.linspace(self.start, path.length, max(2, math.ceil((path.length - self.start) / spacing) + 1))
        points = path.point(arcs)
        # A link comes as far in as the links before it leave room.
        lengths = self.plan.robot.link_lengths
        furthest = path.length - np.append(np.cumsum(lengths[:0:-1])[::-1], 0.0)
        body = np.where(furthest[:, None] >= arcs, needed[:, None], 0.0).max(axis=0)
        return _Hits(arcs, points, self.depth(points, body, arcs, path.length))

    def depth(self, points: Array, body: Array, arcs: Array, length: float) -> Array:
        """How deep (m,) m obstacles come into balls of radii (m,) round points (m, 3) at arcs of a path of a length.

        Below zero where they do not.
        """
        scene = self.task.scene
        depth = np.full(len(points), -np.inf)
        if scene.names:
            depth = body + np.where(scene.inside(points) >= 0, 1.0, -1.0) * scene.distance(points, points).value
        since = np.interp(arcs - self.start - self.ahead, self.plan.feed, self.plan.time)
        until = float(self.plan.time[-1]) + max(length - self.length, 0.0) / self.speed
        for each in self.task.moving:
            depth = np.maximum(depth, _met(each, points, body, since, until))
        return depth


def _met(obstacle: MovingObstacle, points: Array, body: Array, since: Array, until: float) -> Array:
    """How deep (m,) m an obstacle comes into balls round points (m, 3) m, from times (m,) s until another."""
    times, apart = _places(obstacle, float(since.min()), until)
    turned, centres = obstacle.motion.poses(times)
    shifted = body[:, None] + apart / 2 + _shifts(obstacle, times)
    # A place stands for the time until the next one, too.
    relevant = np.append(times[1:], np.inf) >= since[:, None]
    away = np.linalg.norm(points[:, None] - centres, axis=2)
    which, place = np.nonzero(relevant & (away < obstacle.reach + shifted))
    depth = np.full(len(points), -np.inf)
    if not len(which):
        return depth
    seen = np.einsum("qji,qj->qi", turned[place], points[which] - centres[place]) + obstacle.motion.pivot
    found = obstacle.scene.distance(seen, seen, upper=float(shifted.max())).value
    low, high = obstacle.scene.bounds[:, 0].min(axis=0), obstacle.scene.bounds[:, 1].max(axis=0)
    within = np.flatnonzero(((seen >= low) & (seen <= high)).all(axis=1))
    within = within[obstacle.scene.inside(seen[within]) >= 0]
    found[within] = -obstacle.scene.distance(seen[within], seen[within]).value
    np.maximum.at(depth, which, shifted[which, place] - found)
    return depth


def _shifts(obstacle: MovingObstacle, times: Array) -> Array:
    """How far (k,) m points of an obstacle are at most from where it is meant to be at times (k,) s."""
    early, now, late = (obstacle.motion.gone(times + shift) for shift in (-obstacle.timing, 0.0, obstacle.timing))
    slid, turned = (np.maximum(late[k] - now[k], now[k] - early[k]) for k in (0, 1))
    return slid + np.minimum(turned, 2.0) * obstacle.reach


def _places(obstacle: MovingObstacle, first: float, last: float) -> tuple[Array, float]:
    """Times (k,) s between two at which an obstacle is looked at, and how far (m) its points go between at most."""
    motion = obstacle.motion
    knots = motion.times
    if motion.repeats:
        first = max(first, last - motion.period)  # it is everywhere in a period
        rounds = math.floor((first - knots[0]) / motion.period) + np.arange(3)
        knots = np.unique(motion.period * np.maximum(rounds, 0)[:, None] + knots)
    knots = np.unique(np.concatenate([[first, last], knots[(knots > first) & (knots < last)]]))
    slid, turned = motion.gone(knots)
    way = slid + turned * obstacle.reach
    count = int(np.clip(math.ceil((way[-1] - way[0]) / APART), 1, MOST_PLACES))
    apart = float(way[-1] - way[0]) / count
    if apart == 0.0:
        return knots[:1], 0.0
    return np.interp(np.linspace(way[0], way[-1], count + 1), way, knots), apart


def _beside(timetable: _Timetable, path: Path, hit: _Hits) -> list[Array]:
    """Places (3,) m across the path from where it is hit the deepest, the nearest first, that are clear themselves."""
    (deepest,) = first_largest(hit.depth)
    place, arc = hit.points[deepest], hit.arcs[deepest]
    tangent = path.tangent(arc)
    one = np.cross(tangent, np.eye(3)[first_smallest(np.abs(tangent))])
    one /= np.linalg.norm(one)
    angles = np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS)
    sides = np.cos(angles)[:, None] * one + np.sin(angles)[:, None] * np.cross(tangent, one)
    body = float(timetable.needed[0].max())
    moves = np.arange(1, RINGS + 1) * (body / 2)
    places = (place + moves[:, None, None] * sides).reshape(-1, 3)
    depth = timetable.depth(places, np.full(len(places), body), np.full(len(places), arc), path.length)
    return list(places[depth <= 0][:MOST_DRAWN])


def _inserted(path: Path, way_points: Array, hit: _Hits, place: Array) -> Array:
    """Way-points with another one for where the path is hit the deepest."""
    (deepest,) = first_largest(hit.depth)
    before = int(np.searchsorted(arcs_of(path, way_points), hit.arcs[deepest]))
    return np.insert(way_points, np.clip(before, 1, len(way_points) - 1), place, axis=0)
