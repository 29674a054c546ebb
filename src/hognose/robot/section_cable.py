"""One cable through one section of any kind: its length, and its first and second derivatives by the section's angles.

Kinds say which law holds for their cables: see `CableLaw`. The same lengths as `SectionKind.cables` has for many poses.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.robot.joint_cable import curvature, through_joint
from hognose.robot.stumpff import of_sine


class CableLaw(NamedTuple):
    """How cables run through a section; lengths in m.

    Through `joints` equal joints, each with its share of the angles, straight from the hole plane `before` each to the
    one `after` it; the two axes of a joint are `offset` apart. Or, where `arc` is not 0, beside an arc of that length,
    straight between `disks` disks, or bent with it if there are none.
    """

    before: float
    after: float
    offset: float = 0.0
    joints: float = 1.0
    arc: float = 0.0
    disks: float = 0.0


@kernel()
def _through_hinges(
    alpha: float, beta: float, before: float, after: float, offset: float, radius: float, c: float, s: float
) -> Any:
    """Length between the hole planes of two hinges, and its derivatives: of the vector d from hole to hole.

    With d_x its derivatives, the length is ℓ = |d|, ℓ_x = d·d_x/ℓ and ℓ_xy = (d_x·d_y + d·d_xy - ℓ_x ℓ_y)/ℓ.
    """
    ca, sa, cb, sb = math.cos(alpha), math.sin(alpha), math.cos(beta), math.sin(beta)
    x, y = radius * c, radius * s
    across, reach = y * cb - after * sb, y * sb + after * cb
    along = reach + offset
    dx, dy, dz = ca * x + sa * along - x, across - y, ca * along - sa * x + before
    ax, az = ca * along - sa * x, -ca * x - sa * along
    bx, by, bz = sa * across, -reach, ca * across
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    scale = 1.0 / length
    la, lb = scale * (dx * ax + dz * az), scale * (dx * bx + dy * by + dz * bz)
    aa = scale * (ax * ax + az * az + dx * az - dz * ax - la * la)
    ab = scale * (ax * bx + az * bz + dx * ca * across - dz * sa * across - la * lb)
    bb = scale * (bx * bx + by * by + bz * bz - dx * sa * reach - dy * across - dz * ca * reach - lb * lb)
    return length, la, lb, aa, bb, ab


@kernel()
def _beside_arc(alpha: float, beta: float, arc: float, disks: float, radius: float, c: float, s: float) -> Any:
    """Length S w beside an arc less that of the arc, with w = L - r (α c - β s) and S = sin(θ/2D)/(θ/2D)."""
    wa, wb = -radius * c, radius * s
    if disks == 0.0:
        return wa * alpha + wb * beta, wa, wb, 0.0, 0.0, 0.0
    share = 0.25 / (disks * disks)
    w = arc + wa * alpha + wb * beta
    S, d, dd = of_sine(share * (alpha * alpha + beta * beta))
    d, dd = 2.0 * share * d, 4.0 * share * share * dd  # S_α = α d, S_αα = d + α² dd
    la, lb = alpha * d * w + S * wa, beta * d * w + S * wb
    aa = (d + alpha * alpha * dd) * w + 2.0 * alpha * d * wa
    bb = (d + beta * beta * dd) * w + 2.0 * beta * d * wb
    ab = alpha * beta * dd * w + d * (alpha * wb + beta * wa)
    return S * w - arc, la, lb, aa, bb, ab


@kernel()
def through_section(law: NDArray, alpha: float, beta: float, radius: float, c: float, s: float) -> Any:
    """Length (m) as of `SectionKind.cables`, and its derivatives by α, β, by α twice, by β twice, and by both.

    Parameters
    ----------
    law : (6,)
        A `CableLaw`.
    alpha, beta : rad
        Of the section.
    radius, c, s
        Circle (m), cosine and sine of the azimuth of the cable's holes.
    """
    before, after, offset, joints = law[0], law[1], law[2], law[3]
    if law[4] != 0.0:
        return _beside_arc(alpha, beta, law[4], law[5], radius, c, s)
    a, b = alpha / joints, beta / joints
    if offset != 0.0:
        length, la, lb, aa, bb, ab = _through_hinges(a, b, before, after, offset, radius, c, s)
    else:
        ca, sa, cb, sb = math.cos(a), math.sin(a), math.cos(b), math.sin(b)
        length, la, lb = through_joint(ca, sa, cb, sb, before, after, radius, c, s)
        aa, bb, ab = curvature(ca, sa, cb, sb, before, after, radius, c, s, length, la, lb)
    straight = (joints - 1.0) * (before + after) + joints * offset
    return joints * length - straight, la, lb, aa / joints, bb / joints, ab / joints
