"""The following method of a task, for its robot on its base."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.following import Follower, follower
from hognose.following.on_base import run_on, section_base
from hognose.path import Path
from hognose.planning.task import Task
from hognose.robot.sections import MixedSections


def method_of(task: Task, path: Path, name: str | None = None) -> Follower:
    """A task's following method on a path, or another one by its name; errors as of `hognose.follower`.

    Also an InputError where sections of other kinds than links are on a base that does not say how they begin on it.
    """
    robot, motion = task.robot, task.spec.motion
    rest = (name or motion.method, motion.spacing, robot.bend_bounds)
    if not isinstance(robot.model, MixedSections):
        return follower(path, robot.link_lengths, *rest)
    return follower(path, robot.link_lengths, *rest, robot.model, *section_base(task.base))


def followed(task: Task, path: Path, feeds: ArrayLike, name: str | None = None) -> NDArray[np.float64]:
    """Joints and tip (T, n+1, 3) m at feeds (T,) m, where a new `method_of` puts them; errors of `hognose.follow`."""
    return method_of(task, path, name).run(feeds)


def followed_on_base(
    task: Task, path: Path, feeds: ArrayLike, name: str | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """As `followed`, and the coordinates (T, k) of the base at these feeds."""
    return run_on(task.base, method_of(task, path, name), feeds)
