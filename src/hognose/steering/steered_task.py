"""What has been steered as a task of its own: way-points whose spline is the grown path, planned and checked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from hognose.arguments import positive
from hognose.errors import InfeasibleError, InputError
from hognose.path import Path
from hognose.planning.base_spec import BaseSpec, WorkspaceSpec
from hognose.planning.motion_spec import MotionSpec
from hognose.planning.plan import Plan
from hognose.planning.planner import plan_along
from hognose.planning.task import PathSpec, Task, TaskSpec
from hognose.planning.tolerance.spec import ToleranceSpec
from hognose.robot import Robot
from hognose.robot.base import Base, axes_of, straight_joints
from hognose.robot.carrier import Carrier
from hognose.scene import Obstacle

Array = NDArray[np.float64]

#: Spacings of the way-points that are tried, in parts of the longest link.
_SPACINGS = (1.0, 0.5, 0.25, 0.125, 0.0625)
_MOST_WAY_POINTS = 500
#: How far apart (m) the places are at which the grown path and the spline are compared.
_COMPARED = 0.001
#: Slowing down, a little more than needed.
_SLOWER = 1.02
#: Checks that a longer period mends, and the power of the period that they fall with.
_MENDED = {
    **dict.fromkeys(("joint_speed", "feed_speed", "cable_speed", "carrier_speed", "carrier_turn_speed"), 1),
    **dict.fromkeys(("joint_acceleration", "feed_acceleration", "cable_acceleration"), 2),
    **dict.fromkeys(("carrier_acceleration", "carrier_turn_acceleration"), 2),
}


@dataclass(frozen=True, eq=False)
class SteeredTask:
    """A steered path as a task.

    Attributes
    ----------
    spec
        What its file says: entrance, way-points, target, obstacles.
    plan
        Its plan; every check passed.
    deviation : m
        Largest distance of the grown path to the planned spline.
    """

    spec: TaskSpec
    plan: Plan
    deviation: float

    @property
    def task(self) -> Task:
        """The task that was planned."""
        return self.plan.task


def refuse_moving(task: Task) -> None:
    """Raise an InputError that names the first obstacle that moves."""
    if task.moving:
        raise InputError(
            f"obstacle {task.moving[0].name!r} moves: an arm that is steered by hand has no times at which to meet it. "
            "Steer in a task without its `motion`, or plan this one"
        )


def spec_without_way(
    name: str,
    robot: Robot,
    margin: float,
    template: TaskSpec | None,
    obstacles: Sequence[Obstacle] | None,
    base: Base,
    method: str,
) -> TaskSpec:
    """A task with a name, a margin and obstacles, and some way-points to be replaced.

    Parameters
    ----------
    name
        Of the task.
    robot
        Its name is written where there is no template.
    margin : m
    template
        Whose robot, motion and obstacles are taken over, or None.
    obstacles
        Those to write; None for the template's, and the boxes it keeps out of.
    base
        Where the arm was steered from: a slider, or a carrier.
    method
        With which it followed.

    Raises
    ------
    InputError
        A name that a task cannot have.
    """
    if obstacles is None:
        boxes = enumerate(template.path.keep_out if template else (), 1)
        closed = [box.model_copy(update={"name": box.name or f"keep-out {k}"}) for k, box in boxes]
        obstacles = [*(template.obstacle if template else ()), *closed]
    motion = template.motion if template else MotionSpec()
    try:
        return TaskSpec(
            name=name,
            description="Steered by hand",
            robot=template.robot if template else robot.name,
            margin=margin,
            tolerance=template.tolerance if template else ToleranceSpec(),
            base=_said(base, robot, template),
            path=PathSpec(way_points=((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), detour=False),
            motion=motion.model_copy(update={"method": method, "tip_tolerance": None}),
            obstacle=tuple(obstacles),
        )
    except ValidationError as error:
        raise InputError(f"name: expected 1 to 80 characters, and obstacles of the known kinds: {error}") from None


def _said(base: Base, robot: Robot, template: TaskSpec | None) -> BaseSpec:
    """What a task file says of a base: as the template does, or as it stands."""
    if template is not None:
        told = template.base
    elif isinstance(base, Carrier):
        box = None if base.workspace is None else WorkspaceSpec(low=_at(base.workspace[0]), high=_at(base.workspace[1]))
        told = BaseSpec(kind="arm", workspace=box)
    else:
        told = BaseSpec()
    return told.as_it_stands(axes_of(base, base.coordinates(np.zeros(1), straight_joints(base, robot)))[0])


def _at(place: Array) -> tuple[float, float, float]:
    return float(place[0]), float(place[1]), float(place[2])


def plan_steered(spec: TaskSpec, robot: Robot, path: Path, tolerance: float) -> SteeredTask:
    """The task with as many way-points on a path, behind the slider's run, as a good plan close to it needs.

    Raises
    ------
    InputError
        A path that has not grown, a tolerance that is not above 0.
    InfeasibleError
        No number of way-points will do.
    """
    depth = path.length - robot.length
    if depth < 1e-6:
        raise InputError("nothing has been steered yet: advance the nose before making a task of its path")
    tolerance = positive("tolerance", tolerance)
    failure, count = InfeasibleError("nothing was tried"), 0
    samples = path.point(np.linspace(robot.length, path.length, max(2, math.ceil(depth / _COMPARED))))
    for spacing in _SPACINGS:
        count = min(_MOST_WAY_POINTS, 1 + math.ceil(depth / (spacing * robot.link_lengths.max())))
        way_points = path.point(np.linspace(robot.length, path.length, count))
        try:
            result = _planned(_through(spec, way_points), robot)
        except InfeasibleError as error:
            failure = error
            continue
        deviation = float(result.path.distance_to(samples).max())
        if deviation <= tolerance:
            return SteeredTask(result.task.spec, result, deviation)
        words = f"its spline leaves the steered path by {1e3 * deviation:.3g} mm, at most {1e3 * tolerance:g} mm wished"
        failure = InfeasibleError(words, result)
    raise InfeasibleError(
        f"no spline through up to {count} way-points on the steered path makes a good plan. The last one: {failure}\n"
        "Retreat and steer more gently, or raise the tolerance.",
        failure.plan,
    )


def _through(spec: TaskSpec, way_points: Array) -> TaskSpec:
    path = PathSpec(way_points=tuple(tuple(point) for point in way_points.tolist()), detour=False)
    return spec.model_copy(update={"path": path})


def _planned(spec: TaskSpec, robot: Robot) -> Plan:
    """A good plan, slower than the task says if only speeds and accelerations are too high."""
    try:
        return plan_along(Task(spec, robot))
    except InfeasibleError as error:
        failed = [check for check in error.plan.checks if check.failed] if error.plan else []
        if not failed or not all(check.key in _MENDED for check in failed):
            raise
        slower = max((check.value / check.limit) ** (1 / _MENDED[check.key]) for check in failed)
    period = spec.motion.period_s * slower * _SLOWER
    motion = spec.motion.model_copy(update={"period_s": period})
    return plan_along(Task(spec.model_copy(update={"motion": motion}), robot))
