"""Residuals of what the base does with the first joint: how far it takes it, where, and how fast it turns the arm.

Each function gives residuals (r,) and their derivatives (r, 3 f) by the coordinates of the f free way-points. `basis`
(T, n+1, f) says how much joints move with each of those.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.robot.base import Base, turns
from hognose.route.fit.motion import Motion

Array = NDArray[np.float64]
Rows = tuple[Array, Array]


def turn_rates(base: Base, motion: Motion, feed_speed: float) -> Array:
    """How fast (T-1,) rad/s the arm's axes turn from step to step, at a feed speed (m/s)."""
    return np.linalg.norm(turns(base, motion.at), axis=1) / np.diff(motion.feeds) * feed_speed


def turn_rows(over: Array, unit: float, motion: Motion, basis: Array, feed_speed: float) -> Rows:
    """Turning faster than wanted, by `over` (T-1,) rad/s; `unit` rad/s counts as one.

    The axes turn as the first link does, but for a turn about it that is of second order.
    """
    step = np.flatnonzero(over > 0)
    first = motion.joints[:, 1] - motion.joints[:, 0]
    length = np.linalg.norm(first[0])
    change = (first[step + 1] - first[step]) / length
    way = change / np.maximum(np.linalg.norm(change, axis=1, keepdims=True), 1e-12)
    moved = (basis[step + 1, 1] - basis[step + 1, 0] - basis[step, 1] + basis[step, 0]) / length
    slope = feed_speed / (motion.feeds[step + 1] - motion.feeds[step]) / unit
    rows = slope[:, None, None] * moved[:, :, None] * way[:, None, :]
    return over[step] / unit, rows.reshape(len(step), 3 * basis.shape[2])


def workspace_rows(outside: Array, unit: float, basis: Array) -> Rows:
    """Ways (T, 3) m to the first joint from where the base can take it, a little farther than to its wall."""
    step, axis = np.nonzero(outside)
    over = outside[step, axis]
    value = np.abs(over) / unit + (0.2 if len(over) else 0.0)
    rows = np.zeros((len(over), basis.shape[2], 3))
    rows[np.arange(len(over)), :, axis] = np.sign(over)[:, None] * basis[step, 0]
    return value, rows.reshape(len(over), 3 * basis.shape[2]) / unit


def reach_row(over: float, unit: float, motion: Motion, lengths: Array, basis: Array) -> Rows:
    """Feeding farther than the base goes, by `over` m."""
    if over <= 0:
        return np.empty(0), np.empty((0, 3 * basis.shape[2]))
    # The base moves back by as much as the links' chords grow along the arm.
    direction = np.diff(motion.joints[-1], axis=0) / lengths[:, None]
    last = basis[-1]
    grows = ((last[1:] - last[:-1])[:, :, None] * direction[:, None, :]).sum(axis=0)
    return np.array([over / unit]), grows.reshape(1, -1) / unit
