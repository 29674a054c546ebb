"""Hognose from Python: a robot, a path, a follower used step by step, and a verified plan.

Run it with `python examples/04_from_python.py`.
"""

from __future__ import annotations

import numpy as np

import hognose


def main() -> None:
    # An arm, and a path for it: the straight run of the slider, then a spline through way-points (m).
    robot = hognose.load_robot("sjtu-25dof")
    curve = hognose.Path.through([[0, 0, 0], [0.05, 0.03, 0.35], [-0.02, 0.06, 0.9]], start_direction=[0, 0, 1])
    path = curve.with_run(robot.length)
    print(f"path: {1e3 * path.length:.1f} mm, sharpest curve {1e3 / path.sharpest[0]:.0f} mm radius")

    # Online: one step at a time, as in a controller. The body follows the nose.
    follower = hognose.follower(path, robot.link_lengths)
    for feed in np.arange(0.0, 0.8, 0.2):
        joints = follower.step(feed)
        angles = robot.angles(joints)
        counts = robot.motor_counts(robot.cable_lengths(angles))
        print(
            f"feed {1e3 * feed:5.1f} mm: tip at {np.round(1e3 * joints[-1], 1)} mm, largest angle "
            f"{np.degrees(np.abs(angles).max()):4.1f} deg, motor 36 at {counts[-1]} counts"
        )

    # A whole task: planned, checked, with certified clearance between the steps.
    plan = hognose.plan(hognose.load_task("pipe-tank"))
    print(plan.summary())

    # The error states what fails, where and by how much.
    task = hognose.load_task("obstacle-array")
    greedy = hognose.Task(task.spec.model_copy(update={"margin": 0.018}), task.robot)
    try:
        hognose.plan(greedy)
    except hognose.InfeasibleError as error:
        print(error)


if __name__ == "__main__":
    main()
