"""Plans that the twin is moved through, and arms of other makes."""

from dataclasses import fields, replace
from functools import cache
from typing import Any

import numpy as np

import hognose
from hognose.planning import Plan, Task, TaskSpec
from hognose.robot import Robot, RobotSpec


@cache
def boards() -> Plan:
    return hognose.plan(hognose.load_task("obstacle-array"))


def shortened(plan: Plan, last: int) -> Plan:
    """The same plan, which ends earlier."""
    found = {each.name: getattr(plan, each.name) for each in fields(Plan)}
    rows = {name: x for name, x in found.items() if isinstance(x, np.ndarray) and len(x) == len(plan.time)}
    return replace(plan, **{name: x[: last + 1] for name, x in rows.items()})


def robot_of(count: int, section: dict[str, Any] | None = None, cables: dict[str, Any] | None = None) -> Robot:
    """An arm of so many sections of the bundled one, otherwise with what is given."""
    spec = hognose.load_robot("sjtu-25dof").spec.model_dump(by_alias=True)
    spec["section"] = [spec["section"][0] | {"count": count} | (section or {})]
    spec["cables"] = dict(spec["cables"], **(cables or {}))
    return Robot.from_spec(RobotSpec.model_validate(spec))


def bent_plan(robot: Robot, length: float = 0.8, aside: float = 0.2) -> Plan:
    """An arm that slides into the open and bends to a side."""
    points = [[0, 0, 0], [0, 0, 0.25 * length], [0.4 * aside, 0.1 * aside, 0.6 * length], [aside, 0, length]]
    spec = TaskSpec.model_validate({"name": "bent", "robot": robot.name, "path": {"way_points": points}})
    return hognose.plan(Task(spec, robot))
