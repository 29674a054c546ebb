"""Poses in which an arm tells the most: each next one shrinks what is not known by the most (D-optimal, greedy)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hognose.calibration.arm import Accuracy
from hognose.calibration.fit import Prior
from hognose.calibration.model import Model
from hognose.errors import InfeasibleError

Array = NDArray[np.float64]

#: How many poses are chosen from, how far they bend of what the joints can, and the seed of their shapes.
_CANDIDATES, _BEND, _SEED = 160, 0.6, 7
#: Tensions of poses stay so far within the limits, as a share of what is between them: before the calibration they
#: are not known better.
_SHARE = 0.05


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
    arm, limits = model.nominal, model.nominal.robot.bend_limits
    rng, n = np.random.default_rng(_SEED), model.nominal.robot.sections
    at = (np.arange(n) + 0.5) / n
    # Half of them waves along the arm, half of them each joint for itself.
    waves = rng.normal(size=(_CANDIDATES // 2, 2, 3)) @ np.cos(np.pi * np.arange(3)[:, None] * at)
    shapes = np.concatenate([np.swapaxes(waves, 1, 2), rng.uniform(-1, 1, (_CANDIDATES // 2, n, 2))])
    size = np.abs(shapes).max(axis=(1, 2), keepdims=True)
    poses = shapes / size * rng.uniform(0.3, 1.0, (len(shapes), 1, 1)) * _BEND * limits
    poses = np.concatenate([np.zeros((1, n, 2)), poses])
    held = arm.hold(poses, model.gravity)
    room = _SHARE * (arm.tension_max - arm.tension_min)
    good = held.is_held & (held.load_factor >= arm.load_factor_min)
    good &= held.tensions.max(axis=1) <= arm.tension_max - room
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
    held = model.nominal.hold(poses, model.gravity)
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
