"""Searches made from bundled tasks, and an independent check of plans."""

from __future__ import annotations

from typing import Any

import coal as coal_module
import numpy as np

import hognose
from hognose.planning import Plan, Task, TaskSpec

coal: Any = coal_module  # it comes without types


def searched(name: str, margin: float | None = None, obstacles: tuple[dict[str, Any], ...] = (), **path: Any) -> Task:
    """A bundled task from its entrance and target alone, with other things in its path, and more obstacles."""
    given = hognose.load_task(name)
    data = given.spec.model_dump(mode="json", by_alias=True)
    entrance, *_, target = data["path"]["way_points"]
    data["path"] = {"entrance": entrance, "target": target, **path}
    data["obstacle"] = [*data["obstacle"], *obstacles]
    data["margin"] = given.margin if margin is None else margin
    return Task(TaskSpec.model_validate(data), given.robot)


def smallest_by_coal(plan: Plan, feed: float) -> float:
    """The smallest distance of any link's capsule to the obstacles, angles interpolated to steps of `feed` m."""
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(plan.scene.triangles), 3 * len(plan.scene.triangles))
    for triangle in plan.scene.triangles:
        model.addTriangle(*triangle)
    model.endModel()
    steps = int(np.ceil((plan.feed[-1] - plan.feed[0]) / feed)) + 1
    at = np.linspace(plan.feed[0], plan.feed[-1], steps)
    flat = plan.angles.reshape(len(plan.feed), -1)
    angles = np.stack([np.interp(at, plan.feed, column) for column in flat.T], axis=1)
    angles = angles.reshape(steps, plan.robot.sections, 2)
    body = plan.robot.joint_positions(angles, at) + plan.task.base.start
    request, best = coal.DistanceRequest(), np.inf
    for configuration in body:
        for i, radius in enumerate(plan.robot.body_radii):
            best = min(best, _distance(model, configuration[i], configuration[i + 1], float(radius), request))
    return best


def _distance(model: Any, start: np.ndarray, end: np.ndarray, radius: float, request: Any) -> float:
    along = end - start
    length = float(np.linalg.norm(along))
    z = along / length
    x = np.cross(np.eye(3)[int(np.argmin(np.abs(z)))], z)
    x /= np.linalg.norm(x)
    placed = coal.Transform3s(np.column_stack([x, np.cross(z, x), z]), 0.5 * (start + end))
    return coal.distance(
        model, coal.Transform3s(), coal.Capsule(radius, length), placed, request, coal.DistanceResult()
    )
