"""How far the tip moves, to first order, if the arm is not as it is thought to be.

With the motors held, a change dr of the joint torques moves the angles by dq = -K⁻¹ dr, K the tangent stiffness:

    zero of a cable off by δ       dr = -Jᵀ k δ
    all masses larger by a share s dr = s dU/dq
    friction μ                     dr_j = Σ J_kj (T_kj - T_k)

A larger EA does the opposite of larger masses: there Jᵀ T = -dU/dq grows by the share, U with the energy of bending
where sections bend back. Friction is that of a rope on a drum: a cable that is pulled in past bends of altogether Θ
has lost the share 1 - exp(-μΘ) of its tension behind them, one that is paid out has gained as much. The motors hold
the length, so the mean of the tension over a cable stays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.mechanics.gravity import gravity_of
from hognose.mechanics.mechanics import Mechanics
from hognose.mechanics.pieces import MASS
from hognose.mechanics.postures import times_of
from hognose.mechanics.states import Held
from hognose.robot import Robot
from hognose.robot.kinematics import axes_of_joints
from hognose.robot.sections import MixedSections

Array = NDArray[np.float64]

#: The error of a cable's zero (m), and the share of stiffness and masses, that are looked at.
ZERO, SHARE = 1e-4, 0.1
#: Coefficient of friction of steel on plastic or bronze, where a robot file gives none.
ASSUMED_FRICTION = 0.1
#: Entries of the largest matrices that are made at a time.
_LARGEST_PART = 1_000_000


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """How far (T,) m the tip moves at every step.

    Attributes
    ----------
    zero
        For errors of the zeros of all cables that are independent, with a standard deviation of `ZERO`: that of the
        tip, over all directions.
    share
        For masses that are larger by `SHARE`, or an EA that is smaller by it: the worse of both.
    friction
        With friction that holds cables back on their way.
    """

    zero: Array
    share: Array
    friction: Array


def sensitivity(mechanics: Mechanics, angles: Array, held: Held, gravity: Array, ways: Array) -> Sensitivity:
    """How sensitive the tip is, to first order; NaN where the arm buckles.

    Parameters
    ----------
    mechanics
    angles : (T, n, 2) rad
    held
        Of these angles.
    gravity : (T, 3) m/s²
        In the arm's own axes.
    ways : (T, c)
        How cables move: above 0 they are paid out, below they are pulled in, at 0 they stand still.
    """
    elastic, geometric = mechanics.stiffness(angles, held.tensions, gravity)
    J = mechanics.cable_jacobian(angles)
    weight = mechanics.gravity_torque(angles, gravity)
    sound = held.load_factor > 1.0
    K = np.where(sound[:, None, None], elastic + geometric, np.eye(elastic.shape[1]))
    moves = np.where(sound[:, None, None], tip_jacobian(mechanics, angles) @ np.linalg.inv(K), np.nan)
    zeros = moves @ np.swapaxes(J * held.spring_constants[..., None], 1, 2)
    lost = _lost(mechanics, angles, held.tensions, mechanics.friction or ASSUMED_FRICTION)
    rubbed = np.einsum("tka,tka->ta", J, np.repeat(lost * -np.sign(ways)[..., None], 2, axis=2))
    share = _size(moves, weight)
    if mechanics.springs.any():
        share = np.maximum(share, _size(moves, mechanics.torque(angles, gravity)))
    return Sensitivity(
        ZERO * np.sqrt((zeros**2).sum(axis=(1, 2))),
        SHARE * share,
        _size(moves, rubbed),
    )


def turned_by(mechanics: Mechanics, angles: Array, held: Held, gravity: Array, friction: float = 0.0) -> Array:
    """How joints turn (T, n, 2, 1) rad if all masses are larger by a share of 1, or, without bending, EA smaller by it.

    With friction (T, n, 2, 1 + c), besides: by that of each cable that is pulled in; paid out, it does the opposite. To
    first order, and zero where the arm buckles. Arguments as of `sensitivity`.
    """
    count, size = len(angles), 2 * mechanics.robot.sections
    out = np.zeros((count, size, 1 + (mechanics.robot.cables if friction else 0)))
    part = max(1, _LARGEST_PART // size**2)
    for start in range(0, count, part):
        rows = slice(start, start + part)
        sound = np.flatnonzero(held.load_factor[rows] > 1.0) + start
        poses, pulls, weight = angles[sound], held.tensions[sound], gravity[sound]
        torques = mechanics.gravity_torque(poses, weight)[..., None]
        if friction:
            J = np.swapaxes(mechanics.cable_jacobian(poses), 1, 2)
            lost = np.swapaxes(_lost(mechanics, poses, pulls, friction), 1, 2)
            torques = np.concatenate([torques, J * np.repeat(lost, 2, axis=1)], axis=2)
        elastic, geometric = mechanics.stiffness(poses, pulls, weight)
        out[sound] = -np.linalg.solve(elastic + geometric, torques)
    return out.reshape(count, size // 2, 2, -1)


def tip_jacobian(mechanics: Mechanics, angles: Array) -> Array:
    """Derivatives (T, 3, 2n) m/rad of the tip's place by the angles, in the arm's own axes."""
    if isinstance(mechanics.robot.model, MixedSections):  # a mass of 1 kg at the tip has the energy -g·p
        pieces = mechanics.pieces.copy()
        pieces[:, MASS] = 0.0
        along = [np.tile(axis, (len(angles), 1)) for axis in np.eye(3)]
        return np.stack([-gravity_of(angles, pieces, 1.0, each)[0] for each in along], axis=1)
    joints = mechanics.robot.joint_positions(angles)
    turned = np.cross(axes_of_joints(angles), (joints[:, -1:] - joints[:, :-1])[:, :, None])  # (T, n, 2, 3)
    return np.swapaxes(turned.reshape(len(angles), -1, 3), 1, 2)


def _size(moves: Array, torques: Array) -> Array:
    return np.linalg.norm(np.einsum("txa,ta->tx", moves, torques), axis=1)


def lost_by_friction(mechanics: Mechanics, angles: Array, friction: float) -> tuple[Array, Array]:
    """By what shares (T, c) of its mean the tension of a cable differs at most at its motor, and along it."""
    at, mean = _along(mechanics, angles, friction)
    beyond = np.maximum.accumulate(np.abs(at[:, None, :] / mean[:, :, None] - 1.0), axis=2)
    sections = mechanics.robot.cable_sections
    return 1.0 / mean - 1.0, np.take_along_axis(beyond, np.broadcast_to(sections[:, None], (*mean.shape, 1)), 2)[..., 0]


def _lost(mechanics: Mechanics, angles: Array, tensions: Array, friction: float) -> Array:
    """By what (T, c, n) N the tension of each cable that is pulled in is above its mean at each joint."""
    at, mean = _along(mechanics, angles, friction)
    return tensions[:, :, None] * (at[:, None, :] - mean[:, :, None])


def _along(mechanics: Mechanics, angles: Array, friction: float) -> tuple[Array, Array]:
    """The tension of a cable that comes in, 1 at its motor: at every joint (T, n), and the mean over it (T, c)."""
    robot = mechanics.robot
    bends = bends_of_cables(robot, angles)
    after, pitches = np.cumsum(bends, axis=1), robot.pitches * times_of(angles)
    at, along = np.exp(-friction * (after - 0.5 * bends)), np.exp(-friction * after)
    whole = mechanics.free_length + np.cumsum(pitches, axis=1)
    mean = (mechanics.free_length + np.cumsum(along * pitches, axis=1)) / whole
    return at, mean[:, robot.cable_sections]


def bends_of_cables(robot: Robot, angles: Array) -> Array:
    """By how much (T, n) rad a cable bends on its way through each section."""
    if not isinstance(robot.model, MixedSections):
        return np.arccos(np.clip(np.cos(angles[..., 0]) * np.cos(angles[..., 1]), -1.0, 1.0))
    model = robot.model
    alpha, beta, _, curved = model.table.T
    own = np.repeat(angles, np.diff(model.first), axis=1)
    a, b = alpha * own[..., 0], beta * own[..., 1]
    joint = np.arccos(np.clip(np.cos(a) * np.cos(b), -1.0, 1.0))
    return np.add.reduceat(np.where(curved == 1.0, np.hypot(a, b), joint), model.first[:-1], axis=1)
