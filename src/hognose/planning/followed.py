"""The following method of a task, for its robot on its base."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.errors import InputError
from hognose.following import Follower, follower
from hognose.path import Path
from hognose.planning.task import Task
from hognose.robot.base import Slider
from hognose.robot.sections import MixedSections


def method_of(task: Task, path: Path, name: str | None = None) -> Follower:
    """A task's following method on a path, or another one by its name; errors as of `hognose.follower`.

    Also an InputError where sections of other kinds than links stand on a base that turns: nothing says which way they
    begin.
    """
    robot, motion = task.robot, task.spec.motion
    rest = (name or motion.method, motion.spacing, robot.bend_bounds)
    if not isinstance(robot.model, MixedSections):
        return follower(path, robot.link_lengths, *rest)
    if not isinstance(task.base, Slider):
        raise InputError(
            f"base.kind: {robot.name} has sections that are no rigid links, which are followed from a slider or a cart "
            f"so far, not from a base of kind {task.spec.base.kind!r}"
        )
    axes = np.eye(3) if task.base.R_task_base is None else task.base.R_task_base
    return follower(path, robot.link_lengths, *rest, robot.model, axes)


def followed(task: Task, path: Path, feeds: ArrayLike, name: str | None = None) -> NDArray[np.float64]:
    """Joints and tip (T, n+1, 3) m at feeds (T,) m, where a new `method_of` puts them; errors of `hognose.follow`."""
    return method_of(task, path, name).run(feeds)
