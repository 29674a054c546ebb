"""Cheapest ways over the clearance grid: they know the obstacles, not how the arm bends."""

from __future__ import annotations

import heapq
import itertools
import math

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.route.search.clearance_grid import ClearanceGrid

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]

#: The way over the grid is not known at places from where it costs more than so many times as much as from the start.
ASTRAY = 1.6


def cost_to_go(grid: ClearanceGrid, cost: Array, target: Array, start: Array | None = None) -> Array:
    """Cost (a, b, c) of the cheapest way over the grid from each node to the target (Dijkstra).

    With a start (3,) it stays infinite where it is `ASTRAY` times as much as from there.
    """
    out = np.full(grid.distance.shape, np.inf)
    goal = grid.nodes(target[None])[0]
    last = np.full(3, -1) if start is None else grid.nodes(start[None])[0]
    _spread(cost, grid.cell, goal, last, ASTRAY, out)
    return out


@kernel()
def _spread(cost: NDArray, cell: float, goal: NDArray, last: NDArray, astray: float, out: NDArray) -> None:
    """Dijkstra's search over the 26 neighbours."""
    a, b, c = cost.shape
    i, j, k = int(goal[0]), int(goal[1]), int(goal[2])
    out[i, j, k] = 0.0
    queue = [(0.0, i, j, k)]
    enough = np.inf
    while len(queue) > 0:
        paid, i, j, k = heapq.heappop(queue)
        if paid > out[i, j, k]:
            continue
        if paid > enough:
            break
        if i == last[0] and j == last[1] and k == last[2]:
            enough = astray * paid
        for di in range(-1, 2):
            for dj in range(-1, 2):
                for dk in range(-1, 2):
                    x, y, z = i + di, j + dj, k + dk
                    if x < 0 or y < 0 or z < 0 or x >= a or y >= b or z >= c:
                        continue
                    if not cost[x, y, z] < np.inf:
                        continue
                    step = cell * math.sqrt(di * di + dj * dj + dk * dk)
                    here = cost[i, j, k] if cost[i, j, k] < np.inf else cost[x, y, z]
                    total = paid + 0.5 * step * (here + cost[x, y, z])
                    if total < out[x, y, z]:
                        out[x, y, z] = total
                        heapq.heappush(queue, (total, x, y, z))


def way_over(grid: ClearanceGrid, stops: Array, cost: Array) -> Nodes | None:
    """Nodes (k, 3) of the cheapest way over the grid through all stops (s, 3), or None."""
    nodes = [grid.nodes(stops[:1])]
    for start, target in itertools.pairwise(stops):
        left = cost_to_go(grid, cost, target)
        legs = downhill(grid, left, start)
        if legs is None:
            return None
        nodes.append(legs[1:])
    return np.concatenate(nodes)


def downhill(grid: ClearanceGrid, left: Array, start: Array) -> Nodes | None:
    """Nodes (k, 3) of the cheapest way from a start (3,), given the cost to go; None if there is none."""
    at = grid.nodes(start[None])[0]
    if not np.isfinite(left[tuple(at)]):
        return None
    nodes = [at]
    while left[tuple(at)] > 0:
        low, high = np.maximum(at - 1, 0), np.minimum(at + 2, left.shape)
        window = left[low[0] : high[0], low[1] : high[1], low[2] : high[2]]
        at = low + np.array(np.unravel_index(int(np.argmin(window)), window.shape))
        nodes.append(at)
    return np.array(nodes)


def along(grid: ClearanceGrid, left: Array, start: Array, target: Array) -> Array:
    """Places (k, 3) m of the cheapest way from a start to the target (3,), which must be reached from there."""
    nodes = downhill(grid, left, start)
    assert nodes is not None
    return np.concatenate([start[None], grid.origin + grid.cell * nodes[1:-1], target[None]])
