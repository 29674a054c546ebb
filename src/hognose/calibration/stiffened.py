"""A task whose arm has the stiffness that was found, so that it is planned, and its cables commanded, with that."""

from __future__ import annotations

from numpy.typing import ArrayLike

from hognose.arguments import floats
from hognose.mechanics import Mechanics
from hognose.planning import Task
from hognose.robot import Robot


def with_stiffness(task: Task, factors: ArrayLike) -> Task:
    """The same task, with EA of each section's own cables times factors (n,).

    Raises
    ------
    InputError
        The mechanics of the robot are not known, or the factors are not one for each section.
    """
    spec, nominal = task.robot.spec, Mechanics.of(task.robot)
    assert spec.cables is not None, "Mechanics.of"
    given = floats("factors", factors, f"({task.robot.sections},)", "")
    of_sections = nominal.axial_stiffness[task.robot.first_cables[:-1]] * given
    cables = spec.cables.model_copy(update={"axial_stiffness_N": tuple(of_sections.tolist())})
    made = Task(task.spec, Robot.from_spec(spec.model_copy(update={"cables": cables})))
    made.share_obstacles(task)
    return made
