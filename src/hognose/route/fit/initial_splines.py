"""Where a spline through a passage begins: how many spans, and way-points along the passage or along another spline."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hognose.robot import Robot
from hognose.route.fit.improve import judged_or_none
from hognose.route.fit.objective import Judged, Objective
from hognose.route.lengths import Lengths
from hognose.route.polyline import even

Array = NDArray[np.float64]

#: No span is shorter than this part of a link.
SHORTEST_SPAN = 0.5


def spread(guide: Array, stops: Array, spans: int) -> tuple[Array, NDArray[np.bool_]]:
    """Way-points (spans + 1, 3) along a guide, and which of those behind the first may move: all that are no stops."""
    fine = even(guide, float(np.linalg.norm(np.diff(guide, axis=0), axis=1).sum()) / 500)
    arcs = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(fine, axis=0), axis=1))])
    begin, at = 0, [0.0]
    for stop in stops[1:-1]:
        begin += int(np.argmin(np.linalg.norm(fine[begin:] - stop, axis=1)))
        at.append(float(arcs[begin]))
    at.append(float(arcs[-1]))
    way_points, free = [stops[0]], []
    for (low, high), stop in zip(itertools.pairwise(at), stops[1:], strict=True):
        count = max(1, round(spans * (high - low) / arcs[-1]))
        for s in np.linspace(low, high, count + 1)[1:-1]:
            way_points.append(np.array([np.interp(s, arcs, fine[:, k]) for k in range(3)]))
            free.append(True)
        way_points.append(stop)
        free.append(False)
    return np.array(way_points), np.array(free)


def better_start(
    objective: Objective, way_points: Array, fewer: Judged | None, stops: Array, spans: int
) -> tuple[Objective, Array]:
    """The way-points through a passage, or those along a spline of fewer spans, whichever the arm follows better."""
    if fewer is None:
        return objective, way_points
    path, run = fewer.motion.path, objective.base.run
    along, free = spread(path.point(np.linspace(run, path.length, 500)), stops, spans)
    other = replace(objective, free=free)
    first, second = judged_or_none(objective, way_points), judged_or_none(other, along)
    if second is None or (first is not None and first.score >= second.score):
        return objective, way_points
    return other, along


def numbers_of_spans(guide: Array, robot: Robot, lengths: Lengths) -> list[int]:
    """How many spans to try: fewer on short ways, where so many would be shorter than the arm can tell."""
    length = float(np.linalg.norm(np.diff(guide, axis=0), axis=1).sum())
    most = max(2, int(length / (SHORTEST_SPAN * robot.link_lengths.max())))
    return sorted({min(spans, most) for spans in lengths.spans})
