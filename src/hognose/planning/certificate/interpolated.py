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
    sections, count = robot.sections, at.shape[1]
    ends, extending = count + 2 * sections, robot.extends and lengths is not None
    parts = [at, angles.reshape(len(at), -1), *([lengths] if extending else [])]

    def parted(parameters: Array) -> tuple[Array, Array, Array | None]:
        """Coordinates of the base, angles and lengths; None of sections that keep theirs."""
        angles = np.ascontiguousarray(parameters[:, count:ends]).reshape(-1, sections, 2)
        return parameters[:, :count], angles, parameters[:, ends:] if extending else None

    def place(parameters: Array) -> tuple[Array, Array]:
        where, turned, long = parted(parameters)
        where = base.settled(where)
        parameters = np.concatenate([where, parameters[:, count:]], axis=1)
        return parameters, centre_line_on(base, robot, turned, where, long)

    def travel(pieces: Pieces) -> tuple[Array, Array]:
        (low_at, low, short), (high_at, high, long) = parted(pieces.low), parted(pieces.high)
        spin, swing = base.spin(low_at, high_at), base.swing(low_at, high_at)
        own = robot.link_lengths if short is None or long is None else np.stack([short, long])
        return pieces.gone, robot.model.bulges(low, high, own, spin, swing)

    return Moving(np.concatenate(parts, axis=1), place, travel, straight=True, on_base=count)
