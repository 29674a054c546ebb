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

    A cable may come to its first part from another circle than that of the section. Beside an arc without disks the
    step has the same length in all postures, and is left out.
    """

    before: float
    after: float
    offset: float = 0.0
    joints: float = 1.0
    arc: float = 0.0
    disks: float = 0.0

    @property
    def linear(self) -> bool:
        """Whether lengths are linear in the angles."""
        return self.arc != 0.0 and self.disks == 0.0


@kernel()
def at_joint(
    alpha: float, beta: float, before: float, after: float, offset: float, entering: float, radius: float, c: float,
    s: float,
) -> Any:  # fmt: skip
    """Length from a hole on a circle `entering` to one on `radius`, and its derivatives: of the vector d between them.

    With d_x its derivatives, the length is ℓ = |d|, ℓ_x = d·d_x/ℓ and ℓ_xy = (d_x·d_y + d·d_xy - ℓ_x ℓ_y)/ℓ.
    """
    ca, sa, cb, sb = math.cos(alpha), math.sin(alpha), math.cos(beta), math.sin(beta)
    x, y = radius * c, radius * s
    across, reach = y * cb - after * sb, y * sb + after * cb
    along = reach + offset
    dx, dy, dz = ca * x + sa * along - entering * c, across - entering * s, ca * along - sa * x + before
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
def between_circles(a: float, b: float, part: float, entering: float, radius: float, c: float, s: float) -> Any:
    """Length from a disk to the next one on an arc of a length `part`, from circle to circle, and its derivatives.

    ℓ² = (r₀ - r)² + S² (l - r₀ w)(l - r w), S = sin(θ/2)/(θ/2) and w = a c - b s (docs/kinematics.md).
    """
    S, d, dd = of_sine(0.25 * (a * a + b * b))
    d, dd = 0.5 * d, 0.25 * dd  # S_a = a d, S_aa = d + a² dd
    w = a * c - b * s
    first, other, step = part - entering * w, part - radius * w, entering - radius
    both, lever, twice = first * other, -(entering * other + radius * first), 2.0 * entering * radius
    g, ga, gb = S * S, 2.0 * S * d * a, 2.0 * S * d * b
    gaa, gbb = 2.0 * (d * d * a * a + S * (d + a * a * dd)), 2.0 * (d * d * b * b + S * (d + b * b * dd))
    gab = 2.0 * a * b * (d * d + S * dd)
    ma, mb = lever * c, -lever * s
    length = math.sqrt(step * step + g * both)
    la, lb = 0.5 * (ga * both + g * ma) / length, 0.5 * (gb * both + g * mb) / length
    aa = (0.5 * (gaa * both + 2.0 * ga * ma + g * twice * c * c) - la * la) / length
    bb = (0.5 * (gbb * both + 2.0 * gb * mb + g * twice * s * s) - lb * lb) / length
    ab = (0.5 * (gab * both + ga * mb + gb * ma - g * twice * c * s) - la * lb) / length
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
def through_section(law: NDArray, alpha: float, beta: float, entering: float, radius: float, c: float, s: float) -> Any:
    """Length (m) as of `SectionKind.cables`, and its derivatives by α, β, by α twice, by β twice, and by both.

    Parameters
    ----------
    law : (6,)
        A `CableLaw`.
    alpha, beta : rad
        Of the section.
    entering, radius, c, s
        Circle (m) from which the cable comes, that of its holes here, cosine and sine of their azimuth.
    """
    before, after, offset, arc, parts = law[0], law[1], law[2], law[4], law[3]
    if arc != 0.0:
        parts = law[5]
        length, la, lb, aa, bb, ab = _beside_arc(alpha, beta, arc, parts, radius, c, s)
        if parts == 0.0 or entering == radius:
            return length, la, lb, aa, bb, ab
        part = arc / parts
        first, fa, fb, faa, fbb, fab = between_circles(alpha / parts, beta / parts, part, entering, radius, c, s)
        rest = (parts - 1.0) / parts
        length, la, lb = rest * length + first - part, rest * la + fa / parts, rest * lb + fb / parts
        squared = parts * parts
        return length, la, lb, rest * aa + faa / squared, rest * bb + fbb / squared, rest * ab + fab / squared
    a, b = alpha / parts, beta / parts
    if offset != 0.0:
        length, la, lb, aa, bb, ab = at_joint(a, b, before, after, offset, radius, radius, c, s)
    else:
        ca, sa, cb, sb = math.cos(a), math.sin(a), math.cos(b), math.sin(b)
        length, la, lb = through_joint(ca, sa, cb, sb, before, after, radius, c, s)
        aa, bb, ab = curvature(ca, sa, cb, sb, before, after, radius, c, s, length, la, lb)
    straight = (parts - 1.0) * (before + after) + parts * offset
    if entering == radius:
        return parts * length - straight, la, lb, aa / parts, bb / parts, ab / parts
    first, fa, fb, faa, fbb, fab = at_joint(a, b, before, after, offset, entering, radius, c, s)
    rest, squared = parts - 1.0, parts * parts
    length, la, lb = rest * length + first - straight, (rest * la + fa) / parts, (rest * lb + fb) / parts
    return length, la, lb, (rest * aa + faa) / squared, (rest * bb + fbb) / squared, (rest * ab + fab) / squared
