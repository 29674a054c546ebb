"""Tasks on every kind of base, edited, written to a file and read again: they are planned as before."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import hognose
from hognose.files.task_toml import ROUNDED, revised
from hognose.planning import Plan, Task, TaskSpec
from hognose.planning.planner import plan_along
from hognose.robot.base import SAME_PLACE
from hognose.viewer.model import edits

ARM = hognose.load_robot("sjtu-25dof")
#: Nothing here has a short decimal fraction, so that every coordinate is rounded when it is written.
AXES, ENTRANCE = (
    np.linalg.qr(np.array([[0.9, 0.1, 0.3], [-0.2, 1.1, 0.5], [0.4, 0.3, 1.2]]))[0],
    np.array([1, 2, 3]) / 7,
)
AXES = AXES * np.sign(np.linalg.det(AXES))
ALONG = AXES[:, 2]
START = ENTRANCE - ARM.length * ALONG
CORNERS = np.sort([START, START + 9 * np.sign(ALONG)], axis=0)
BASES = {
    "slider": {"kind": "slider"},
    "cart at the entrance": {"kind": "cart", "position": START},
    "cart before the entrance": {"kind": "cart", "position": START - 0.1 / 3 * ALONG},
    "drum": {"kind": "drum", "radius": 0.85 / 3, "nozzle": 0.25 / 3},
    "carrier": {"kind": "arm", "speed": 0.1 / 3},
    "carrier from its wall": {
        "kind": "arm",
        "workspace": dict(zip(("low", "high"), CORNERS, strict=True)),
    },
}


def at(*local: float) -> tuple[float, float, float]:
    """A place in the frame of the entrance."""
    x, y, z = (ENTRANCE + AXES @ np.array(local)).tolist()
    return x, y, z


def searched(base: str) -> Task:
    spec = {
        "name": "saved",
        "robot": "sjtu-25dof",
        "base": {"direction": ALONG} | BASES[base],
        "path": {"entrance": at(0, 0, 0), "target": at(0.03, 0.04, 0.4), "via": (at(0.02, 0.01, 0.2),)},
        "motion": {"step": 0.02, "period_s": 2.0},
        "obstacle": [{"kind": "sphere", "name": "ball", "center": at(0.1, 0, 0.2), "diameter": 0.05}],
    }
    return Task(TaskSpec.model_validate(spec), ARM)


def found(task: Task) -> Plan:
    """As a search finds it, with a way-point of its own."""
    return plan_along(task, way_points=np.insert(task.way_points, -1, at(0.026, 0.02, 0.3), axis=0))


def taken(plan: Plan) -> TaskSpec:
    return edits.validated(edits.take_route_of(plan)(plan.task.spec), "taken")


def longer(plan: Plan) -> TaskSpec:
    return edits.validated(edits.add_way_point(0)(taken(plan)), "longer")


@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("edit", [taken, longer])
@pytest.mark.parametrize("unit", ["mm", "m"])
def test_a_saved_task_is_planned_as_it_was(base: str, edit: Callable[[Plan], TaskSpec], unit: str, tmp_path: Path):
    before = Task(edit(found(searched(base))), ARM)
    file = tmp_path / "saved.toml"
    file.write_text(revised(f'name = ""\nunits = "{unit}"\n', before.spec))
    read = hognose.load_task(file)
    one, other = plan_along(before), plan_along(read)
    assert one.good
    assert [(check.key, check.failed) for check in other.checks] == [(check.key, check.failed) for check in one.checks]
    assert other.way_points.shape == one.way_points.shape
    np.testing.assert_allclose(other.way_points, one.way_points, rtol=0, atol=ROUNDED)
    assert other.joints.shape == one.joints.shape
    np.testing.assert_allclose(other.joints, one.joints, rtol=0, atol=20 * ROUNDED)


@pytest.mark.parametrize("base", BASES)
def test_a_route_that_is_taken_has_the_entrance_first_and_is_the_same_way(base: str):
    plan = found(searched(base))
    spec = taken(plan)
    assert spec.path.way_points[0] == plan.task.spec.path.entrance
    assert len(spec.path.way_points) == 4
    np.testing.assert_array_equal(Task(spec, ARM).way_points, plan.way_points)


@pytest.mark.parametrize("edge", [0.999, 1.001])
@pytest.mark.parametrize("axis", range(3))
def test_a_nose_that_rounding_moved_is_still_at_the_entrance(edge: float, axis: int):
    """What rounding takes of a place is less than what two places may be apart to be one."""
    assert np.sqrt(3) / 2 * ROUNDED < SAME_PLACE
    task = searched("cart at the entrance")
    moved = tuple((np.array(task.spec.base.position) + edge * SAME_PLACE * np.eye(3)[axis]).tolist())
    base = task.spec.base.model_copy(update={"position": moved})
    nose = Task(task.spec.model_copy(update={"base": base}), ARM).nose
    assert (nose is None) == (edge < 1)
