"""Whether a budget of tolerances fits into the space at all, before anything is planned in it."""

from __future__ import annotations

import numpy as np

from hognose.errors import InfeasibleError
from hognose.planning.places import places
from hognose.planning.task import Task
from hognose.planning.tolerance.allowance import Allowance
from hognose.robot.base import SAME_PLACE, joints_on, straight_joints
from hognose.wording import point


def refuse_wide_tolerances(task: Task) -> None:
    """Raise an InfeasibleError that names the first place to be passed where tolerances leave no room for the tip.

    At the entrance they are those of the straight arm; elsewhere those of its joints are left out, as their pose is not
    known yet. Places that are too narrow for the body alone are not for this to report.
    """
    budget = task.budget
    if budget is None:
        return
    named = places(task)
    passed = task.way_points
    far = float(task.robot.body_radii[-1]) + 2.0 * task.clearance_wanted + 0.01  # beyond that, tolerances fit
    room = task.scene.distance(passed, passed, upper=far).value - task.robot.body_radii[-1] - task.margin
    taken = budget.of_mount(passed, passed) + budget.sag[-1]
    words = ["" for _ in passed]
    if task.base.straight:
        none = np.zeros((1, task.robot.sections, 2))
        at = task.base.coordinates(np.zeros(1), straight_joints(task.base, task.robot))
        joints = joints_on(task.base, task.robot, none, at)
        allowance = Allowance.of(budget, task.base, none, at, joints)
        if np.linalg.norm(joints[0, -1] - passed[0]) <= SAME_PLACE:
            taken[0] = allowance.at_steps(joints)[0, -1]
            words[0] = f" ({allowance.words(joints, 0, task.robot.sections - 1)})"
    for index in np.flatnonzero((room > 0) & (taken > room)):
        _, which, at = named[index]
        obstacle = task.scene.witness(at, at).obstacle
        raise InfeasibleError(
            f"tolerance: {which} at {point(at, 'g')} is so close to {obstacle!r} that the body of "
            f"{2e3 * task.robot.body_radii[-1]:g} mm and the margin of {1e3 * task.margin:g} mm leave "
            f"{1e3 * room[index]:.2f} mm, but tolerances take {1e3 * taken[index]:.2f} mm{words[index]}. Calibrate or "
            "register more closely, lower the margin, or take a way with more room."
        )
