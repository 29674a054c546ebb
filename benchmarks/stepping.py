"""Stepping through the points: the iterative search that prediction lookup is measured against."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True)
def step_through(points: NDArray, spacing: float, lengths: NDArray, feeds: NDArray, joints: NDArray) -> None:
    """From each joint on, go to the next point until it is a link away; squared distances, no square root."""
    for t in range(feeds.size):
        index = int(feeds[t] / spacing + 0.5)
        joints[t, 0] = points[index]
        for i in range(lengths.size):
            x, y, z = points[index, 0], points[index, 1], points[index, 2]
            wanted = lengths[i] * lengths[i]
            while index < points.shape[0] - 1:
                index += 1
                dx, dy, dz = points[index, 0] - x, points[index, 1] - y, points[index, 2] - z
                if dx * dx + dy * dy + dz * dz >= wanted:
                    break
            joints[t, i + 1] = points[index]


def joints_by_stepping(
    points: NDArray[np.float64], spacing: float, lengths: NDArray[np.float64], feeds: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Joints (T, n+1, 3) m."""
    joints = np.empty((len(feeds), len(lengths) + 1, 3))
    step_through(points, spacing, lengths, feeds, joints)
    return joints
