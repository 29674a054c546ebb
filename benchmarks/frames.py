"""`python -m benchmarks.frames`: both cases in random frames, compared with the plans moved there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import hognose
from benchmarks.rows import aside, heading, row
from hognose.planning import Task
from hognose.scene import Scene

Array = NDArray[np.float64]

CASES = ("obstacle-array", "pipe-tank")
FRAMES = 20


def main() -> None:
    """Print how far plans in other frames are from the plans moved there."""
    heading(f"both cases in {FRAMES} random frames, up to a metre away, compared with the plans moved there")
    for name in CASES:
        task = hognose.load_task(name)
        plan = hognose.plan(task)
        away, counts, good = 0.0, 0, 0
        for seed in range(FRAMES):
            rotation, shift = _frame(seed)
            there = hognose.plan(in_frame(task, rotation, shift))
            away = max(away, float(np.abs(there.joints - (plan.joints @ rotation.T + shift)).max()))
            counts += int(np.count_nonzero(there.motor_counts != plan.motor_counts))
            good += there.good
        row(f"{name}: joints differ by", away, 1e-12, "m")
        row(f"{name}: motor counts that differ", counts, 0, "")
        aside(f"{name}: good plans", good, "")


def _frame(seed: int) -> tuple[Array, Array]:
    random = np.random.default_rng(seed)
    return Rotation.random(rng=random).as_matrix(), random.uniform(-1, 1, 3)


def in_frame(task: Task, rotation: Array, shift: Array) -> Task:
    """The task in another frame: turned by a rotation (3, 3), then shifted (3,) m."""
    path, whole = task.spec.path, task.scene
    way_points = (task.way_points @ rotation.T + shift).tolist()
    placed = {"way_points": tuple(map(tuple, way_points)), "entrance": tuple(way_points[0])}
    if path.tip_direction is not None:
        placed["tip_direction"] = tuple((rotation @ path.tip_direction).tolist())
    changes = {"path": path.model_copy(update=placed), "base": task.spec.base.as_it_stands(rotation)}
    meshes = [whole.triangles[whole.owner == k] @ rotation.T + shift for k in range(len(whole.names))]
    return Task(task.spec.model_copy(update=changes), task.robot).with_obstacles(Scene.from_meshes(whole.names, meshes))


if __name__ == "__main__":
    main()
