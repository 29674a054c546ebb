"""Damped least squares with a null-space term (paper refs. 15–18; Wampler 1986, Liégeois 1977).

The angles change by Δq = Jᵀ(JJᵀ + λ²I)⁻¹ e + (I − J⁺J) k(0 − q): the first part brings the tip onto its goal, damped
where the arm is nearly straight; the second uses the joints that are left over to pull all of them towards the middle
of their range. The goal is the tip of exact following at the same feed; angles are clamped to their limits.

Cost a step: O(n) an iteration, as JJᵀ is 3 × 3; a handful of iterations. Known weakness: only the tip is on the path;
the null-space term straightens the body, which cuts every corner that the path goes round.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.following.chain import angles_in_frame, placed
from hognose.following.follower import Array
from hognose.following.tip_only import Goals, Progress, TipOnly, under_way
from hognose.kernels import kernel

#: Lengths (n,) of the links, and lowest and highest angles (n, 2, 2) of the joints.
Arm = tuple[NDArray, NDArray]

#: The damping λ, m, and the part k of each angle by which the null-space term lowers it, once a step.
_DAMPING, _CENTRING = 1e-3, 0.1


@kernel()
def _improve(
    joints: NDArray, axes: NDArray, limits: NDArray, goal: NDArray, centring: float, columns: NDArray, angles: NDArray
) -> None:
    """One step of the angles (n, 2) towards the goal; `columns` (n, 2, 3) is J."""
    links = angles.shape[0]
    tx, ty, tz = joints[links, 0], joints[links, 1], joints[links, 2]
    # What is left to go once the null-space part's centring has moved the tip, and JJᵀ + λ²I.
    gx, gy, gz = goal[0] - tx, goal[1] - ty, goal[2] - tz
    xx, yy, zz = _DAMPING**2, _DAMPING**2, _DAMPING**2
    xy, xz, yz = 0.0, 0.0, 0.0
    for i in range(links):
        lx, ly, lz = tx - joints[i, 0], ty - joints[i, 1], tz - joints[i, 2]
        for k in range(2):
            ax, ay, az = axes[i, k, 0], axes[i, k, 1], axes[i, k, 2]
            cx, cy, cz = ay * lz - az * ly, az * lx - ax * lz, ax * ly - ay * lx
            columns[i, k, 0], columns[i, k, 1], columns[i, k, 2] = cx, cy, cz
            moved = centring * angles[i, k]
            gx, gy, gz = gx + moved * cx, gy + moved * cy, gz + moved * cz
            xx, yy, zz = xx + cx * cx, yy + cy * cy, zz + cz * cz
            xy, xz, yz = xy + cx * cy, xz + cx * cz, yz + cy * cz
    p, q, r = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    scale = 1.0 / (xx * p + xy * q + xz * r)
    s, t, u = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    px = scale * (p * gx + q * gy + r * gz)
    py = scale * (q * gx + s * gy + t * gz)
    pz = scale * (r * gx + t * gy + u * gz)
    for i in range(links):
        for k in range(2):
            pulled = columns[i, k, 0] * px + columns[i, k, 1] * py + columns[i, k, 2] * pz
            angle = angles[i, k] * (1.0 - centring) + pulled
            angles[i, k] = min(max(angle, limits[i, k, 0]), limits[i, k, 1])


@kernel()
def _solve(arm: Arm, goals: Goals, progress: Progress, joints: NDArray) -> None:
    """Improve the angles, at least once a step, until `under_way` ends."""
    lengths, limits = arm
    bases, frames, tips = goals
    posture, count, _ = progress
    links = lengths.size
    angles, axes, columns = np.empty((links, 2)), np.empty((links, 2, 3)), np.empty((links, 2, 3))
    while under_way(goals, progress, 1, joints):
        t, first = count[0], count[1] == 1
        if first:
            angles_in_frame(posture, frames[t], angles)
            placed(bases[t], frames[t], lengths, angles, joints[t], axes)
        _improve(joints[t], axes, limits, tips[t], _CENTRING if first else 0.0, columns, angles)
        placed(bases[t], frames[t], lengths, angles, joints[t], axes)


class Jacobian(TipOnly):
    """Damped least squares: the tip on the path by the Jacobian, the joints towards their middle; the body is free."""

    name = "jacobian"
    _kernel = staticmethod(_solve)

    def _bounded_arm(self) -> tuple[Array, ...]:
        return self.link_lengths, self.bend_bounds
