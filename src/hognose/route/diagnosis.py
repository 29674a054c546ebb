"""Why no route was found: what blocks, what bends too far, what is too short, and how far the arm gets."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from hognose.errors import HognoseError, InfeasibleError
from hognose.planning.plan import Plan
from hognose.planning.planner import plan as plan_through
from hognose.planning.task import Task
from hognose.robot import Robot, RobotSpec
from hognose.route.passages import cost_to_go
from hognose.route.room import Room, room_between
from hognose.route.score import Judged
from hognose.route.search import Search

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]

#: Passages that are tried for a variation of the task, and for a way to a nearer place.
PASSAGES_A_VARIANT = 3
#: A partial insertion shorter than this (m) is not worth showing.
SHORTEST = 0.03


def explained(search: Search) -> InfeasibleError:
    """What stands against a route, what would help, and the farthest insertion that was found, as an error."""
    task = search.task
    search.progress("finding out what stands in the way")
    short = _too_short(task)
    if short:
        said, part = [short], None
    else:
        room = search_room(task)
        narrow = _narrowest(task, room)
        said = [narrow] if narrow else list(_faults(search))
        part = None if narrow or search.closest is None else _partial(task, search.closest)
        part = part or _nearer(task, room)
    said += _remedies(search)
    if part is not None:
        left = np.linalg.norm(part.task.way_points[-1] - task.way_points[-1])
        said.append(
            f"the farthest good insertion that was found feeds {1e3 * part.feed[-1]:.0f} mm and ends at "
            f"{_mm(part.task.way_points[-1])}, {1e3 * left:.0f} mm from the target"
        )
    text = f"{task.name}: no route to the target was found among {search.passages} passages."
    return InfeasibleError("\n  ".join([text, *said]), part)


def search_room(task: Task) -> Room:
    """The clearance field that a task is searched in."""
    stops = task.way_points
    return room_between(task.scene, stops[0], stops[1:], 1.02 * _reach(task.robot))


def _reach(robot: Robot) -> float:
    return min(robot.length, robot.spec.feed.max)


def _too_short(task: Task) -> str | None:
    stops = task.way_points
    way = float(np.linalg.norm(np.diff(stops, axis=0), axis=1).sum())
    over = way - _reach(task.robot)
    if over <= 0:
        return None
    return (
        f"the arm is at least {1e3 * over:.1f} mm too short: in a straight line the way is {1e3 * way:.1f} mm, arm and "
        f"slider reach {1e3 * _reach(task.robot):.1f} mm"
    )


def _narrowest(task: Task, room: Room) -> str | None:
    """Where the widest way narrows to less than the body needs; None if it does not.

    The widest way is found by bisection: the largest distance that a way over the grid can keep.
    """
    stops = task.way_points
    needed = float(task.robot.body_radii.max()) + task.margin
    low, high = 0.9 * room.cell, needed + room.cell
    if _way(room, stops, high) is not None:
        return None
    way = _way(room, stops, low)
    if way is None:
        return f"the target is closed off: no way wider than {2e3 * low:.0f} mm leads to it"
    while high - low > 2.5e-4:
        middle = 0.5 * (low + high)
        wider = _way(room, stops, middle)
        low, high, way = (low, middle, way) if wider is None else (middle, high, wider)
    place, gap = _opened(task, room, way)
    if gap >= needed:
        return None
    beside = task.scene.witness(place, place).obstacle
    return (
        f"blocked: the widest way found narrows to {2e3 * gap:.1f} mm at {_mm(place)}, beside {beside!r}; the body of "
        f"{2e3 * (needed - task.margin):g} mm with {1e3 * task.margin:g} mm margin needs {2e3 * needed:g} mm"
    )


def _way(room: Room, stops: Array, least: float) -> Nodes | None:
    """Nodes (k, 3) of a way over the grid that keeps a distance everywhere, or None."""
    nodes = [room.nodes(stops[:1])]
    cost = np.where(room.distance < least, np.inf, 1.0)
    for start, target in itertools.pairwise(stops):
        left = cost_to_go(room, cost, target)
        at = room.nodes(start[None])[0]
        if not np.isfinite(left[tuple(at)]):
            return None
        legs = [at]
        while left[tuple(at)] > 0:
            low, high = np.maximum(at - 1, 0), np.minimum(at + 2, left.shape)
            window = left[low[0] : high[0], low[1] : high[1], low[2] : high[2]]
            at = low + np.array(np.unravel_index(int(np.argmin(window)), window.shape))
            legs.append(at)
        nodes.append(np.array(legs[1:]).reshape(-1, 3))
    return np.concatenate(nodes)


def _opened(task: Task, room: Room, way: Nodes) -> tuple[Array, float]:
    """The narrowest place of a way over the grid, moved to where it is widest around, and the distance there."""
    values = room.distance[way[:, 0], way[:, 1], way[:, 2]]
    k = int(np.argmin(values))
    place = room.origin + room.cell * way[k]
    ahead = room.cell * (way[min(k + 2, len(way) - 1)] - way[max(k - 2, 0)]).astype(np.float64)
    ahead /= max(float(np.linalg.norm(ahead)), 1e-12)
    offsets = np.random.default_rng(0).uniform(-1, 1, (600, 3)) * room.cell
    offsets -= (offsets @ ahead)[:, None] * ahead
    offsets[0] = 0.0
    around = place + offsets
    found = task.scene.distance(around, around).value
    best = int(np.argmax(found))
    return around[best], float(found[best])


def _faults(search: Search) -> Iterator[str]:
    """What the closest spline exceeds, in sentences."""
    closest = search.closest
    if closest is None:
        yield (
            "there is a way wide enough, but none that the joints can bend along within the arm's length; move the "
            "target or the entrance"
        )
        return
    robot, motion, used = closest.brief.robot, closest.motion, closest.overruns
    if used["bend"] > 1:
        ratio = np.abs(motion.angles) / robot.bend_limits
        step, section, axis = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
        angle, limit = np.degrees([abs(motion.angles[step, section, axis]), robot.bend_limits[section, axis]])
        yield (
            f"section {section + 1} would have to bend {angle:.1f} deg at {_mm(motion.joints[step, section])}, "
            f"{angle - limit:.1f} deg more than it can"
        )
    if used["speed"] > 1:
        times = f"{used['speed']:.2f} times as fast as it may"
        yield f"a joint would have to turn {times}; feed more slowly (motion.period_s)"
    if used["reach"] > 1:
        over = motion.feeds[-1] - _reach(robot)
        yield f"the arm is {1e3 * over:.1f} mm too short for the way that was found"
    if used.get("tip", 0.0) > 1:
        yield f"the last link points {used['tip'] * search.task.spec.path.tip_cone_deg:.1f} deg away from tip_direction"
    if closest.clearance < closest.brief.margin:
        yield _tightest(closest)
    for refused in search.refused[:1]:
        yield from (check.sentence for check in refused.checks if not check.ok)


def _tightest(judged: Judged) -> str:
    """Where the links of a spline come closest, in a sentence."""
    row = int(np.argmin(judged.clearances))
    step, link = judged.step[row], judged.chord[row]
    witness = judged.brief.scene.witness(judged.motion.joints[step, link], judged.motion.joints[step, link + 1])
    had = max(judged.clearance, -float(judged.brief.robot.body_radii.max()))
    return (
        f"at {_mm(np.array(witness.on_mesh))} {witness.obstacle!r} is too close: {1e3 * had:.1f} mm are left to a "
        f"link, {1e3 * judged.brief.margin:g} mm are wanted"
    )


def _partial(task: Task, judged: Judged) -> Plan | None:
    """The longest good insertion along the beginning of a spline."""
    motion, robot = judged.motion, judged.brief.robot
    over = np.abs(motion.angles) > robot.bend_limits
    bad = over.reshape(len(over), -1).max(axis=1)
    bad[judged.step[judged.clearances < task.margin]] = True
    first = int(np.argmax(bad)) if bad.any() else len(bad) - 1
    end = float(motion.path.arc_length(motion.parameters[max(first - 1, 0), -1])) - robot.length
    for _ in range(8):
        if end < SHORTEST:
            return None
        arcs = robot.length + np.linspace(0.0, end, max(2, round(end / 0.06)) + 1)
        way_points = motion.path.point(np.minimum(arcs, motion.path.length))
        way_points[0] = task.way_points[0]
        try:
            return plan_through(_towards(task, way_points[-1]), way_points=way_points)
        except HognoseError:
            end = 0.85 * end - 0.01
    return None


def _nearer(task: Task, room: Room) -> Plan | None:
    """A plan to the place closest to the target that a way over the grid leads to."""
    stops, need = task.way_points, float(task.robot.body_radii.max()) + task.margin
    cost = np.where(room.distance < need, np.inf, 1.0)
    reached = np.isfinite(cost_to_go(room, cost, stops[0])) & (room.distance >= need + 0.5 * room.cell)
    places = room.places()[reached]
    if not len(places):
        return None
    away = np.linalg.norm(places - stops[-1], axis=1)
    ahead = places[:, 2] - stops[0][2] > SHORTEST
    for slack in (0.0, 0.1, 0.2, 0.3):
        chosen = np.flatnonzero(ahead & (away >= away.min() + slack))
        if not len(chosen):
            return None
        place = places[chosen[int(np.argmin(away[chosen]))]]
        nearer = Search(_towards(task, place), None, 0, most=PASSAGES_A_VARIANT)
        nearer.run()
        if nearer.best is not None:
            return nearer.best.plan
    return None


def _towards(task: Task, place: Array) -> Task:
    """The same task with another target, and no more to pass or to point at."""
    target = (float(place[0]), float(place[1]), float(place[2]))
    path = task.spec.path.model_copy(update={"target": target, "via": (), "tip_direction": None})
    name = f"{task.name}, only as far as a way was found"
    return Task(task.spec.model_copy(update={"path": path, "name": name}), task.robot)


def _remedies(search: Search) -> list[str]:
    """Variations of the task for which a route is found."""
    found, tried = [], []
    for words, task in _variants(search.task):
        if not search.asks_on():
            break
        tried.append(words)
        search.progress(f"trying {words}")
        other = Search(task, None, search.seed, most=PASSAGES_A_VARIANT)
        other.run()
        if other.best is not None:
            found.append(f"with {words} a route is found ({1e3 * other.best.clearance:.1f} mm certified)")
    if found:
        return found
    if not tried:
        return ["no time was left to find out what would help; give more, or none"]
    return [f"none of the variations tried helps: {', '.join(tried)}"]


def _variants(task: Task) -> Iterator[tuple[str, Task]]:
    if task.margin > 0.0015:
        yield "1 mm of margin", Task(task.spec.model_copy(update={"margin": 0.001}), task.robot)
    for words, change in (
        ("4 mm less body diameter", {"body_diameter": -0.004}),
        ("joints that bend 10 deg more", {"bend_limit_deg": 10.0}),
    ):
        robot = _altered(task.robot, change)
        if robot is not None:
            yield words, Task(task.spec, robot)
    longer = _altered(task.robot, {"count": 2})
    if longer is not None:
        yield "two more sections", Task(task.spec, longer)


def _altered(robot: Robot, change: dict[str, float]) -> Robot | None:
    """The arm with something added to a value of its sections, to the count of the first only; None if it cannot be."""
    data = robot.spec.model_dump(by_alias=True)
    for index, section in enumerate(data["section"]):
        for key, more in change.items():
            if key == "count" and index > 0:
                continue
            value = section[key]
            section[key] = tuple(v + more for v in value) if isinstance(value, tuple | list) else value + more
    if "count" in change:
        more = change["count"] * data["section"][0]["pitch"]
        data["feed"]["max"] += more
    try:
        return Robot.from_spec(RobotSpec.model_validate(data))
    except (ValidationError, HognoseError):
        return None


def _mm(point: Array) -> str:
    return f"({', '.join(f'{1e3 * c:.0f}' for c in point)}) mm"
