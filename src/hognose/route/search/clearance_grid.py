"""The clearance field: distance to the obstacles at the nodes of a grid, where an arm of this length can be at all."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.planning.task import Task
from hognose.route.lengths import Lengths
from hognose.route.search.distance_field import distances
from hognose.scene import Scene

Array = NDArray[np.float64]

#: No more nodes than so many; where they would be farther apart than this many times the finest distance, up to more.
NODES, COARSE, MOST_NODES = 500_000, 1.5, 2_000_000


@dataclass(frozen=True, eq=False)
class ClearanceGrid:
    """Distances to obstacles at the nodes of a grid.

    Attributes
    ----------
    origin : (3,) m
        The node (0, 0, 0).
    cell
        Distance of neighbouring nodes, m.
    distance : (a, b, c) m
        To the closest surface, inside solids too; at most what was looked for. Negative out of reach.
        A search that keeps away from surfaces by more than a cell never gets into a solid.
    """

    origin: Array
    cell: float
    distance: Array

    def nodes(self, points: Array) -> NDArray[np.int64]:
        """The nodes (p, 3) closest to points (p, 3) m."""
        found = np.rint((points - self.origin) / self.cell).astype(np.int64)
        return np.clip(found, 0, np.array(self.distance.shape) - 1)

    def at(self, points: Array) -> Array:
        """Distance (p,) m at points (p, 3) m between the nodes, trilinear; beside the grid that of its edge."""
        last = np.array(self.distance.shape) - 1.0
        within = np.clip((points - self.origin) / self.cell, 0.0, last)
        low = np.minimum(within.astype(np.int64), last.astype(np.int64) - 1)
        part = within - low
        found = np.zeros(len(points))
        for corner in np.ndindex(2, 2, 2):
            weight = np.where(corner, part, 1.0 - part).prod(axis=1)
            found += weight * self.distance[tuple((low + corner).T)]
        return found

    def places(self) -> Array:
        """Coordinates (a, b, c, 3) m of all nodes."""
        axes = [self.origin[k] + self.cell * np.arange(self.distance.shape[k]) for k in range(3)]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def search_grid(task: Task, reach: float | None = None) -> ClearanceGrid:
    """The clearance field that a task is searched in, as far as the arm reaches or as far as a reach (m)."""
    lengths, stops = Lengths.of_task(task), task.way_points
    longest = 1.02 * lengths.reach if reach is None else reach
    return room_between(task.scene, stops[0], stops[1:], longest, lengths.cell, lengths.far)


def room_between(scene: Scene, entrance: Array, stops: Array, reach: float, finest: float, far: float) -> ClearanceGrid:
    """The clearance field of all places that a path of length `reach` m can pass on its way.

    Parameters
    ----------
    scene
    entrance : (3,) m
    stops : (k, 3) m
        Where the path goes, the target last.
    reach
        Longest path in m. A path from a to b that is no longer stays within the ellipsoid |p − a| + |p − b| ≤ reach.
    finest
        Distance of neighbouring nodes in m, unless that makes too many.
    far
        Distances in m beyond this are not looked for: so much grid is as good as any.

    Returns
    -------
    ClearanceGrid
    """
    places = np.concatenate([entrance[None], stops])
    low, high = _box(places[0], places[-1], reach)
    low, high = np.minimum(low, places.min(axis=0)), np.maximum(high, places.max(axis=0))
    volume = float(np.prod(high - low)) * np.pi / 6
    few, many = ((volume / nodes) ** (1 / 3) for nodes in (NODES, MOST_NODES))
    cell = max(finest, min(few, max(COARSE * finest, many)))
    low = entrance - np.ceil((entrance - low) / cell + 1) * cell  # a node is at the entrance
    shape = tuple(int(n) for n in np.ceil((high - low) / cell) + 2)
    grid = ClearanceGrid(low, cell, np.full(shape, far))
    if scene.names:
        distances(scene.triangles, scene.growth[scene.owner], low, cell, far, grid.distance)
    nodes = grid.places()
    around = np.linalg.norm(nodes - places[0], axis=-1) + np.linalg.norm(nodes - places[-1], axis=-1)
    grid.distance[around > reach + 2 * cell] = -1.0
    return grid


def _box(first: Array, last: Array, reach: float) -> tuple[Array, Array]:
    """The box round the ellipsoid of all points p with |p − first| + |p − last| ≤ reach."""
    half = 0.5 * max(reach, 1.02 * float(np.linalg.norm(last - first)))
    focus = 0.5 * (last - first)
    wide = np.sqrt(np.maximum(half**2 - focus @ focus + focus**2, 0.0))
    middle = 0.5 * (first + last)
    return middle - wide, middle + wide
