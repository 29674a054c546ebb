"""The first plan on a machine: what its later stages need is compiled in a second process, beside the first stages.

numba compiles one function at a time in a process. Both processes keep what they compile in one folder, where the
other one finds it.
"""

from __future__ import annotations

import subprocess
import sys
import threading
from contextlib import suppress

import numpy as np

from hognose.files import load_robot
from hognose.following import follower
from hognose.kernels import on_first_compilation
from hognose.mechanics import Mechanics
from hognose.path import Path
from hognose.planning.certificate import (
    cables_motion,
    certify,
    certify_cables,
    certify_own_body,
    interpolated_motion,
)
from hognose.robot import Robot
from hognose.robot.base import Slider
from hognose.scene import Scene
from hognose.scene.shapes.obstacles import Box


def compile_ahead(robot: Robot) -> None:
    """Run once, on next to nothing, what a plan runs from its end to its beginning."""
    still, feeds = np.zeros((2, robot.sections, 2)), np.zeros(2)
    body = robot.joint_positions(still, feeds)
    lengths = robot.cable_lengths(robot.angles(body))
    robot.motor_counts(lengths)
    scene = Scene.from_obstacles([Box(center=(1.0, 0.0, 0.0), size=(0.1, 0.1, 0.1))])
    scene.inside(body[0])
    clearance = scene.clearance(body[:, :-1], body[:, 1:], robot.body_radii, 0.05).value
    base, at, found = Slider.before(np.zeros(3), robot), feeds[:, None], (body, clearance, 0.05, 0.005)
    linear = interpolated_motion(robot, base, at, still)
    certify(linear, robot, scene, *found)
    drives = cables_motion(robot, base, at, robot.angles_from_cables(lengths, still), lengths)
    certify_cables(drives, robot, scene, *found)
    certify_own_body(linear, robot, body, base=base)
    Mechanics.of(robot).hold(still, (0.0, 0.0, 0.0))
    path = Path.through([[0.0, 0.0, 0.0], [0.0, 0.0, 2.0 * robot.length]], start_direction=[0.0, 0.0, 1.0])
    follower(path, robot.link_lengths).run([0.0, 1e-3])
    path.distance_to(body[0])


def when_needed() -> None:
    """Begin the second process if and when this one has to compile something."""
    on_first_compilation(_begin)


def _begin() -> None:
    # A thread that waits for the process: else it would stay as a zombie until this one ends.
    threading.Thread(target=_in_a_process, name="compile ahead", daemon=True).start()


def _in_a_process() -> None:
    with suppress(OSError):  # this process compiles all of it then
        subprocess.run(
            # -P: a file of the user's that is called like a module is not run in its stead.
            [sys.executable, "-P", "-m", "hognose.cli.compile_ahead"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            check=False,
        )


if __name__ == "__main__":
    compile_ahead(load_robot("sjtu-25dof"))
