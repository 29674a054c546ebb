"""In which poses an arm is clear of what is around it, though it may be off by as much as it can be before."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hognose.calibration.fit import Prior
from hognose.calibration.model import Model
from hognose.planning import Task
from hognose.robot.base import joints_on

Array = NDArray[np.float64]

#: So many standard deviations of where the tip is before the calibration are kept clear, beside the margin.
_COVERAGE = 3.0


def start_of(task: Task) -> Array:
    """Coordinates (k,) of the base where a task begins, with the arm straight before the entrance."""
    along = np.concatenate([[0.0], np.cumsum(task.robot.link_lengths)])
    joints = task.base.start + along[:, None] * task.base.direction
    return task.base.coordinates(np.zeros(1), joints[None])[0]


def clear_of(task: Task, model: Model, prior: Prior) -> Callable[[Array], NDArray[np.bool_]]:
    """Of angles (T, n, 2) rad: where the arm is clear of the obstacles of its task, with its base where it begins."""
    robot, at = task.robot, start_of(task)
    room = task.margin + _COVERAGE * before(model, prior)
    scene = task.scene_at(0.0)

    def is_free(angles: Array) -> NDArray[np.bool_]:
        joints = joints_on(task.base, robot, angles, np.broadcast_to(at, (len(angles), len(at))).copy())
        found = scene.clearance(joints[:, :-1], joints[:, 1:], robot.body_radii, horizon=2.0 * room)
        return found.value.min(axis=1) >= room

    return is_free


def before(model: Model, prior: Prior) -> float:
    """How far (m) the tip of the straight arm is off before a calibration, standard deviation over all directions."""
    arm, straight = model.nominal, np.zeros((1, model.nominal.robot.sections, 2))
    held = arm.hold(straight, model.gravity)
    by = model.derived(arm, straight, held.tensions, held.load_factor > 1.0).by_tips[0]
    known = np.full(model.unknowns, prior.stiffness)
    known[: model.cables] = prior.zero
    return float(np.linalg.norm(by * known))
