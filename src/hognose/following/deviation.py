"""How far the body leaves the path: the distance of points along the links to the nearest path point."""

from __future__ import annotations

import numpy as np

from hognose.following.follower import Array
from hognose.path import Path


def body_deviation(path: Path, joints: Array, samples: int = 8) -> Array:
    """The largest distance of points along each link to the path.

    Parameters
    ----------
    path : Path
    joints : (T, n+1, 3) m
    samples
        Points on each link, evenly spaced from its first end; its last end is measured as well.

    Returns
    -------
    (T, n) m
    """
    part = np.arange(samples) / samples
    along = joints[:, :-1, None] + part[:, None] * np.diff(joints, axis=1)[:, :, None]
    body = np.concatenate([along.reshape(len(joints), -1, 3), joints[:, -1:]], axis=1)
    # One link at a time through all steps, so that neighbours in the list are neighbours on the path.
    away = path.distance_to(np.ascontiguousarray(body.swapaxes(0, 1))).T
    within = away[:, :-1].reshape(len(joints), -1, samples).max(axis=2)
    return np.maximum(within, away[:, samples::samples])
