"""How much room an arm has where its way begins and where it ends, on any base."""

import numpy as np
import pytest

import hognose
from hognose.planning import Task, TaskSpec
from hognose.planning.room_at_ends import obstructed_start, room_at, room_needed, straight_way
from hognose.robot.base import straight_joints

ALONG = np.array([0.6, 0.0, 0.8])
ENTRANCE, TARGET = np.array([0.1, 0.2, 0.3]), np.array([0.3, 0.2, 0.6])


def task_of(kind: str, *centers: np.ndarray) -> Task:
    """An arm that enters along `ALONG`, and balls of 20 mm."""
    robot = hognose.load_robot("sjtu-25dof")
    base = {"kind": kind, "direction": ALONG.tolist()}
    if kind == "cart":
        base["position"] = (ENTRANCE - robot.length * ALONG).tolist()
    balls = [{"kind": "sphere", "center": center.tolist(), "diameter": 0.02} for center in centers]
    said = {"name": "t", "robot": "sjtu-25dof", "margin": 0.005, "base": base, "obstacle": balls}
    path = {"way_points": [ENTRANCE.tolist(), TARGET.tolist()]}
    return Task(TaskSpec.model_validate(said | {"path": path}), robot)


@pytest.mark.parametrize("kind", ["slider", "cart", "arm"])
@pytest.mark.parametrize("back", [0.1, 0.5])
def test_the_straight_arm_is_obstructed_by_what_is_closer_than_the_margin(kind, back):
    beside = np.array([0.0, 1.0, 0.0])
    radius = hognose.load_robot("sjtu-25dof").body_radii[0]
    for spare in (-0.002, 0.002):
        task = task_of(kind, ENTRANCE - back * ALONG + (radius + 0.01 + 0.005 + spare) * beside)
        found = obstructed_start(task)
        assert (found is not None) == (spare < 0)
        if found is not None:
            assert found.room == pytest.approx(0.005 + spare, abs=2e-4)
            assert (found.needed, found.obstacle) == (0.005, "sphere 1")
            assert np.linalg.norm(np.array(found.place) - (ENTRANCE - back * ALONG)) == pytest.approx(
                radius + 0.003, abs=1.5e-3
            )


@pytest.mark.parametrize("kind", ["slider", "cart", "arm"])
def test_the_mount_behind_the_arm_is_obstructed_too(kind):
    task = task_of(kind)
    mount = task.base.mount
    assert mount is not None
    middle = straight_joints(task.base, task.robot)[0, 0] - 0.5 * mount.length * ALONG
    found = obstructed_start(task_of(kind, middle))
    assert found is not None
    assert found.room < 0
    np.testing.assert_allclose(found.begin, middle - 0.5 * mount.length * ALONG, atol=1e-12)


def test_room_is_measured_to_the_nearest_surface_and_below_zero_inside():
    task = task_of("slider", TARGET)
    room, name = room_at(task, TARGET + np.array([0.0, 0.05, 0.0]))
    assert (room, name) == (pytest.approx(0.04, abs=2e-4), "sphere 1")
    assert room_at(task, TARGET)[0] == pytest.approx(-0.01, abs=2e-4)
    assert room_needed(task) == (pytest.approx(task.robot.body_radii[-1] + 0.005),) * 2
    assert straight_way(task) == pytest.approx(np.linalg.norm(TARGET - ENTRANCE))
