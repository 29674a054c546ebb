"""Paths drawn from their curvature, so that their sharpest bend is known before they are made."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hognose.path import Path

Array = NDArray[np.float64]
#: Curvatures (m, 2) in 1/m along two axes that do not twist, at arc lengths (m,) in m.
Profile = Callable[[Array], Array]

_STRIDE = 0.001


def drawn(profile: Profile, length: float, run: float, every: float = 0.015) -> Path:
    """A path that starts with a straight run along z from the origin, then bends as the profile says.

    Parameters
    ----------
    profile
        Curvature along two axes that move with the tangent without twisting about it.
    length, run : float, m
        Length of the bent part, and of the straight run in front of it.
    every : float, m
        Distance of the way-points of the cubic spline that is laid through the curve.
    """
    count = max(2, round(length / _STRIDE))
    stride = length / count
    turns = _turns(profile(stride * (np.arange(count, dtype=np.float64) + 0.5)) * stride)
    tangents = np.empty((count + 1, 3))
    frame = np.eye(3)
    tangents[0] = frame[:, 2]
    for step in range(count):
        frame = frame @ turns[step]
        tangents[step + 1] = frame[:, 2]
    moves = 0.5 * stride * (tangents[1:] + tangents[:-1])
    points = np.concatenate([np.zeros((1, 3)), np.cumsum(moves, axis=0)]) + np.array([0.0, 0.0, run])
    chosen = np.linspace(0, count, max(3, round(length / every)) + 1).round().astype(int)
    return Path.through(points[chosen], 3, (0.0, 0.0, 1.0)).with_run(run)


def eased(s: Array, length: float, ramp: float) -> Array:
    """A factor (m,) that rises smoothly from 0 to 1 over the first `ramp` metres and falls over the last."""
    part = np.clip(np.minimum(s, length - s) / ramp, 0.0, 1.0)
    return part * part * (3.0 - 2.0 * part)


def _turns(bends: Array) -> Array:
    """Rotations (m, 3, 3) that turn z towards x and y by the bends (m, 2) rad."""
    angle = np.hypot(bends[:, 0], bends[:, 1])
    axis = np.stack([-bends[:, 1], bends[:, 0], np.zeros(len(bends))], axis=1)
    axis /= np.where(angle > 0.0, angle, 1.0)[:, None]
    cross = np.zeros((len(bends), 3, 3))
    cross[:, 0, 2], cross[:, 1, 2] = axis[:, 1], -axis[:, 0]
    cross[:, 2, 0], cross[:, 2, 1] = -axis[:, 1], axis[:, 0]
    sine, cosine = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + sine * cross + (1.0 - cosine) * (cross @ cross)
