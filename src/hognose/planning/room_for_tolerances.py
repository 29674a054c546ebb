"""Whether a budget of tolerances fits into the space at all, before anything is planned in it."""

from __future__ import annotations

import numpy as np

from hognose.errors import InfeasibleError
from hognose.planning.task import Task
from hognose.planning.tolerance.allowance import Allowance
from hognose.robot.base import joints_on
from hognose.wording import point


def refuse_wide_tolerances(task: Task) -> None:
    """Raise an InfeasibleError that names the first place to be passed where tolerances leave no room for the tip.

    At the entrance they are those of the straight arm; elsewhere those of its joints are left out, as their pose is not
    known yet. Places that are too narrow for the body alone are not for this to report.
    """
    budget = task.budget
    if budget is None:
        return
    places = task.way_points
    far = float(task.robot.body_radii[-1]) + 2.0 * task.clearance_wanted + 0.01  # beyond that, tolerances fit
    room = task.scene.distance(places, places, upper=far).value - task.robot.body_radii[-1] - task.margin
    taken = budget.of_base(places) + budget.sag[-1]
    words = ["" for _ in places]
    if task.base.lead() is None:
        none, at = np.zeros((1, task.robot.sections, 2)), task.base.coordinates(np.zeros(1), _straight(task))
        joints = joints_on(task.base, task.robot, none, at)
        allowance = Allowance.of(budget, task.base, none, at, joints)
        if np.linalg.norm(joints[0, -1] - places[0]) < 1e-6:
            taken[0] = allowance.at_steps(joints)[0, -1]
            words[0] = f" ({allowance.words(joints, 0, task.robot.sections - 1)})"
    for index in np.flatnonzero((room > 0) & (taken > room)):
        which = "the entrance" if index == 0 else "the target" if index == len(places) - 1 else f"way-point {index + 1}"
        obstacle = task.scene.witness(places[index], places[index]).obstacle
        raise InfeasibleError(
            f"tolerance: {which} at {point(places[index], 'g')} is so close to {obstacle!r} that the body of "
            f"{2e3 * task.robot.body_radii[-1]:g} mm and the margin of {1e3 * task.margin:g} mm leave "
            f"{1e3 * room[index]:.2f} mm, but tolerances take {1e3 * taken[index]:.2f} mm{words[index]}. Calibrate or "
            "register more closely, lower the margin, or take a way with more room."
        )


def _straight(task: Task) -> np.ndarray:
    """Joints and tip (1, n+1, 3) m of the straight arm at feed 0."""
    arcs = np.append(0.0, np.cumsum(task.robot.link_lengths))
    return (task.base.start + arcs[:, None] * task.base.direction)[None]
