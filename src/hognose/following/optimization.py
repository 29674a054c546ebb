"""Optimisation search (paper ref. 29, Palmer et al. 2014; its text was not at hand, so Palmer-style).

The joint angles are those whose joints have the smallest weighted squared distances to the path, the tip weighted most,
within the bend limits, from the last step's angles on. Within the limits the smallest distances are zero, and the
system is triangular: joint i + 1 depends on the angles up to i only. Tuned, Gauss–Newton therefore solves for the two
angles of one joint after the other, carrying the motion of the rest of the arm as one angular velocity and one moment,
from angles that the last two steps predict. Where a limit holds a joint back or this finds no place, and always
as published, Levenberg–Marquardt with finite differences does it.

Cost a step: O(n) for each of two or three iterations; as published O(n²) distances and O(n³) arithmetic for each of
several. Known weakness: it finds a minimum near where it starts, so on a path that turns by more than a right angle
within a link it can end on another crossing, or on none.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.following.chain import angles_in_frame, placed
from hognose.following.crossing import OVERRUN
from hognose.following.follower import Array
from hognose.following.least_squares import minimise
from hognose.following.warm_started import WarmStarted
from hognose.kernels import kernel
from hognose.path import Path
from hognose.path.polynomial import evaluate

#: Weight of the tip's distance; that of the others is 1.
_TIP_WEIGHT = 10.0
#: A distance (m) so small that the next iteration, which squares it, is the last one; and how many there may be.
_LAST, _ITERATIONS = 1e-7, 20
#: Largest change (rad) of an angle in an iteration.
_LARGEST_TURN = 0.3


@kernel(fastmath={"contract"})
def _turns(
    breaks: NDArray,
    coefficients: NDArray,
    joints: NDArray,
    axes: NDArray,
    feet: NDArray,
    segments: NDArray,
    turns: NDArray,
) -> float:
    """Fill the changes (n, 2) of the angles that put every joint on the path, and move the feet along it.

    Returns the largest distance (m) before, of a joint to the path or of a foot to where it should be.

    A turn ω_j about joint j moves a point X by ω_j × (X - C_j), so all turns before it by Ω × X - M,
    Ω = Σ ω_j, M = Σ ω_j × C_j.
    """
    worst = 0.0
    ox, oy, oz, mx, my, mz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(feet.size):
        cx, cy, cz = joints[i + 1, 0], joints[i + 1, 1], joints[i + 1, 2]
        u, segment = feet[i], segments[i]
        while segment < breaks.size - 2 and u >= breaks[segment + 1]:
            segment += 1
        while segment > 0 and u < breaks[segment]:
            segment -= 1
        segments[i] = segment
        px, py, pz, vx, vy, vz, ax, ay, az = evaluate(coefficients, segment, u - breaks[segment])
        dx, dy, dz = cx - px, cy - py, cz - pz
        speed = vx * vx + vy * vy + vz * vz
        ahead = dx * vx + dy * vy + dz * vz
        steep = speed - 2.0 * (dx * ax + dy * ay + dz * az)
        feet[i] = min(max(u + ahead / (steep if steep > 0.1 * speed else speed), breaks[0]), breaks[-1])
        worst = max(worst, math.sqrt(max(dx * dx + dy * dy + dz * dz - ahead * ahead / speed, 0.0)))
        worst = max(worst, abs(feet[i] - u) * math.sqrt(speed))
        # What is to be made good, and what the two angles can do, both across the path.
        dx, dy, dz = dx + oy * cz - oz * cy - mx, dy + oz * cx - ox * cz - my, dz + ox * cy - oy * cx - mz
        part = (dx * vx + dy * vy + dz * vz) / speed
        dx, dy, dz = dx - part * vx, dy - part * vy, dz - part * vz
        lx, ly, lz = cx - joints[i, 0], cy - joints[i, 1], cz - joints[i, 2]
        ux, uy, uz = axes[i, 0, 0], axes[i, 0, 1], axes[i, 0, 2]
        wx, wy, wz = axes[i, 1, 0], axes[i, 1, 1], axes[i, 1, 2]
        ex, ey, ez = uy * lz - uz * ly, uz * lx - ux * lz, ux * ly - uy * lx
        fx, fy, fz = wy * lz - wz * ly, wz * lx - wx * lz, wx * ly - wy * lx
        part = (ex * vx + ey * vy + ez * vz) / speed
        ex, ey, ez = ex - part * vx, ey - part * vy, ez - part * vz
        part = (fx * vx + fy * vy + fz * vz) / speed
        fx, fy, fz = fx - part * vx, fy - part * vy, fz - part * vz
        ee, ef, ff = ex * ex + ey * ey + ez * ez, ex * fx + ey * fy + ez * fz, fx * fx + fy * fy + fz * fz
        ed, fd = ex * dx + ey * dy + ez * dz, fx * dx + fy * dy + fz * dz
        determinant = max(ee * ff - ef * ef, 1e-6 * (lx * lx + ly * ly + lz * lz) ** 2)
        alpha = min(max((ef * fd - ff * ed) / determinant, -_LARGEST_TURN), _LARGEST_TURN)
        beta = min(max((ef * ed - ee * fd) / determinant, -_LARGEST_TURN), _LARGEST_TURN)
        turns[i, 0], turns[i, 1] = alpha, beta
        tx, ty, tz = alpha * ux + beta * wx, alpha * uy + beta * wy, alpha * uz + beta * wz
        ox, oy, oz = ox + tx, oy + ty, oz + tz
        bx, by, bz = joints[i, 0], joints[i, 1], joints[i, 2]
        mx, my, mz = mx + ty * bz - tz * by, my + tz * bx - tx * bz, mz + tx * by - ty * bx
    return worst


@kernel()
def _newton(
    breaks: NDArray,
    coefficients: NDArray,
    base: NDArray,
    frame: NDArray,
    lengths: NDArray,
    limits: NDArray,
    angles: NDArray,
    foot: NDArray,
    chain: NDArray,
    evaluations: NDArray,
) -> bool:
    """Gauss–Newton from the angles (n, 2) and feet (n,) given; whether it found a place within the limits."""
    turns, axes = np.empty_like(angles), np.empty((lengths.size, 2, 3))
    segments = np.zeros(lengths.size, np.int64)
    for _ in range(_ITERATIONS):
        placed(base, frame, lengths, angles, chain, axes)
        worst = _turns(breaks, coefficients, chain, axes, foot, segments, turns)
        evaluations[0] += lengths.size
        angles += turns
        if worst <= _LAST:
            placed(base, frame, lengths, angles, chain, axes)
            return bool((np.abs(angles) <= limits).all())
    return False


@kernel()
def _advance(
    breaks: NDArray,
    coefficients: NDArray,
    lengths: NDArray,
    limits: NDArray,
    weights: NDArray,
    as_published: bool,
    feeds: NDArray,
    last_feed: float,
    bases: NDArray,
    frames: NDArray,
    memory: NDArray,
    feet: NDArray,
    evaluations: NDArray,
    joints: NDArray,
) -> tuple[int, int]:
    """Place the joints for every feed; `feet` (2, n) are the path's parameters closest to them, and their rate."""
    links = lengths.size
    angles = np.empty((links, 2))
    for t in range(feeds.size):
        change, chain, foot = feeds[t] - last_feed, joints[t], feet[0].copy()
        foot += change * feet[1]
        chain[:] = memory[0] + change * memory[1]
        angles_in_frame(chain, frames[t], angles)
        if as_published or not _newton(
            breaks, coefficients, bases[t], frames[t], lengths, limits, angles, foot, chain, evaluations
        ):
            foot[:] = feet[0]
            angles_in_frame(memory[0], frames[t], angles)
            minimise(
                breaks, coefficients, bases[t], frames[t], lengths, limits, weights, angles, foot, chain, evaluations
            )
        held = (np.abs(angles) >= limits).any()
        for i in range(links):
            if not held and foot[i] >= breaks[-1] - 1e-12:
                px, py, pz, _, _, _, _, _, _ = evaluate(coefficients, breaks.size - 2, breaks[-1] - breaks[-2])
                dx, dy, dz = chain[i + 1, 0] - px, chain[i + 1, 1] - py, chain[i + 1, 2] - pz
                if math.sqrt(dx * dx + dy * dy + dz * dz) > OVERRUN:
                    return t, i
        if abs(change) > 1e-9:
            memory[1], feet[1] = (chain - memory[0]) / change, (foot - feet[0]) / change
        memory[0], feet[0] = chain, foot
        last_feed = feeds[t]
    return -1, -1


class Optimization(WarmStarted):
    """Optimisation search: the angles whose joints are closest to the path, within the bend limits.

    Parameters
    ----------
    path : Path
    link_lengths : (n,) m
    spacing : float, m
        Not used.
    bend_limits : rad
        Largest |α| and |β|; a joint that one of them holds back leaves the path.
    as_published
        A general least-squares search with finite differences from the last step's angles.
    """

    name = "optimization"

    def __init__(
        self,
        path: Path,
        link_lengths: ArrayLike,
        spacing: float = 0.0005,
        bend_limits: ArrayLike | None = None,
        as_published: bool = False,
    ) -> None:
        super().__init__(path, link_lengths, spacing, bend_limits)
        self._published = as_published
        self._weights = np.ones(self.link_lengths.size)
        self._weights[-1] = _TIP_WEIGHT
        self._feet = np.zeros((2, self.link_lengths.size))

    @property
    def tolerance(self) -> float:
        """Where the search ends."""
        return 1e-10

    def _begin(self, feed: float) -> None:
        super()._begin(feed)
        arcs = feed + np.cumsum(self.link_lengths)
        self._feet[0] = self.path.parameter(np.minimum(arcs, self.path.length))
        self._feet[1] = 0.0

    def _continue(self, feeds: Array, bases: Array, frames: Array, joints: Array) -> tuple[int, int]:
        return _advance(
            self.path.breaks,
            self.path.coefficients,
            self.link_lengths,
            self.bend_limits,
            self._weights,
            self._published,
            feeds,
            float(self._feed),
            bases,
            frames,
            self._memory,
            self._feet,
            self._evaluations,
            joints,
        )
