"""Places so far from all obstacles that their unit or their frame is probably another one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.robot import Robot
from hognose.scene import Scene
from hognose.wording import mm, point

Array = NDArray[np.float64]


def outside(boxes: Array, places: Array) -> Array:
    """How far (b, m) m places (m, 3) m are outside boxes (b, 2, 3) m; 0 inside."""
    low, high = boxes[:, None, 0], boxes[:, None, 1]
    return np.linalg.norm(np.maximum(np.maximum(low - places, places - high), 0.0), axis=2)


def remark_of_distance(scene: Scene, way_points: Array, robot: Robot) -> str | None:
    """A sentence if all way-points (m, 3) m are farther than an arm's length from every obstacle; else None."""
    if not len(scene.bounds):
        return None
    nearest = float(outside(scene.bounds, way_points).min())
    if nearest <= robot.length:
        return None
    low, high = scene.bounds[:, 0].min(axis=0), scene.bounds[:, 1].max(axis=0)
    return (
        f"all way-points are {mm(nearest, '.0f')} or more from the obstacles, more than the arm's length of "
        f"{mm(robot.length, '.0f')}; these go from {point(low, '.5g')} to {point(high, '.5g')}: check the file's "
        "`units`, those of the obstacles, and the frame of the way-points"
    )
