"""Passages: curves from the entrance to the target that turn no more sharply than the joints can."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.route.search.arc_search import PITCH, search_arcs
from hognose.route.search.clearance_grid import ClearanceGrid

Array = NDArray[np.float64]

#: Parts of the sharpest bend that a move may have.
BENDS = (0.33, 0.67, 1.0)
#: A move turns by no more than this (rad): what bends more sharply is searched as if it bent less.
MOST_TURN = 0.6
#: Headings in a bin as wide as this part of the sharpest turn of a move are one; an odd number of bins (at least, at
#: most) a quarter turn has one round the straight heading, so that gentle bends are not dropped.
BIN, FEWEST_BINS, MOST_BINS = 1.3, 5, 21


@dataclass(frozen=True)
class Wish:
    """What a passage shall keep: distances in m, curvature in 1/m.

    Attributes
    ----------
    need
        Distance of the curve from obstacles below which it is no passage.
    wide
        Distance from which on more is no better.
    sharpest
        Curvature of the sharpest bend.
    longest
        Length of the whole passage.
    move
        Length of an arc.
    """

    need: float
    wide: float
    sharpest: float
    longest: float
    move: float

    @property
    def bins(self) -> int:
        """Bins of headings along each axis of a face of the cube of directions."""
        wanted = 0.5 * math.pi / (BIN * self.sharpest * self.move)
        return int(min(max(2 * int(wanted / 2) + 1, FEWEST_BINS), MOST_BINS))


def price(grid: ClearanceGrid, wish: Wish) -> Array:
    """Cost of a metre at each node (a, b, c); infinite where nothing passes."""
    # The field is known at nodes only: a passage through the middle of a hole may miss all of them.
    # Where nodes are far apart, less than that would let ways leak through thin walls.
    least = max(wish.need - 0.87 * grid.cell, min(0.87 * grid.cell, 0.6 * wish.need))
    blocked = grid.distance < least
    short = np.clip((wish.wide - grid.distance) / max(wish.wide - wish.need, 1e-3), 0.0, 3.0)
    return np.where(blocked, np.inf, 1.0 + 2.0 * short**2)


def passage(
    grid: ClearanceGrid, cost: Array, left: Array, start: Array, heading: Array, target: Array, wish: Wish, greed: float
) -> Array | None:
    """Points (m, 3) m, a move apart, of a curve from `start` along `heading` to the target; None if none is found.

    Parameters
    ----------
    grid
    cost, left : (a, b, c)
        From `price` and `cost_to_go`.
    start, heading, target : (3,)
    wish
    greed
        Weight of the estimate; above 1 the search is faster and the passage not the cheapest.
    """
    wish = dataclasses.replace(wish, sharpest=min(wish.sharpest, MOST_TURN / wish.move))
    shape = np.ceil(np.array(grid.distance.shape) * grid.cell / (PITCH * wish.move)).astype(np.int64) + 1
    parents, points, arrival = search_arcs(
        grid.distance,
        cost,
        left,
        grid.origin,
        grid.cell,
        np.asarray(start, float),
        np.asarray(heading, float),
        np.asarray(target, float),
        wish.need,
        wish.sharpest,
        wish.longest,
        wish.move,
        wish.bins,
        greed,
        np.array(BENDS),
        shape,
    )
    if len(parents) == 0:
        return None
    chain, at = [], len(parents) - 1
    while at >= 0:
        chain.append(points[at])
        at = parents[at]
    return np.concatenate([np.array(chain[::-1]), _last_arc(chain[0], arrival, np.asarray(target, float), wish.move)])


def _last_arc(place: Array, heading: Array, target: Array, move: float) -> Array:
    """Points (m, 3) of the arc that leaves a place along a heading and ends at the target, without the place."""
    away = target - place
    length = float(np.linalg.norm(away))
    side = away - (away @ heading) * heading
    beside = float(np.linalg.norm(side))
    half = math.asin(min(1.0, beside / length))
    parts = np.linspace(0.0, 1.0, max(1, math.ceil(length / move)) + 1)[1:]
    if half < 1e-9:
        return place + parts[:, None] * away
    radius = length / (2 * math.sin(half))
    turn = 2 * half * parts[:, None]
    arc = place + radius * (np.sin(turn) * heading + (1 - np.cos(turn)) * side / beside)
    arc[-1] = target
    return arc


def noise(grid: ClearanceGrid, random: np.random.Generator, strength: float, waves: float) -> Array:
    """A factor (a, b, c) about 1 that varies in waves of some random `waves` rad/m."""
    total = np.zeros(grid.distance.shape)
    for _ in range(4):
        wave, shift = random.normal(scale=waves, size=3), random.uniform(0, 2 * np.pi)
        # sin(u + v + w) is the imaginary part of a product.
        x, y, z = (np.exp(1j * wave[k] * grid.cell * np.arange(grid.distance.shape[k])) for k in range(3))
        total += (np.exp(1j * shift) * x[:, None, None] * (y[:, None] * z)).imag
    return np.exp(strength * total)
