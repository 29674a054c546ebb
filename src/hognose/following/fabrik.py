"""FABRIK: forward and backward reaching inverse kinematics (paper ref. 20, Aristidou & Lasenby 2011).

The tip is put on its goal and the joints are drawn after it one by one, each a link from the last; then the base is put
back on the slider and the joints are drawn after it the other way, until the tip is close enough. In both passes the
bend between neighbouring links stays within a cone. The goal is the tip of exact following at the same feed.

Cost a step: O(n) a pass; few passes where the arm is bent, hundreds where it is nearly straight. Known weakness: only
the tip is on the path. The body lies wherever the last posture and the passes put it, and drifts as the arm goes in.
"""

from __future__ import annotations

import math
from typing import Any

from numpy.typing import NDArray

from hognose.following.tip_only import Cones, Goals, Progress, TipOnly, under_way
from hognose.kernels import kernel


@kernel(inline="always")
def within_cone(dx: float, dy: float, dz: float, ax: float, ay: float, az: float, cosine: float, sine: float) -> Any:
    """The unit direction closest to d, of any length, within a cone about the unit axis a."""
    size = math.sqrt(dx * dx + dy * dy + dz * dz)
    if size == 0.0:
        return ax, ay, az
    dx, dy, dz = dx / size, dy / size, dz / size
    along = dx * ax + dy * ay + dz * az
    if along >= cosine:
        return dx, dy, dz
    sx, sy, sz = dx - along * ax, dy - along * ay, dz - along * az
    side = math.sqrt(sx * sx + sy * sy + sz * sz)
    if side < 1e-12:
        return ax, ay, az
    part = sine / side
    return cosine * ax + part * sx, cosine * ay + part * sy, cosine * az + part * sz


@kernel()
def _solve(cones: Cones, goals: Goals, progress: Progress, joints: NDArray) -> None:
    """Repeat the two passes, step after step, until `under_way` ends."""
    lengths, cosines, sines = cones
    bases, frames, tips = goals
    _, count, evaluations = progress
    links = lengths.size
    while under_way(goals, progress, 0, joints):
        t = count[0]
        chain = joints[t]
        evaluations[0] += 2 * links
        chain[links] = tips[t]
        ax, ay, az = 0.0, 0.0, 0.0
        for i in range(links - 1, -1, -1):
            dx, dy, dz = chain[i, 0] - chain[i + 1, 0], chain[i, 1] - chain[i + 1, 1], chain[i, 2] - chain[i + 1, 2]
            # The cone of joint i + 1, seen from its tip side; nothing bounds the last link there.
            cosine, sine = (cosines[i + 1], sines[i + 1]) if i < links - 1 else (-2.0, 0.0)
            ax, ay, az = within_cone(dx, dy, dz, ax, ay, az, cosine, sine)
            chain[i, 0] = chain[i + 1, 0] + lengths[i] * ax
            chain[i, 1] = chain[i + 1, 1] + lengths[i] * ay
            chain[i, 2] = chain[i + 1, 2] + lengths[i] * az
        chain[0] = bases[t]
        ax, ay, az = frames[t, 2, 0], frames[t, 2, 1], frames[t, 2, 2]
        for i in range(links):
            dx, dy, dz = chain[i + 1, 0] - chain[i, 0], chain[i + 1, 1] - chain[i, 1], chain[i + 1, 2] - chain[i, 2]
            ax, ay, az = within_cone(dx, dy, dz, ax, ay, az, cosines[i], sines[i])
            chain[i + 1, 0] = chain[i, 0] + lengths[i] * ax
            chain[i + 1, 1] = chain[i, 1] + lengths[i] * ay
            chain[i + 1, 2] = chain[i, 2] + lengths[i] * az


class Fabrik(TipOnly):
    """FABRIK: the tip on the path by reaching back and forth; the body is free."""

    name = "fabrik"
    _kernel = staticmethod(_solve)
