"""Points on a polyline at equal distances along it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def even(points: Array, spacing: float) -> Array:
    """Points on a polyline, about `spacing` m apart."""
    arcs = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    wanted = np.linspace(0.0, arcs[-1], max(2, int(np.ceil(arcs[-1] / spacing)) + 1))
    return np.stack([np.interp(wanted, arcs, points[:, k]) for k in range(3)], axis=1)
