"""Optimisation search (paper ref. 29, Palmer et al. 2014; its text was not at hand, so Palmer-style).

The joint angles are those whose joints have the smallest weighted squared distances to the path, the tip weighted most,
within the bend limits, from the last step's angles on. Within the limits the smallest distances are zero, and the
system is triangular: joint i + 1 depends on the angles up to i only. Tuned, Gauss–Newton therefore solves for the two
angles of one joint after the other, carrying the motion of the rest of the arm as one angular velocity and one moment,
from angles that the last two steps predict. Where a joint is at its limit, or this does not converge,
Levenberg–Marquardt with finite differences is used instead; as published it is used always.

Cost a step: O(n) for each of two or three iterations; as published O(n²) distances and O(n³) arithmetic for each of
several. Known weakness: it finds a minimum near where it starts, so on a path that turns by more than a right angle
within a link it can end on another crossing, or on none.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from hognose.following.chain import angles_in_frame, base_frames, laid_along, placed
from hognose.following.crossing import OVERRUN
from hognose.following.follower import SOLVED, Array
from hognose.following.least_squares import Arm, Base, minimise
from hognose.following.published import Tuned
from hognose.kernels import kernel
from hognose.path.polynomial import Pieces, evaluate

#: Feeds (T,) m of steps, places (T, 3) m and frames (T, 3, 3) of the base there.
Steps = tuple[NDArray, NDArray, NDArray]
#: Of the last step: the posture (2, n+1, 3) m and the path's parameters (2, n) closest to the joints, each with its
#: change with the feed, zero after a jump; and the feed (1,) m, NaN before the first step.
Memory = tuple[NDArray, NDArray, NDArray]

#: Weight of the tip's distance; that of the others is 1.
_TIP_WEIGHT = 10.0
#: A distance (m) so small that the next iteration, which squares it, is the last one; and how many there may be.
_LAST, _ITERATIONS = 1e-7, 20
#: Largest change (rad) of an angle in an iteration.
_LARGEST_TURN = 0.3


@kernel(fastmath={"contract"})
def _turns(pieces: Pieces, joints: NDArray, axes: NDArray, feet: NDArray, segments: NDArray, turns: NDArray) -> float:
    """Fill the changes (n, 2) of the angles that put every joint on the path, and move the feet along it.

    Returns the largest distance (m) before, of a joint to the path or of a foot to where it should be.

    A turn ω_j about joint j moves a point X by ω_j × (X - C_j), so all turns before it by Ω × X - M,
    Ω = Σ ω_j, M = Σ ω_j × C_j.
    """
    breaks, coefficients = pieces
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
    pieces: Pieces, at: Base, arm: Arm, angles: NDArray, foot: NDArray, chain: NDArray, evaluations: NDArray
) -> bool:
    """Gauss–Newton from the angles (n, 2) and feet (n,) given; whether it found a place within the limits."""
    base, frame = at
    lengths, limits, _ = arm
    turns, axes = np.empty_like(angles), np.empty((lengths.size, 2, 3))
    segments = np.zeros(lengths.size, np.int64)
    for _ in range(_ITERATIONS):
        placed(base, frame, lengths, angles, chain, axes)
        worst = _turns(pieces, chain, axes, foot, segments, turns)
        evaluations[0] += lengths.size
        angles += turns
        if worst <= _LAST:
            placed(base, frame, lengths, angles, chain, axes)
            return bool((angles >= limits[:, :, 0]).all() and (angles <= limits[:, :, 1]).all())
    return False


@kernel()
def _advance(
    pieces: Pieces, arm: Arm, as_published: bool, steps: Steps, memory: Memory, evaluations: NDArray, joints: NDArray
) -> tuple[int, int]:
    """Place the joints for every feed."""
    breaks, coefficients = pieces
    feeds, bases, frames = steps
    postures, feet, last = memory
    lengths, limits, _ = arm
    links = lengths.size
    angles = np.empty((links, 2))
    for t in range(feeds.size):
        change, chain, foot = feeds[t] - last[0], joints[t], feet[0].copy()
        foot += change * feet[1]
        chain[:] = postures[0] + change * postures[1]
        angles_in_frame(chain, frames[t], angles)
        at = bases[t], frames[t]
        if as_published or not _newton(pieces, at, arm, angles, foot, chain, evaluations):
            foot[:] = feet[0]
            angles_in_frame(postures[0], frames[t], angles)
            minimise(pieces, at, arm, angles, foot, chain, evaluations)
        held = (angles <= limits[:, :, 0]).any() or (angles >= limits[:, :, 1]).any()
        for i in range(links):
            if not held and foot[i] >= breaks[-1] - 1e-12:
                px, py, pz, _, _, _, _, _, _ = evaluate(coefficients, breaks.size - 2, breaks[-1] - breaks[-2])
                dx, dy, dz = chain[i + 1, 0] - px, chain[i + 1, 1] - py, chain[i + 1, 2] - pz
                if math.sqrt(dx * dx + dy * dy + dz * dz) > OVERRUN:
                    return t, i
        if abs(change) > 1e-9:
            postures[1], feet[1] = (chain - postures[0]) / change, (foot - feet[0]) / change
        postures[0], feet[0] = chain, foot
        last[0] = feeds[t]
    return -1, -1


class Optimization(Tuned):
    """Optimisation search: the angles whose joints are closest to the path, within the bend limits.

    Starts from the last step's posture; after a jump of the feed by more than half the shortest link, where the last
    posture is no guide, from the arm laid along the path.

    Parameters
    ----------
    path, link_lengths, spacing
        As in `Follower`; the spacing is not used.
    bend_limits : rad
        Largest |α| and |β|; a joint that one of them holds back leaves the path.
    as_published
        A general least-squares search with finite differences from the last step's angles.
    """

    name = "optimization"

    def _prepare(self) -> None:
        links = self.link_lengths.size
        weights = np.ones(links)
        weights[-1] = _TIP_WEIGHT
        self._arm: Arm = self.link_lengths, self.bend_bounds, weights
        self._memory: Memory = np.zeros((2, links + 1, 3)), np.zeros((2, links)), np.full(1, math.nan)

    @property
    def tolerance(self) -> float:
        """Where the search ends."""
        return 1e-10

    def _begin(self, feed: float) -> None:
        """Lay the arm along the path."""
        postures, feet, last = self._memory
        arcs = feed + np.cumsum(self.link_lengths)
        postures[0], postures[1] = laid_along(self.path, self.link_lengths, feed), 0.0
        feet[0], feet[1] = self.path.parameter(np.minimum(arcs, self.path.length)), 0.0
        last[0] = feed

    def _advance(self, feeds: Array, joints: Array) -> tuple[int, int]:
        if not feeds.size:
            return SOLVED
        pieces, published = (self.path.breaks, self.path.coefficients), self.as_published
        bases, frames = self.path.point(feeds), base_frames(self.path, feeds)
        last, jump = self._memory[2], 0.5 * float(self.link_lengths.min())
        starts = np.flatnonzero(~(np.abs(feeds - np.append(last, feeds[:-1])) <= jump))
        edges = np.unique(np.concatenate([[0], starts, [feeds.size]]))
        for start, end in itertools.pairwise(edges):
            if start in starts:
                self._begin(float(feeds[start]))
            part = slice(start, end)
            here = feeds[part], bases[part], frames[part]
            step, link = _advance(pieces, self._arm, published, here, self._memory, self._evaluations, joints[part])
            if step >= 0:
                last[0] = math.nan
                return int(start) + step, link
        return SOLVED
