"""In which poses an arm is clear of what is around it, though it may be off by as much as it can be before."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hognose.calibration.fit import Prior
from hognose.calibration.model import Model
from hognose.errors import InfeasibleError
from hognose.planning import Task
from hognose.robot.base import joints_on

Array = NDArray[np.float64]

#: So many standard deviations of where the tip is before the calibration are kept clear, beside the margin: three, and
#: as much to the other side, when the arm swings.
_COVERAGE = 6.0
#: Where on the way from the straight arm to a pose the arm is looked at.
_SHARES = np.linspace(0.1, 1.0, 10)


def start_of(task: Task, back: float = 0.0) -> Array:
    """Coordinates (k,) of the base with the arm straight before the entrance, drawn back by `back` (m)."""
    along = np.concatenate([[0.0], np.cumsum(task.robot.link_lengths)]) - back
    joints = task.base.start + along[:, None] * task.base.direction
    return task.base.coordinates(np.array([-back]), joints[None])[0]


def clear_of(task: Task, model: Model, prior: Prior, at: Array) -> Callable[[Array], NDArray[np.bool_]]:
    """Of angles (T, n, 2) rad: to where the straight arm can bend, all joints at once, clear of a task's obstacles.

    Clear by the margin and by how far the arm can be off before it is calibrated; its base is at (k,).

    Raises
    ------
    InfeasibleError
        Not even the straight arm is clear.
    """
    robot, scene = task.robot, task.scene_at(0.0)
    room = task.margin + _COVERAGE * before(model, prior)

    def is_free(angles: Array) -> NDArray[np.bool_]:
        way = (_SHARES[None, :, None, None] * angles[:, None]).reshape(-1, robot.sections, 2)
        joints = joints_on(task.base, robot, way, np.broadcast_to(at, (len(way), len(at))).copy())
        found = scene.clearance(joints[:, :-1], joints[:, 1:], robot.body_radii, horizon=2.0 * room).value
        return found.reshape(len(angles), -1).min(axis=1) >= room

    if not is_free(np.zeros((1, robot.sections, 2)))[0]:
        raise InfeasibleError(
            f"calibration of {task.name}: before it is calibrated, the arm can hang and swing by {1e3 * room:.0f} mm, "
            "and straight it is closer to an obstacle: draw its base back, clamp it in a jig, or calibrate it outside"
        )
    return is_free


def before(model: Model, prior: Prior) -> float:
    """How far (m) the tip of the straight arm is off before a calibration, standard deviation over all directions."""
    arm, straight = model.nominal, np.zeros((1, model.nominal.robot.sections, 2))
    held = arm.hold(straight, model.gravity)
    by = model.derived(arm, straight, held.tensions, held.load_factor > 1.0).by_tips[0]
    known = np.full(model.unknowns, prior.stiffness)
    known[: model.cables] = prior.zero
    return float(np.linalg.norm(by * known))
