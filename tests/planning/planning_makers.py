"""Variations of tasks, robots and plans, and random arms and spaces."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import numpy as np
from scipy.spatial.transform import Rotation

from hognose.cached import cached_property
from hognose.errors import HognoseError
from hognose.planning import Plan, Task
from hognose.planning.checks import ALL, Check
from hognose.planning.plan_table import all_cells, digest_of
from hognose.robot import Robot, RobotSpec
from hognose.robot.base import Base, Slider
from hognose.scene import Box, Cylinder, Scene, Sphere
from hognose.units import FileModel

Model = TypeVar("Model", bound=FileModel)
Answer = TypeVar("Answer")

#: Keys of our checks of an insertion along a spline, in the order they are made. More may be added to `ALL`.
CHECKS = (
    "bend_limits",
    "link_lengths",
    "joints_on_path",
    "joints_agree_with_following",
    "tip_error",
    "tip_on_target",
    "path_through_way_points",
    "starts_straight",
    "set_points_a_step_apart",
    "set_points_a_period_apart",
    "joint_speed",
    "joint_acceleration",
    "feed_speed",
    "slider_travel",
    "cables_agree_with_angles",
    "cable_travel",
    "cable_speed",
    "motor_counts_agree_with_cables",
    "motor_counts",
    "rounding_to_counts",
    "clearance_agrees_with_angles",
    "clearance_at_steps",
    "certified_along_path",
    "certified_interpolated",
    "certified_cables",
    "clearance_of_mount",
    "own_body",
)


def ours(checks: Iterable[Check]) -> tuple[str, ...]:
    """The keys of verdicts that are among those above; all are of criteria of `ALL`, once each and in its order."""
    keys = [check.key for check in checks]
    assert keys == [each.key for each in ALL if each.key in keys]
    return tuple(key for key in keys if key in CHECKS)


def altered(model: Model, changes: dict[str, Any]) -> Model:
    """The model with other values at dotted keys, validated anew."""
    data = model.model_dump(mode="json", by_alias=True)
    for dotted, value in changes.items():
        *way, last = (int(key) if key.isdigit() else key for key in dotted.split("."))
        place: Any = data
        for key in way:
            place = place[key]
        place[last] = value
    return type(model).model_validate(data)


def variant(task: Task, spec: dict[str, Any] | None = None, robot: dict[str, Any] | None = None) -> Task:
    """The task with other values in its file and in its robot's file (SI)."""
    arm = Robot.from_spec(altered(task.robot.spec, robot)) if robot else task.robot
    return Task(altered(task.spec, spec or {}), arm)


def moved(task: Task, seed: int) -> tuple[Task, Callable[[np.ndarray], np.ndarray]]:
    """The same task in another frame, and how points of the old one are put into it."""
    rng = np.random.default_rng(seed)
    rotation, shift = Rotation.random(rng=rng).as_matrix(), rng.normal(size=3)

    def put(points: np.ndarray) -> np.ndarray:
        return points @ rotation.T + shift

    class Moved(Task):
        @property
        def way_points(self) -> np.ndarray:
            return put(task.way_points)

        @cached_property
        def scene(self) -> Scene:
            whole = task.scene
            meshes = [put(whole.triangles[whole.owner == k]) for k in range(len(whole.names))]
            return Scene.from_meshes(whole.names, meshes)

        @cached_property
        def base(self) -> Base:
            return Slider.before(self.way_points[0], self.robot, rotation)

    pointing = task.spec.path.tip_direction
    changes: dict[str, Any] = {"gravity_m_s2": (rotation @ np.array(task.spec.gravity_m_s2)).tolist()}
    if pointing is not None:
        changes["path.tip_direction"] = (rotation @ np.array(pointing)).tolist()
    return Moved(altered(task.spec, changes), task.robot), put


def retasked(plan: Plan, spec: dict[str, Any] | None = None, robot: dict[str, Any] | None = None) -> Plan:
    """The same motion, to be judged by another task or robot."""
    return dataclasses.replace(plan, task=variant(plan.task, spec, robot), checks=())


def with_cell(plan: Plan, column: str, cell: tuple[int, ...], change: float) -> Plan:
    """The plan with one number of one column changed."""
    values = getattr(plan, column).copy()
    values[cell] += change
    return dataclasses.replace(plan, **{column: values})


def assert_same_cells(one: Plan, other: Plan) -> None:
    """Every column, bit for bit."""
    cells, others = all_cells(one), all_cells(other)
    assert list(cells) == list(others)
    assert all(digest_of(cells[name]) == digest_of(others[name]) for name in cells)


def outcome(action: Callable[[], Answer]) -> Answer | HognoseError:
    """What an action returns, or the error of ours that it raises; any other escapes."""
    try:
        return action()
    except HognoseError as error:
        return error


def failed(checks: Any) -> set[str]:
    return {check.key for check in checks if check.failed}


def random_robot(rng: np.random.Generator, sections: int) -> Robot:
    """An arm of links of different length and width."""
    groups, narrowest = [], 1.0
    for _ in range(sections):
        pitch, width = rng.uniform(0.05, 0.15), rng.uniform(0.01, 0.05)
        narrowest = min(narrowest, width)  # cables run through all sections before their own
        groups.append(
            {
                "pitch": pitch,
                "half_lengths": [0.1 * pitch, 0.1 * pitch],
                "body_diameter": width,
                "bend_limit_deg": 80.0,
                "link_mass": 0.1,
                "cable_radius": 0.4 * narrowest,
                "cable_azimuths_deg": [0.0, 120.0, 240.0],
                "transmission": {"screw_lead": 0.004, "gear_ratio": 5.0, "counts_per_turn": 2000},
            }
        )
    return Robot.from_spec(
        RobotSpec.model_validate(
            {
                "name": "random",
                "feed": {"min": 0.0, "max": 1.0, "speed": 0.05},
                "limits": {
                    "joint_speed_deg_s": 10.0,
                    "joint_acceleration_deg_s2": 100.0,
                    "cable_speed": 0.05,
                    "cable_travel": [-0.2, 0.2],
                },
                "section": groups,
            }
        )
    )


def random_scene(rng: np.random.Generator, low: np.ndarray, high: np.ndarray, count: int = 5) -> Scene:
    """Balls, boxes and needles strewn between two corners."""
    items: list[Sphere | Box | Cylinder] = []
    for k in range(count):
        place = tuple(rng.uniform(low, high))
        turn = tuple(rng.uniform(-180, 180, 3))
        if k % 3 == 0:
            items.append(Sphere(center=place, diameter=rng.uniform(0.002, 0.05)))
        elif k % 3 == 1:
            items.append(Box(center=place, size=(0.2, 0.2, rng.uniform(1e-4, 0.01)), rotation_deg=turn))
        else:
            end = tuple(np.add(place, rng.normal(size=3) * 0.2))
            items.append(Cylinder(start=place, end=end, diameter=rng.uniform(1e-4, 0.01)))
    return Scene.from_obstacles(items, tolerance=1e-3)


def rod(x: float, y: float, z: float, diameter: float) -> Cylinder:
    """A thin cylinder along the y axis, 0.2 m to either side of a point."""
    return Cylinder(start=(x, y - 0.2, z), end=(x, y + 0.2, z), diameter=diameter)


def clearances(scene: Scene, robot: Robot, body: np.ndarray, horizon: float = np.inf) -> np.ndarray:
    """Clearance (T, n) m at every configuration (T, n+1, 3)."""
    return scene.clearance(body[:, :-1], body[:, 1:], robot.body_radii, horizon).value


def between(values: np.ndarray, pieces: int) -> np.ndarray:
    """Values (T, ...) with `pieces` linear sub-steps in each interval."""
    parts = [low + (high - low) * k / pieces for low, high in itertools.pairwise(values) for k in range(pieces)]
    return np.array([*parts, values[-1]])
