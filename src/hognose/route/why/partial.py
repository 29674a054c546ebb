"""The farthest good insertion on the way to a target that cannot be reached."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from hognose.errors import HognoseError
from hognose.path import Path
from hognose.path.detour import arcs_of
from hognose.planning.plan import Plan
from hognose.planning.planner import plan_along
from hognose.planning.task import LONGEST_NAME, Task
from hognose.robot.bends import beyond
from hognose.route.fit.objective import Judged, judge
from hognose.route.lengths import too_far_to_search
from hognose.route.search.cheapest_ways import cost_to_go, way_over
from hognose.route.search.clearance_grid import search_grid
from hognose.route.search.search import Search
from hognose.route.why.changes import varied
from hognose.route.why.relaxations import Variation, objective_of

Array = NDArray[np.float64]

#: A partial insertion shorter than this (m) is not worth showing.
SHORTEST = 0.03
#: Distance (m) of even way-points along the beginning of a spline.
SPACING = 0.06
#: The way to the nearest place is halved until the arm gets along it, to this part of it.
FINEST = 0.1
#: A spline is shortened by at most about twice this (m) until its beginning is good.
MOST_BACK = 0.3


def along(task: Task, spline: Judged) -> Plan | None:
    """The longest good insertion along the beginning of a spline, whichever arm it was made for."""
    judged = judge(objective_of(task, spline.objective), spline.way_points)
    if judged is None:
        return None
    motion, robot = judged.motion, judged.objective.robot
    over = beyond(motion.angles, robot.bend_bounds) > 0
    bad = over.reshape(len(over), -1).max(axis=1) | (motion.feeds > task.base.feed_limit(robot))
    bad |= task.base.outside(motion.joints[:, 0]).any(axis=1)
    bad[judged.step[judged.clearances < task.clearance_wanted]] = True
    first = int(np.argmax(bad)) if bad.any() else len(bad) - 1
    end = float(motion.path.arc_length(motion.parameters[max(first - 1, 0), -1])) - task.base.run
    own = motion.path.arc_length(motion.path.breaks[1:-1]) - task.base.run
    back = 0.004
    while end > SHORTEST and back < MOST_BACK:
        # The spline's own places bend it where it was bent; many even ones keep closer to it.
        few = np.concatenate([[0.0], own[(own > SHORTEST) & (own < end - SHORTEST)], [end]])
        for arcs in (few, np.linspace(0.0, end, max(2, round(end / SPACING)) + 1)):
            way_points = _beginning(task, motion.path, arcs)
            with suppress(HognoseError):
                return plan_along(_towards(task, way_points[-1]), way_points=way_points)
        end, back = end - back, 2 * back
    return None


def _beginning(task: Task, path: Path, arcs: Array) -> Array:
    """Way-points (m, 3) m at arcs (m,) m behind the base's run, the first at 0; of a cart through the entrance, too."""
    way_points = path.point(np.minimum(task.base.run + arcs, path.length))
    way_points[0] = task.way_points[0]
    if task.nose is None:
        return way_points
    entrance = float(arcs_of(path, task.way_points[1:2])[0]) - task.base.run
    return np.concatenate([task.way_points[:2], way_points[arcs > entrance + SHORTEST]])


def nearest(search: Search) -> Plan | None:
    """A plan towards the place closest to the target, or to the first place via, that a way over the grid leads to."""
    task = search.task
    start, goal = np.array(task.spec.path.stops[:2])
    far = float(np.linalg.norm(goal - start))
    before = 0.0 if task.nose is None else float(np.linalg.norm(start - task.nose))
    reach = 0.9 * (task.base.reach(task.robot) - before)
    if reach <= 0 or too_far_to_search(task):
        return None
    task = _towards(task, _nearer(task, start + min(1.0, reach / far) * (goal - start)))
    grid, need = search_grid(task), float(task.robot.body_radii.max()) + task.clearance_wanted
    cost = np.where(grid.distance < need, np.inf, 1.0)
    reached = np.isfinite(cost_to_go(grid, cost, start)) & (grid.distance >= need + 0.5 * grid.cell)
    places = grid.places()[reached]
    places = places[(places - start) @ task.base.direction > SHORTEST]
    if not len(places):
        return None
    end = places[int(np.argmin(np.linalg.norm(places - task.way_points[-1], axis=1)))]
    way = way_over(grid, np.stack([start, end]), cost)
    part, step, best = 1.0, 0.5, None
    while way is not None and step >= FINEST and search.asks_on():
        place = grid.origin + grid.cell * way[round(part * (len(way) - 1))]
        found = Variation(_towards(task, place), None, search.seed, most=1, has_time=search.asks_on)
        found.run()
        if found.best is not None:
            best = found.best.plan
        if part == 1.0 and best is not None:
            break
        part, step = part + (step if found.best is not None else -step), step / 2
    return best


def _nearer(task: Task, goal: Array) -> Array:
    """A goal (3,) m, or the place closest to it that the arm reaches from where its first joint can be."""
    out = task.base.outside(goal[None])[0]
    away, most = float(np.linalg.norm(out)), 0.9 * task.robot.length
    return goal if away <= most else goal - (1.0 - most / away) * out


def _towards(task: Task, place: Array) -> Task:
    """The same task with another target, and no more to pass or to point at."""
    target = (float(place[0]), float(place[1]), float(place[2]))
    path = task.spec.path.model_copy(update={"target": target, "via": (), "tip_direction": None})
    name = task.name.removesuffix(_NAMED)[: LONGEST_NAME - len(_NAMED)] + _NAMED
    return varied(task, {"path": path, "name": name})


_NAMED = ", only as far as a way was found"
