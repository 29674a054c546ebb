"""A task in which obstacles that move stand everywhere they ever are: what a route is searched in first."""

from __future__ import annotations

import numpy as np

from hognose.planning.task import Task
from hognose.scene import MovingObstacle, Scene
from hognose.scene.moving import parts_of
from hognose.scene.part import Part

#: An obstacle is placed so often that between two places none of its points goes farther than a body is thick …
#: … but at most so often, and with so many triangles. The checks of a plan do not depend on it.
MOST_PLACES, MOST_TRIANGLES = 200, 200_000


def around_moving(task: Task) -> Task:
    """The same task with obstacles that stand still, along their ways, in place of those that move."""
    thickness = 2.0 * float(task.robot.body_radii.min())
    swept = [part for each in task.moving for part in _everywhere(each, thickness)]
    return task.with_obstacles(Scene.from_parts([*parts_of(task.scene), *swept]))


def _everywhere(obstacle: MovingObstacle, apart: float) -> list[Part]:
    """An obstacle at places on its way so far (m) apart."""
    motion = obstacle.motion
    slid, turned = (float(way[0]) for way in motion.gone(motion.times[-1:] - 1e-12 * motion.period))
    most = max(2, min(MOST_PLACES, MOST_TRIANGLES // len(obstacle.scene.triangles)))
    count = int(np.clip(np.ceil((slid + turned * obstacle.reach) / apart) + 1, 2, most))
    times = motion.times[0] + np.linspace(0.0, motion.period * (1.0 - 1e-12), count)
    return [part for time in times for part in obstacle.parts_at(time)]
