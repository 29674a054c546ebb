"""The certificate of feed and cable lengths that go linearly from step to step, as drives move them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hognose.planning.certificate.bound import Certificate, certify
from hognose.planning.certificate.cable_motion import deviations
from hognose.planning.certificate.extending import UndeterminedError, extending_motion, knows_cables
from hognose.planning.certificate.interpolated import interpolated_motion
from hognose.planning.certificate.moving import Array, Moving, Pieces
from hognose.planning.tolerance.allowance import Allowance
from hognose.robot import Robot
from hognose.robot.base import Base, centre_line_on
from hognose.robot.sections import RIGID_LINK, MixedSections
from hognose.scene import Scene

#: Where linear angles are left by no more than this (m) in a whole step, twice that is taken off for its parts, too.
_CLOSE = 5e-6
#: A piece in which no joint turns farther than this (rad) is not halved for want of a bound: there will be none.
_SMALL = 1e-3
#: What is taken off (m) where no deviation is proven: more than any clearance.
_UNPROVEN = 1e6
#: A bend (rad) of which nothing is proven: more than clears any pair of links.
_UNBOUNDED = 1e3


def judges_cables(robot: Robot) -> bool:
    """Whether this motion is known for the robot: for rigid links, and for sections of the kinds that there are.

    Of sections that extend, only if all do.
    """
    if robot.extends:
        return knows_cables(robot)
    return robot.model is RIGID_LINK or isinstance(robot.model, MixedSections)


def _is_linear(robot: Robot) -> bool:
    return isinstance(robot.model, MixedSections) and robot.model.linear_cables


def certify_cables(
    moving: Moving,
    robot: Robot,
    scene: Scene,
    vertices: Array,
    clearance: Array,
    horizon: float,
    margin: float = math.inf,
    allowance: Allowance | None = None,
) -> Certificate | None:
    """The certificate of a base and cable lengths interpolated between the steps, as `cables_motion` makes it.

    At these, the chords end at vertices (T, p+1, 3) m, and the clearance of the sections is at least (T, n) m. Where
    only a tighter bound proves the margin (m), it is tightened so far. None where nothing is proven: the cables do not
    determine the joints everywhere.
    """
    try:
        proof = certify(moving, robot, scene, vertices, clearance, horizon, margin, allowance)
    except UndeterminedError:
        return None
    return None if proof.clearance < -0.5 * _UNPROVEN else proof


def cables_motion(
    robot: Robot, base: Base, at: Array, angles: Array, lengths: Array, sections: Array | None = None
) -> Moving:
    """The motion of a base (T, k) and cable lengths (T, c) m that are interpolated; angles (T, n, 2) as of these.

    Sections that extend have lengths (T, n) m.

    Raises
    ------
    UndeterminedError
        Here, or where it is asked for places between the set-points.
    """
    if robot.extends and sections is not None:
        return extending_motion(robot, base, at, angles, sections, lengths)
    if _is_linear(robot):  # the angles that the lengths define go linearly, too
        return interpolated_motion(robot, base, at, angles)
    parameters = np.concatenate([at, angles.reshape(len(at), -1), lengths], axis=1)
    found = _deviations(robot, angles[:-1], angles[1:], lengths[:-1], lengths[1:])
    made = _Motion(robot, base, at.shape[1], _carried(robot, found))
    slack = np.minimum(found, _UNBOUNDED)
    return Moving(parameters, made.place, made.travel, straight=True, on_base=at.shape[1], bend_slack=slack)


@dataclass(frozen=True)
class _Motion:
    """What `certify` asks: parameters are those of the base, the angles and the cable lengths.

    Attributes
    ----------
    robot
    base
    count
        Coordinates of the base.
    off : (T-1, p+1) m
        How far ends of chords leave linear angles from each step to the next.
    """

    robot: Robot
    base: Base
    count: int
    off: Array

    def place(self, parameters: Array) -> tuple[Array, Array]:
        at, near, lengths = self._parts(parameters)
        at = self.base.settled(at)
        angles = self.robot.angles_from_cables(lengths, near)
        if not np.isfinite(angles).all():
            raise UndeterminedError
        found = np.concatenate([at, angles.reshape(len(at), -1), lengths], axis=1)
        return found, centre_line_on(self.base, self.robot, angles, at)

    def travel(self, pieces: Pieces) -> tuple[Array, Array]:
        robot = self.robot
        low_at, low, low_lengths = self._parts(pieces.low)
        high_at, high, high_lengths = self._parts(pieces.high)
        off = self.off[pieces.step]
        if not np.array_equal(pieces.step, np.arange(len(self.off))):
            # Both the motion and the straight line between two places of it keep to the step's linear angles.
            off *= 2.0
            far = off[:, -1] > 2.0 * _CLOSE
            if far.any():
                parts = (low[far], high[far], low_lengths[far], high_lengths[far])
                off[far] = _carried(robot, _deviations(robot, *parts))
        spin, swing = self.base.spin(low_at, high_at), self.base.swing(low_at, high_at)
        beside = robot.model.bulges(low, high, robot.link_lengths, spin, swing) + off
        return pieces.gone, beside

    def _parts(self, parameters: Array) -> tuple[Array, Array, Array]:
        """Coordinates of the base (m, k), angles (m, n, 2) and cable lengths (m, c) of parameters."""
        ends = self.count + 2 * self.robot.sections
        angles = np.ascontiguousarray(parameters[:, self.count : ends]).reshape(-1, self.robot.sections, 2)
        return parameters[:, : self.count], angles, np.ascontiguousarray(parameters[:, ends:])


def _deviations(robot: Robot, low: Array, high: Array, low_lengths: Array, high_lengths: Array) -> Array:
    """See `deviations`; halving what is not known there would end nowhere if it is small already."""
    found = deviations(robot, low, high, low_lengths, high_lengths)
    unknown = np.isinf(found[:, 0])
    if unknown.any() and np.abs(high - low)[unknown].max(axis=(1, 2)).min() < _SMALL:
        raise UndeterminedError
    return found


def _carried(robot: Robot, found: Array) -> Array:
    """How far (m, p+1) m ends of chords leave linear angles, of how far (m, n) rad the angles do."""
    if isinstance(robot.model, MixedSections):
        return np.minimum(found, _UNPROVEN) @ robot.model.levers.T
    turned = np.cumsum(found, axis=1)
    out = np.zeros((len(found), robot.sections + 1))
    np.minimum(np.cumsum(turned * robot.link_lengths, axis=1), _UNPROVEN, out=out[:, 1:])
    return out
