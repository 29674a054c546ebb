"""Where an obstacle that moves sees the arm: one pose at a time, as the twin needs it at every step."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.scene.rigid_motion import RigidMotion

Array = NDArray[np.float64]


@kernel()
def _into_frame(
    points: NDArray,
    time: float,
    repeats: bool,
    times: NDArray,
    pivot: NDArray,
    places: NDArray,
    turned: NDArray,
    spins: NDArray,
    R: NDArray,
    out: NDArray,
) -> None:
    """Points (p, 3) of the task in the frame of a thing as placed; also how it is turned, R (3, 3)."""
    first, last = times[0], times[-1]
    at = first + max(time - first, 0.0) % (last - first) if repeats else min(max(time, first), last)
    row = 0
    while row < times.size - 2 and times[row + 1] <= at:
        row += 1
    share = min(max((at - times[row]) / (times[row + 1] - times[row]), 0.0), 1.0)
    x, y, z = share * spins[row, 0], share * spins[row, 1], share * spins[row, 2]
    angle = math.sqrt(x * x + y * y + z * z)
    if angle > 0.0:
        x, y, z = x / angle, y / angle, z / angle
    s, c = math.sin(angle), 2.0 * math.sin(0.5 * angle) ** 2
    spun = (
        (1.0 - c * (y * y + z * z), c * x * y - s * z, c * x * z + s * y),
        (c * x * y + s * z, 1.0 - c * (x * x + z * z), c * y * z - s * x),
        (c * x * z - s * y, c * y * z + s * x, 1.0 - c * (x * x + y * y)),
    )
    for b in range(3):
        for a, line in enumerate(spun):
            R[a, b] = line[0] * turned[row, 0, b] + line[1] * turned[row, 1, b] + line[2] * turned[row, 2, b]
    for i in range(points.shape[0]):
        for b in range(3):
            total = pivot[b]
            for a in range(3):
                place = places[row, a] + share * (places[row + 1, a] - places[row, a])
                total += (points[i, a] - place) * R[a, b]
            out[i, b] = total


@dataclass(frozen=True, eq=False)
class MovingFrame:
    """The frame of a thing that moves.

    Attributes
    ----------
    motion
    R_task_placed : (3, 3)
        How it was turned when it was last asked.
    """

    motion: RigidMotion
    R_task_placed: Array
    _seen: Array

    @classmethod
    def of(cls, motion: RigidMotion, points: int) -> MovingFrame:
        """The frame of a motion, for so many points."""
        return cls(motion, np.eye(3), np.zeros((points, 3)))

    def seen(self, points: Array, time: float) -> Array:
        """Points (p, 3) m of the task at a time (s), in the frame of the thing as placed; written over when next asked.

        The same as `RigidMotion.into_frame`.
        """
        m = self.motion
        way = (m.times, m.pivot, m.places, m.R_task_placed, m.spins)
        _into_frame(points, time, m.repeats, *way, self.R_task_placed, self._seen)
        return self._seen
