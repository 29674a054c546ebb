"""An obstacle that moves."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.cached import cached_property
from hognose.errors import InputError
from hognose.scene.obstacle import ObstacleModel, titles
from hognose.scene.rigid_motion import RigidMotion
from hognose.scene.scene import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MovingObstacle:
    """An obstacle that moves: a scene of its own, as placed, and how it moves from there.

    Attributes
    ----------
    name
    scene
        In the frame in which it was placed; nothing in it is made anew as it moves.
    motion
    timing : s
        It may be where it is meant to be up to so much earlier or later.
    """

    name: str
    scene: Scene
    motion: RigidMotion
    timing: float

    @cached_property
    def reach(self) -> float:
        """How far (m) its points are from the pivot at most."""
        corners = self.scene.triangles.reshape(-1, 3)
        return float(np.linalg.norm(corners - self.motion.pivot, axis=1).max() + self.scene.growth.max())

    def triangles_at(self, time: float) -> Array:
        """Its triangles (m, 3, 3) m in the frame of the task at a time (s)."""
        return self.motion.out_of_frame(self.scene.triangles, time)


def parted(obstacles: Iterable[ObstacleModel]) -> tuple[list[ObstacleModel], list[MovingObstacle]]:
    """Those of some obstacles that stand still, and those that move; named as they are all together."""
    items = list(obstacles)
    if not any(item.motion for item in items):
        return items, []
    names = titles(items)
    for item, name in zip(items, names, strict=True):
        if item.motion and names.count(name) > 1:
            raise InputError(f'{names.count(name)} obstacles are called "{name}"; give each its own name')
    named = [item.model_copy(update={"name": name}) for item, name in zip(items, names, strict=True)]
    moving = [
        MovingObstacle(item.name or "", Scene.from_obstacles([item]), item.said_motion.made(), item.timing_s)
        for item in named
        if item.motion
    ]
    return [item for item in named if not item.motion], moving
