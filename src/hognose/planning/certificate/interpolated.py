"""The certificate of feed and joint angles that go linearly from step to step."""

from __future__ import annotations

import math

import numpy as np

from hognose.planning.certificate.bound import Array, Certificate, Pieces, certify
from hognose.robot import Robot
from hognose.robot.base import Base
from hognose.scene import Scene


def certify_interpolated(
    robot: Robot,
    scene: Scene,
    base: Base,
    feeds: Array,
    angles: Array,
    body: Array,
    clearance: Array,
    horizon: float,
    margin: float = math.inf,
) -> Certificate:
    """The certificate of feed and joint angles interpolated linearly between the steps.

    Where only a tighter bound proves the margin (m), it is tightened so far.
    """
    sections = robot.sections
    parameters = np.concatenate([feeds[:, None], angles.reshape(len(feeds), -1)], axis=1)

    def place(parameters: Array) -> tuple[Array, Array]:
        joints = robot.joint_positions(parameters[:, 1:].reshape(-1, sections, 2), parameters[:, 0])
        return parameters, robot.model.vertices(base.placed(joints))

    def travel(pieces: Pieces) -> tuple[Array, Array]:
        low, high = (np.ascontiguousarray(side[:, 1:]).reshape(-1, sections, 2) for side in (pieces.low, pieces.high))
        bulge = robot.model.bulges(low, high, robot.link_lengths)
        return np.linalg.norm(pieces.high_body - pieces.low_body, axis=2), bulge

    return certify(place, travel, scene, robot, parameters, robot.model.vertices(body), clearance, horizon, margin)
