"""The certificate of feed and joint angles that go linearly from step to step."""

from __future__ import annotations

import math

import numpy as np

from hognose.planning.certificate.bound import Array, Certificate, Pieces, certify
from hognose.planning.certificate.moving import Moving
from hognose.robot import Robot
from hognose.robot.base import Base, centre_line
from hognose.scene import Scene


def certify_interpolated(
    robot: Robot,
    scene: Scene,
    base: Base,
    feeds: Array,
    angles: Array,
    vertices: Array,
    clearance: Array,
    horizon: float,
    margin: float = math.inf,
) -> Certificate:
    """The certificate of feeds (T,) and angles (T, n, 2) interpolated linearly between the steps.

    At these, the chords end at vertices (T, p+1, 3) m and the clearance of the sections is (T, n) m.
    Where only a tighter bound proves the margin (m), it is tightened so far.
    """
    moving = interpolated_motion(robot, base, feeds, angles)
    place, travel, parameters = moving.place, moving.travel, moving.parameters
    return certify(place, travel, scene, robot, parameters, vertices, clearance, horizon, margin)


def interpolated_motion(robot: Robot, base: Base, feeds: Array, angles: Array) -> Moving:
    """The motion of feeds (T,) m and angles (T, n, 2) rad that go linearly from set-point to set-point."""
    sections = robot.sections
    parameters = np.concatenate([feeds[:, None], angles.reshape(len(feeds), -1)], axis=1)

    def place(parameters: Array) -> tuple[Array, Array]:
        joints = robot.joint_positions(parameters[:, 1:].reshape(-1, sections, 2), parameters[:, 0])
        return parameters, centre_line(robot, base, base.placed(joints))

    def travel(pieces: Pieces) -> tuple[Array, Array]:
        low, high = (np.ascontiguousarray(side[:, 1:]).reshape(-1, sections, 2) for side in (pieces.low, pieces.high))
        bulge = robot.model.bulges(low, high, robot.link_lengths)
        return np.linalg.norm(pieces.high_body - pieces.low_body, axis=2), bulge

    return Moving(parameters, place, travel, straight=True)
