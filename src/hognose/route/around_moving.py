"""A task in which obstacles that move stand everywhere they ever are: what a route is searched in first."""

from __future__ import annotations

import numpy as np

from hognose.planning.task import Task
from hognose.scene import MovingObstacle, Scene
from hognose.scene.moving import parted
from hognose.scene.obstacle import named_parts
from hognose.scene.part import Part

#: An obstacle is placed so often that between two places none of its points goes farther than a body is thick …
#: … but at most so often, and with so many triangles. The checks of a plan do not depend on it.
MOST_PLACES, MOST_TRIANGLES = 200, 200_000


def around_moving(task: Task) -> Task:
    """The same task with obstacles that stand still, along their ways, in place of those that move."""
    still = Task(task.spec, task.robot)
    standing = named_parts(parted(task.spec.obstacle)[0])
    boxes = enumerate(task.spec.path.keep_out, 1)
    standing += named_parts(box.model_copy(update={"name": box.name or f"keep-out {k}"}) for k, box in boxes)
    thickness = 2.0 * float(task.robot.body_radii.min())
    swept = [part for each in task.moving for part in _everywhere(each, thickness)]
    vars(still)["scene"], vars(still)["moving"] = Scene.from_parts([*standing, *swept]), ()
    return still


def _everywhere(obstacle: MovingObstacle, apart: float) -> list[Part]:
    """An obstacle at places on its way so far (m) apart."""
    motion, scene = obstacle.motion, obstacle.scene
    slid, turned = (float(way[0]) for way in motion.gone(motion.times[-1:] - 1e-12 * motion.period))
    most = max(2, min(MOST_PLACES, MOST_TRIANGLES // len(scene.triangles)))
    count = int(np.clip(np.ceil((slid + turned * obstacle.reach) / apart) + 1, 2, most))
    first = motion.times[0]
    return [
        Part(
            name,
            motion.out_of_frame(scene.triangles[scene.owner == number], time),
            float(scene.growth[number]),
            bool(scene.solid[number]),
        )
        for time in first + np.linspace(0.0, motion.period * (1.0 - 1e-12), count)
        for number, name in enumerate(scene.names)
    ]
