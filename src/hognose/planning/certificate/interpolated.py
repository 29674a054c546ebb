"""The motion of feed, joint angles and section lengths that go linearly from step to step."""

from __future__ import annotations

import numpy as np

from hognose.planning.certificate.moving import Array, Moving, Pieces
from hognose.robot import Robot
from hognose.robot.base import Base, centre_line_on


def interpolated_motion(robot: Robot, base: Base, at: Array, angles: Array, lengths: Array | None = None) -> Moving:
    """The motion of a base (T, k) and angles (T, n, 2) rad that are interpolated from set-point to set-point.

    With lengths (T, n) m of sections that extend, these are, too.
    """
    if robot.extends and lengths is not None:
        return _extending_motion(robot, base, at, angles, lengths)
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


def _extending_motion(robot: Robot, base: Base, at: Array, angles: Array, lengths: Array) -> Moving:
    """As `interpolated_motion`; parameters are those of the base, the angles, and the lengths."""
    sections, count = robot.sections, at.shape[1]
    ends = count + 2 * sections
    parameters = np.concatenate([at, angles.reshape(len(at), -1), lengths], axis=1)

    def parted(parameters: Array) -> tuple[Array, Array, Array]:
        angles = np.ascontiguousarray(parameters[:, count:ends]).reshape(-1, sections, 2)
        return parameters[:, :count], angles, parameters[:, ends:]

    def place(parameters: Array) -> tuple[Array, Array]:
        where, turned, long = parted(parameters)
        where = base.settled(where)
        parameters = np.concatenate([where, parameters[:, count:]], axis=1)
        return parameters, centre_line_on(base, robot, turned, where, long)

    def travel(pieces: Pieces) -> tuple[Array, Array]:
        (low_at, low, short), (high_at, high, long) = parted(pieces.low), parted(pieces.high)
        spin, swing = base.spin(low_at, high_at), base.swing(low_at, high_at)
        bulge = robot.model.bulges(low, high, np.stack([short, long]), spin, swing)
        return pieces.gone, bulge

    return Moving(parameters, place, travel, straight=True, on_base=count)
