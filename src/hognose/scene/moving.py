"""An obstacle that moves."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from hognose.cached import cached_property
from hognose.errors import InputError
from hognose.scene.obstacle import ObstacleModel, titles
from hognose.scene.part import Part
from hognose.scene.rigid_motion import RigidMotion
from hognose.scene.scene import Scene


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

    def parts_at(self, time: float) -> list[Part]:
        """Its parts where they are in the task at a time (s)."""
        return [replace(p, triangles=self.motion.out_of_frame(p.triangles, time)) for p in parts_of(self.scene)]


def parts_of(scene: Scene) -> list[Part]:
    """What a scene was made of."""
    return [
        Part(name, scene.triangles[scene.owner == k], float(scene.growth[k]), bool(scene.solid[k]), int(scene.shell[k]))
        for k, name in enumerate(scene.names)
    ]


def parted(obstacles: Iterable[ObstacleModel], timing: float = 0.0) -> tuple[list[ObstacleModel], list[MovingObstacle]]:
    """Those of some obstacles that stand still, and those that move; named as they are all together.

    `timing` (s) is that of obstacles which do not say their own.
    """
    items = list(obstacles)
    if not any(item.motion for item in items):
        return items, []
    names = titles(items)
    for item, name in zip(items, names, strict=True):
        if item.motion and names.count(name) > 1:
            raise InputError(f'{names.count(name)} obstacles are called "{name}"; give each its own name')
    named = [item.model_copy(update={"name": name}) for item, name in zip(items, names, strict=True)]
    moving = [
        MovingObstacle(
            item.name or "",
            Scene.from_obstacles([item]),
            item.said_motion.made(),
            timing if item.timing_s is None else item.timing_s,
        )
        for item in named
        if item.motion
    ]
    return [item for item in named if not item.motion], moving
