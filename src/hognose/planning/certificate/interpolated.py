"""The motion of feed and joint angles that go linearly from step to step."""

from __future__ import annotations

import numpy as np

from hognose.planning.certificate.moving import Array, Moving, Pieces
from hognose.robot import Robot
from hognose.robot.base import Base, centre_line_on


def interpolated_motion(robot: Robot, base: Base, at: Array, angles: Array) -> Moving:
    """The motion of a base (T, k) and angles (T, n, 2) rad that are interpolated from set-point to set-point."""
    sections = robot.sections
    count = at.shape[1]
    parameters = np.concatenate([at, angles.reshape(len(at), -1)], axis=1)

    def parted(parameters: Array) -> tuple[Array, Array]:
        """Coordinates of the base and angles."""
        return parameters[:, :count], np.ascontiguousarray(parameters[:, count:]).reshape(-1, sections, 2)

    def place(parameters: Array) -> tuple[Array, Array]:
        where, turned = parted(parameters)
        where = base.settled(where)
        parameters = np.concatenate([where, parameters[:, count:]], axis=1)
        return parameters, centre_line_on(base, robot, turned, where)

    def travel(pieces: Pieces) -> tuple[Array, Array]:
        (low_at, low), (high_at, high) = parted(pieces.low), parted(pieces.high)
        spin, swing = base.spin(low_at, high_at), base.swing(low_at, high_at)
        bulge = robot.model.bulges(low, high, robot.link_lengths, spin, swing)
        return pieces.gone, bulge

    return Moving(parameters, place, travel, straight=True, on_base=count)
