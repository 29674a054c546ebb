"""Where there is too little room for the body, whatever its joints can do: at a place to be passed, or on all ways."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.planning.places import places
from hognose.planning.room_for_tolerances import taken_at_least
from hognose.planning.task import Task
from hognose.route.lengths import longest_way
from hognose.route.search.cheapest_ways import Nodes, way_over
from hognose.route.search.clearance_grid import ClearanceGrid, search_grid
from hognose.wording import beside_limit, point

Array = NDArray[np.float64]

#: The widest way is known to this (m).
EXACT = 2.5e-4
#: The farthest that a place is from the closest node, in cells.
BETWEEN = 0.8661
#: Ways round obstacles are looked for so many times as far as the arm reaches.
FARTHER = 2.0
#: A way over the grid is at most so many times as long as one in the open.
ROUNDABOUT = 1.13
#: A metre through an obstacle counts as so many, where the way that leads through the fewest is sought.
THROUGH = 200.0


@dataclass(frozen=True)
class Gap:
    """What is too narrow.

    Attributes
    ----------
    half : m
        Distance of the middle of the widest way from the obstacles at its narrowest place; 0 where there is no way.
    missing : m
        So much more is needed.
    sentences
        What to say of it.
    proven
        Whether this body can take no way at all, found or not.
    over : m
        By how much the arm is too short for the way that is wide enough, where that is what is wrong.
    """

    half: float
    missing: float
    sentences: tuple[str, ...]
    proven: bool
    over: float | None = None

    @property
    def closed(self) -> bool:
        """Whether there is no way at all."""
        return self.half == 0.0


def crowded(task: Task) -> Gap | None:
    """The places to be passed that lie so close to obstacles that the body cannot be there; None if there are none."""
    if not task.scene.names:
        return None
    stops = task.way_points
    radius = np.full(len(stops), task.robot.body_radii[-1])  # thicker links need not come so far
    half = task.scene.distance(stops, stops).value
    said, least, most = [], np.inf, 0.0
    taken = taken_at_least(task)  # a way may be found past places that more would be wanted at
    for k in np.flatnonzero(half < radius + task.margin + taken):
        needed = radius[k] + task.margin + taken[k]
        missing = needed - half[k]
        shown, limit = beside_limit(1e3 * half[k], 1e3 * needed, lower_bound=True)
        which = places(task)[k].words
        said.append(
            f"{which} at {point(stops[k], '.0f')} is {shown} mm from "
            f"{task.scene.witness(stops[k], stops[k]).obstacle!r}; half the body of {2e3 * radius[k]:g} mm with "
            f"{_beside(task, float(taken[k]))} needs {limit} mm: {_more(1e3 * missing)} mm more"
        )
        least, most = min(least, half[k]), max(most, missing)
    return Gap(float(least), float(most), tuple(said), True) if said else None


def narrowest(task: Task, grid: ClearanceGrid) -> Gap | None:
    """Where the widest way narrows to less than the last link needs; None if it does not, or is not found.

    The widest way is found by bisection: the largest distance that a way over the grid can keep. No way anywhere is
    wider by more than the farthest that a place can be from a node.
    """
    stops = task.way_points
    needed = float(task.robot.body_radii[-1]) + task.clearance_wanted
    low, high = min(0.9 * grid.cell, needed), needed + grid.cell
    if _wide(grid, stops, high) is not None:
        return None
    way = _wide(grid, stops, low)
    if way is None:
        # What the grid does not see is there, perhaps.
        closed = low + BETWEEN * grid.cell < needed
        return _closed(task, grid, low) if closed else None
    while high - low > EXACT:
        middle = 0.5 * (low + high)
        wider = _wide(grid, stops, middle)
        low, high, way = (low, middle, way) if wider is None else (middle, high, wider)
    place, half = _opened(task, grid, way)
    if half >= needed:
        return None
    beside = _beside(task, task.clearance_wanted - task.margin)
    shown, limit = beside_limit(2e3 * half, 2e3 * needed, lower_bound=True)
    sentence = (
        f"blocked: the widest way found narrows to {shown} mm at {point(place, '.0f')}, beside "
        f"{task.scene.witness(place, place).obstacle!r}; the body of "
        f"{2e3 * (needed - task.clearance_wanted):g} mm with {beside} needs {limit} mm"
    )
    return Gap(half, needed - half, (sentence,), high + BETWEEN * grid.cell < needed)


def _beside(task: Task, taken: float) -> str:
    """What is wanted beside the body, where tolerances take so much (m), in words."""
    said = f"{1e3 * task.margin:g} mm margin"
    return said if task.budget is None else f"{said} and {1e3 * taken:.1f} mm tolerances"


def _closed(task: Task, grid: ClearanceGrid, least: float) -> Gap:
    """Why no way leads to the target within reach: none does, or the one that does is too long."""
    sentence, place, name = _barrier(task, grid, least)
    reach, base = longest_way(task), task.spec.base
    around = search_grid(task, FARTHER * reach)
    way = _wide(around, task.way_points, float(task.robot.body_radii[-1]) + task.clearance_wanted)
    if way is None:
        return Gap(0.0, 0.0, (sentence,), True)
    # Over the grid a way is longer than it is, by no more than this.
    length = float(np.linalg.norm(np.diff(around.cell * way, axis=0), axis=1).sum()) / ROUNDABOUT
    over, bars = max(length - reach, 0.0), f"at {point(place, '.0f')} it bars the way"
    if task.base.follows:
        said = (
            f"the way round {name!r} is longer than what is searched: {bars}, and round it are about "
            f"{1e3 * length:.0f} mm. Give places `via` that lead round it"
        )
        return Gap(0.0, 0.0, (said,), False)
    said = (
        f"the way round {name!r} is too long: {bars}, and round it are at least "
        f"about {1e3 * max(length, reach):.0f} mm; arm and {base.mover} reach {1e3 * reach:.1f} mm"
    )
    return Gap(0.0, 0.0, (said,), True, over)


def _barrier(task: Task, grid: ClearanceGrid, least: float) -> tuple[str, Array, str | None]:
    """What closes the target off, in a sentence, where (3,) m and which obstacle: where the easiest way through is."""
    said = f"the target is closed off: no way wider than {2e3 * (least + BETWEEN * grid.cell):.0f} mm leads to it"
    cost = np.where(grid.distance < least, THROUGH, 1.0)
    cost[grid.distance < 0] = np.inf
    way = way_over(grid, task.way_points, cost)
    if way is None:
        return said, task.way_points[-1], None
    values = grid.distance[tuple(way.T)]
    first = int(np.argmax(values < least))
    behind = np.flatnonzero(values[first:] >= least)
    last = first + int(behind[0]) if len(behind) else len(values)
    place = grid.origin + grid.cell * way[first + int(np.argmin(values[first:last]))]
    witness = task.scene.witness(place, place)
    place = np.array(witness.on_mesh)
    return f"{said}; {witness.obstacle!r} is in the way at {point(place, '.0f')}", place, witness.obstacle


def _wide(grid: ClearanceGrid, stops: Array, least: float) -> Nodes | None:
    """Nodes (k, 3) of a way over the grid that keeps a distance everywhere, or None."""
    return way_over(grid, stops, np.where(grid.distance < least, np.inf, 1.0))


def _opened(task: Task, grid: ClearanceGrid, way: Nodes) -> tuple[Array, float]:
    """The narrowest place of a way over the grid, moved to where it is widest around, and the distance there."""
    k = int(np.argmin(grid.distance[tuple(way.T)]))
    place = grid.origin + grid.cell * way[k]
    ahead = grid.cell * (way[min(k + 2, len(way) - 1)] - way[max(k - 2, 0)]).astype(np.float64)
    ahead /= max(float(np.linalg.norm(ahead)), 1e-12)
    random, half = np.random.default_rng(0), 0.0
    for scale in (1.0, 0.3, 0.1):
        offsets = random.uniform(-scale, scale, (400, 3)) * grid.cell
        offsets -= (offsets @ ahead)[:, None] * ahead
        offsets[0] = 0.0
        around = place + offsets
        found = task.scene.distance(around, around).value
        best = int(np.argmax(found))
        place, half = around[best], float(found[best])
    return place, half


def _more(value: float) -> str:
    """A figure above zero that does not look like zero."""
    return f"{value:.1f}" if value >= 0.05 else f"{value:.2g}"
