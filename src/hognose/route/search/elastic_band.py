"""A way over the clearance grid, relaxed until it is smooth: an elastic band.

It is pulled straight by its neighbours and pushed away by obstacles. Source: Quinlan and Khatib (1993), "Elastic bands:
connecting path planning and control"; own code.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.route.polyline import even
from hognose.route.search.clearance_grid import ClearanceGrid
from hognose.route.search.passages import Wish

Array = NDArray[np.float64]

#: Distances of places, in moves: large ones smooth the whole, small ones keep it from obstacles.
PARTS = (2.0, 1.0, 0.5)
#: Rounds with each, and how far a place goes in one towards the middle of its neighbours and, of what is missing, away.
ROUNDS, PULL, PUSH = 40, 0.5, 0.15
#: Obstacles push within so many times the width needed; a band must keep this part of it.
WITHIN, KEPT = 1.2, 0.83
#: It may be so many times as long as wished and bend so many times as sharply: splines along it bend less.
LONGER, SHARPER = 1.06, 2.0


def relaxed(grid: ClearanceGrid, way: Array, heading: Array, wish: Wish) -> Array | None:
    """Points (m, 3) of a curve near a way (k, 3) over the grid, from its first place to its last; None if none passes.

    Parameters
    ----------
    grid
    way : (k, 3) m
    heading : (3,)
        At the first place.
    wish
        Distances and bends. A band that bends more sharply is none.
    """
    points = way
    for part in PARTS:
        points = even(points, part * wish.move)
        spacing = float(np.linalg.norm(points[1] - points[0]))
        # A place behind the first one keeps the heading there.
        points = np.concatenate([points[:1] - spacing * heading, points])
        for _ in range(ROUNDS):
            inner = points[2:-1]
            short = np.maximum(WITHIN * wish.need - grid.at(inner), 0.0)
            pull = 0.5 * (points[1:-2] + points[3:]) - inner
            points[2:-1] = inner + PULL * pull + PUSH * short[:, None] * _uphill(grid, inner)
        points = points[1:]
    first = float(np.linalg.norm(points[1] - points[0]))
    chords = np.diff(np.concatenate([points[:1] - first * heading, points]), axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    turns = np.linalg.norm(np.diff(chords / np.maximum(lengths, 1e-12)[:, None], axis=0), axis=1)
    bends = turns / (0.5 * (lengths[1:] + lengths[:-1]))
    passes = grid.at(points).min() >= KEPT * wish.need and lengths[1:].sum() <= LONGER * wish.longest
    return points if passes and bends.max() <= SHARPER * wish.sharpest else None


def _uphill(grid: ClearanceGrid, points: Array) -> Array:
    """The direction (p, 3) in which the distance to obstacles grows, at points (p, 3)."""
    steps = grid.cell * np.eye(3)
    slope = np.stack([grid.at(points + step) - grid.at(points - step) for step in steps], axis=1)
    return slope / np.maximum(np.linalg.norm(slope, axis=1), 1e-12)[:, None]
