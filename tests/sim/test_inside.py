"""An arm that begins inside an obstacle has no surface near it, and is stopped all the same."""

from dataclasses import replace

import numpy as np
import pytest
from twin_makers import boards, shortened

from hognose.planning import Plan, Task
from hognose.scene import Board, MovingObstacle, Scene
from hognose.scene.moving import parts_of
from hognose.scene.rigid_motion import RigidMotion
from hognose.sim import Changes, simulate

FAR, AT = np.array([0.0, 0.0, 50.0]), 3
ROCK = [Board(center=(0, 0, 0), size=(0.7, 0.7), thickness=3.0, name="rock")]


def among(scene: Scene, moving: tuple[MovingObstacle, ...] = ()) -> Plan:
    """The beginning of a good motion, in another space than it was planned for."""
    plan = shortened(boards(), AT)
    task = Task(plan.task.spec, plan.robot)
    task.__dict__.update(scene=scene, moving=moving)
    return replace(plan, task=task)


@pytest.mark.parametrize("kind", ["still", "shifted", "moving", "moving and shifted"])
def test_an_arm_wholly_inside_is_stopped_at_once(kind):
    away = kind.count("shifted") * FAR
    scene = Scene.from_obstacles(ROCK)
    apart = Scene.from_parts([])
    places = away + np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 9.0]])
    motion = RigidMotion(np.array([0.0, 9.0]), np.zeros(3), places, np.stack([np.eye(3)] * 2), np.zeros((1, 3)))
    if kind.startswith("moving"):
        plan = among(apart, (MovingObstacle("rock", scene, motion, 0.0),))
    else:
        plan = among(Scene.from_parts([replace(part, triangles=part.triangles + away) for part in parts_of(scene)]))
    changes = Changes(shifted={"rock": (0.0, 0.0, -50.0)} if away.any() else {})
    done = simulate(plan, changes)
    assert done.stopped == "start: link 1 is inside rock"
    assert (len(done.time), done.good) == (1, False)
    if away.any():  # where it was it is in nobody's way
        assert not simulate(plan).stopped
