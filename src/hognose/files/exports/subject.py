"""What models for other programs are made of: an arm, maybe on its base in a space, and maybe with a motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.cached import cached_property
from hognose.planning import Task
from hognose.planning.gravity import DOWN
from hognose.planning.plan import Plan
from hognose.robot import Robot
from hognose.robot.base import Base, Slider
from hognose.scene import Scene


@dataclass(frozen=True, eq=False)
class Subject:
    """An arm; with a task, its space and base; with a plan, its motion."""

    robot: Robot
    task: Task | None = None
    plan: Plan | None = None

    @classmethod
    def of_task(cls, task: Task) -> Subject:
        """A task without a motion."""
        return cls(task.robot, task)

    @classmethod
    def of_plan(cls, plan: Plan) -> Subject:
        """A plan."""
        return cls(plan.robot, plan.task, plan)

    @property
    def name(self) -> str:
        """What it is called."""
        return self.robot.name if self.task is None else self.task.name

    @cached_property
    def base(self) -> Base:
        """What the arm stands on; a robot alone is on its slider, at the origin and along +z."""
        if self.task is not None:
            return self.task.base
        return Slider.before(np.array([0.0, 0.0, self.robot.length]), self.robot)

    @cached_property
    def scene(self) -> Scene:
        """The obstacles, those that move as they are at time 0."""
        return Scene.from_parts([]) if self.task is None else self.task.scene_at(0.0)

    @property
    def moving(self) -> tuple[str, ...]:
        """Names of the obstacles that move."""
        return () if self.task is None else tuple(each.name for each in self.task.moving)

    @property
    def gravity(self) -> NDArray[np.float64]:
        """Acceleration (3,) m/s² in the frame of the task."""
        return np.array(DOWN if self.task is None else self.task.spec.gravity_m_s2)
