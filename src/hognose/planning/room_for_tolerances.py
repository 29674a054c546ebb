"""Whether a budget of tolerances fits into the space at all, before anything is planned in it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InfeasibleError
from hognose.planning.penetration import per_section
from hognose.planning.places import places
from hognose.planning.task import Task
from hognose.planning.tolerance.allowance import Allowance
from hognose.robot.base import SAME_PLACE, joints_on, outline, straight_joints
from hognose.wording import point

Array = NDArray[np.float64]


def taken_at_least(task: Task) -> Array:
    """What tolerances take (m,) m at least of the tip's clearance at the places to be passed; 0 without tolerances.

    At an entrance where the arm begins it is that of the straight arm; elsewhere that of the joints is left out, as
    their pose is not known before there is a plan.
    """
    budget, passed = task.budget, task.way_points
    if budget is None:
        return np.zeros(len(passed))
    taken = budget.of_base(passed) + budget.sag[-1]
    begins = _at_the_entrance(task)
    if begins is not None:
        allowance, body = begins
        taken[0] = per_section(task.robot.outline.sections, allowance.at_steps(body), np.maximum)[0, -1]
    return taken


def refuse_wide_tolerances(task: Task) -> None:
    """Raise an InfeasibleError that names the first place to be passed where tolerances leave no room for the tip.

    See `taken_at_least`. Places that are too narrow for the body alone are not for this to report.
    """
    if task.budget is None:
        return
    named = places(task)
    passed = task.way_points
    far = float(task.robot.outline.inner_radii[-1]) + 2.0 * task.clearance_wanted + 0.01  # beyond that, tolerances fit
    room = task.scene.distance(passed, passed, upper=far).value - task.robot.outline.inner_radii[-1] - task.margin
    taken, begins = taken_at_least(task), _at_the_entrance(task)
    words = ["" for _ in passed]
    if begins is not None:
        words[0] = f" ({begins[0].words(begins[1], 0, task.robot.sections - 1)})"
    for index in np.flatnonzero((room > 0) & (taken > room)):
        _, which, at = named[index]
        obstacle = task.scene.witness(at, at).obstacle
        raise InfeasibleError(
            f"tolerance: {which} at {point(at, 'g')} is so close to {obstacle!r} that the body of "
            f"{2e3 * task.robot.outline.inner_radii[-1]:g} mm and the margin of {1e3 * task.margin:g} mm leave "
            f"{1e3 * room[index]:.2f} mm, but tolerances take {1e3 * taken[index]:.2f} mm{words[index]}. Calibrate or "
            "register more closely, lower the margin, or take a way with more room."
        )


def _at_the_entrance(task: Task) -> tuple[Allowance, Array] | None:
    """The allowance and outline (1, c+1, 3) m of the straight arm, if with these its tip is at the first place."""
    budget = task.budget
    if budget is None or not task.base.straight:
        return None
    none, at = (
        np.zeros((1, task.robot.sections, 2)),
        task.base.coordinates(np.zeros(1), straight_joints(task.base, task.robot)),
    )
    joints = joints_on(task.base, task.robot, none, at)
    if np.linalg.norm(joints[0, -1] - task.way_points[0]) > SAME_PLACE:
        return None
    return Allowance.of(budget, task.base, none, at, joints), outline(task.base, task.robot, joints, at)
