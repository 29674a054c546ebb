"""Poses in which an arm tells the most: each next one shrinks what is not known by the most (D-optimal, greedy)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hognose.calibration.arm import Accuracy
from hognose.calibration.fit import Prior
from hognose.calibration.model import Model
from hognose.errors import InfeasibleError
from hognose.mechanics import Mechanics
from hognose.robot.bends import on_side

Array = NDArray[np.float64]

#: How many poses are chosen from, how far they bend of what the joints can, and the seed of their shapes.
_CANDIDATES, _BEND, _SEED = 160, 0.6, 7
#: Until zeros are known, a cable that shall pull little may be slack, and an arm with slack cables falls over. So in
#: the poses of a calibration cables pull this share of the pretension at least, and stay a share of the range below the
#: limit.
_LEAST, _BELOW = 0.5, 0.25


def careful(mechanics: Mechanics, gravity: Array) -> Mechanics:
    """Mechanics with limits of tension that leave room; as they are if the straight arm needs them as they are."""
    least = max(mechanics.tension_min, _LEAST * float(mechanics.pretension.min()))
    most = mechanics.tension_max - _BELOW * (mechanics.tension_max - mechanics.tension_min)
    strict = replace(mechanics, tension_min=least, tension_max=most)
    straight = np.zeros((1, mechanics.robot.sections, 2))
    return strict if strict.hold(straight, gravity).is_held[0] else mechanics


def candidates(model: Model, free: Callable[[Array], NDArray[np.bool_]] | None = None) -> Array:
    """Poses (T, n, 2) rad that the cables hold with room; the first is the straight one.

    Parameters
    ----------
    model
    free
        Of angles (T, n, 2) rad: in which the arm is clear of everything; all unless given. Straight it must be.

    Raises
    ------
    InfeasibleError
        There are none, or only the straight one.
    """
    arm, bounds = careful(model.nominal, model.gravity), model.nominal.robot.bend_bounds
    rng, n = np.random.default_rng(_SEED), model.nominal.robot.sections
    at = (np.arange(n) + 0.5) / n
    # Half of them waves along the arm, half of them each joint for itself.
    waves = rng.normal(size=(_CANDIDATES // 2, 2, 3)) @ np.cos(np.pi * np.arange(3)[:, None] * at)
    shapes = np.concatenate([np.swapaxes(waves, 1, 2), rng.uniform(-1, 1, (_CANDIDATES // 2, n, 2))])
    size = np.abs(shapes).max(axis=(1, 2), keepdims=True)
    poses = shapes / size * rng.uniform(0.3, 1.0, (len(shapes), 1, 1)) * _BEND * on_side(shapes, bounds)
    poses = np.concatenate([np.zeros((1, n, 2)), poses])
    held = arm.hold(poses, model.gravity)
    good = held.is_held & (held.load_factor >= arm.load_factor_min)
    if free is not None:
        good[1:] &= free(poses[1:])
    if not good[0] or good.sum() < 2:
        raise InfeasibleError(
            f"calibration: of {len(poses)} poses {good.sum()} are held with room to the limits of tension, do not "
            "buckle and are clear of obstacles; move the base back, or clamp the arm in a jig"
        )
    return poses[good]


def chosen(model: Model, poses: Array, count: int, accuracy: Accuracy, prior: Prior, tips: bool) -> Array:
    """The `count` poses (count, n, 2) rad that determine zeros and stiffness best, the first given one first."""
    held = careful(model.nominal, model.gravity).hold(poses, model.gravity)
    seen = model.derived(model.nominal, poses, held.tensions, np.ones(len(poses), np.bool_))
    rows = [seen.by_tensions / accuracy.tension] + ([seen.by_tips / accuracy.tip] if tips else [])
    scales = np.concatenate(
        [np.full(model.cables, prior.zero), np.full(model.unknowns - model.cables, prior.stiffness)]
    )
    J = np.concatenate(rows, axis=1) * scales
    taken, known = [0], np.eye(model.unknowns) + J[0].T @ J[0]
    while len(taken) < min(count, len(poses)):
        spread = np.linalg.inv(known)
        gains = np.linalg.slogdet(np.eye(J.shape[1]) + J @ spread @ np.swapaxes(J, 1, 2))[1]
        gains[taken] = -np.inf
        taken.append(int(np.argmax(gains)))
        known += J[taken[-1]].T @ J[taken[-1]]
    return poses[taken]
