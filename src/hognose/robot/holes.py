"""Where cables pass the disks of the arm: positions of their holes, link by link."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.robot.robot import Robot

Array = NDArray[np.float64]


def link_frames(angles: Array, R_task_base: Array) -> Array:
    """Frames (n + 1, 3, 3) of the links at angles (n, 2) rad, columns x, y, z; the first is the base's (3, 3)."""
    out = np.empty((len(angles) + 1, 3, 3))
    out[0] = R_task_base
    for i, (alpha, beta) in enumerate(angles):
        ca, sa, cb, sb = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
        about_y = np.array([[ca, 0, sa], [0, 1, 0], [-sa, 0, ca]])
        about_x = np.array([[1, 0, 0], [0, cb, -sb], [0, sb, cb]])
        out[i + 1] = out[i] @ about_y @ about_x
    return out


def holes_of(robot: Robot, joints: Array, frames: Array, cable: int) -> Array:
    """Holes (2 s + 3, 3) m of one cable (0-based) of section s (0-based), up to the disk it is fixed to.

    Parameters
    ----------
    robot
    joints : (n+1, 3) m
    frames : (n+1, 3, 3)
        Of `link_frames`.
    cable
    """
    azimuth, section = robot.cable_azimuths[cable], robot.cable_sections[cable]
    off = robot.cable_circles[cable][:, None] * np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    along = np.array([0.0, 0.0, 1.0])
    out = []
    for i in range(section + 1):
        out.append(joints[i] + frames[i] @ (off[i] - robot.joint_before[i] * along))
        out.append(joints[i] + frames[i + 1] @ (off[i + 1] + robot.joint_after[i] * along))
    end = robot.pitches[section] - robot.disk_before_end[section]
    out.append(joints[section] + frames[section + 1] @ (off[section + 1] + end * along))
    return np.array(out)
