"""How a rigid thing moves over time: through poses, straight and turning steadily from each to the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.cached import cached_array
from hognose.rotations import rotations_of_vectors

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RigidMotion:
    """A motion through k poses; the thing stands still before the first and after the last.

    From pose to pose its pivot goes straight at a steady speed, and it turns about one axis at a steady rate.

    Attributes
    ----------
    times : (k,) s
        Increasing; two or more.
    pivot : (3,) m
        The point of the thing about which it turns, where it is as placed.
    places : (k, 3) m
        The pivot at the poses.
    R_task_placed : (k, 3, 3)
        How the thing as placed is turned at the poses.
    spins : (k-1, 3) rad
        Rotation vectors, in the frame of the task, by which it turns from each pose to the next.
    repeats
        Whether it begins again after the last pose, which is then like the first.
    """

    times: Array
    pivot: Array
    places: Array
    R_task_placed: Array
    spins: Array
    repeats: bool = False

    def poses(self, times: ArrayLike) -> tuple[Array, Array]:
        """Rotation (m, 3, 3) and place of the pivot (m, 3) m at times (m,) s."""
        at = self._within(np.asarray(times, np.float64))
        row = np.clip(np.searchsorted(self.times, at, "right") - 1, 0, len(self.times) - 2)
        share = np.clip((at - self.times[row]) / (self.times[row + 1] - self.times[row]), 0.0, 1.0)[:, None]
        places = self.places[row] + share * (self.places[row + 1] - self.places[row])
        return rotations_of_vectors(share * self.spins[row]) @ self.R_task_placed[row], places

    def gone(self, times: ArrayLike) -> tuple[Array, Array]:
        """How far the pivot has gone (m,) m and the thing has turned (m,) rad until times (m,) s, since the first."""
        times = np.asarray(times, np.float64)
        at, way, turn = self._within(times), self._ways[0], self._ways[1]
        rounds = np.round((np.maximum(times, self.times[0]) - self.times[0] - (at - self.times[0])) / self.period)
        slid, turned = np.interp(at, self.times, way), np.interp(at, self.times, turn)
        return (slid + rounds * way[-1], turned + rounds * turn[-1]) if self.repeats else (slid, turned)

    def into_frame(self, points: Array, times: ArrayLike) -> Array:
        """Points (m, p, 3) m of the task at times (m,) s, in the frame in which the thing was placed."""
        turned, places = self.poses(times)
        return (points - places[:, None]) @ turned + self.pivot

    def out_of_frame(self, points: Array, time: float) -> Array:
        """Points (..., 3) m of the thing as placed, where they are in the task at a time (s)."""
        turned, places = self.poses([time])
        return (points - self.pivot) @ turned[0].T + places[0]

    @property
    def period(self) -> float:
        """From the first pose to the last (s)."""
        return float(self.times[-1] - self.times[0])

    @property
    def fastest(self) -> tuple[float, float]:
        """The largest speed (m/s) of the pivot, and of turning (rad/s)."""
        spans = np.diff(self.times)
        return float((np.diff(self._ways[0]) / spans).max()), float((np.diff(self._ways[1]) / spans).max())

    @cached_array
    def _ways(self) -> Array:
        """How far the pivot went (m) and the thing turned (rad) until each pose: (2, k)."""
        out = np.zeros((2, len(self.times)))
        np.cumsum(np.linalg.norm(np.diff(self.places, axis=0), axis=1), out=out[0, 1:])
        np.cumsum(np.linalg.norm(self.spins, axis=1), out=out[1, 1:])
        return out

    def _within(self, times: Array) -> Array:
        """Times (m,) s between the first pose and the last at which it stands alike."""
        first, last = self.times[0], self.times[-1]
        if not self.repeats:
            return np.clip(times, first, last)
        return np.where(times > first, first + np.fmod(np.maximum(times - first, 0.0), self.period), first)
