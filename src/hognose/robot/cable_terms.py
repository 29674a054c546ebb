"""How the lengths of cables change with a section's angles, and a bound of how that changes: of the third derivative.

Of links whose cables keep their circles by the formulas of one joint, `hognose.robot.joint_cable`, and of all others by
those of `hognose.robot.section_cable`. What the bound follows from: `docs/certificate.md`.
"""

from __future__ import annotations

import math

from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.robot.joint_cable import curvature, through_joint
from hognose.robot.section_cable import at_joint, between_circles, through_section

#: Second and third derivative of R_y(α) R_x(β) q along a line of unit speed are at most so large, for |q| = 1.
_SECOND, _THIRD = 1.5, 2.885
#: The greatest value of x (1 - x²) from 0 to 1.
_MIXED = 2.0 / (3.0 * math.sqrt(3.0))
#: Entries of what `terms` finds: the derivatives by α, β, α twice, β twice and both, and the bound of the third.
BY_ALPHA, BY_BETA, ALPHA_TWICE, BETA_TWICE, BOTH, THIRD, ENTRIES = 0, 1, 2, 3, 4, 5, 6


@kernel(inline="always")
def _third(length: float, arm: float, reach: float, second: float, third: float) -> float:
    """A bound of |f‴| of f = |p|, |p′| ≤ arm, |p″| ≤ second · arm, |p‴| ≤ third · arm; infinite if f may vanish."""
    shortest = length - arm * reach
    if not shortest > 0.0:
        return math.inf
    ratio = arm / shortest
    return arm * (third + 3.0 * second * ratio + 3.0 * _MIXED * ratio * ratio)


@kernel()
def _largest_third(
    law: NDArray, alpha: float, beta: float, entering: float, radius: float, c: float, s: float, reach: float
) -> float:
    """The bound of a section's third derivative, the sum of those of its parts; infinite where one may vanish."""
    if law[4] != 0.0:
        parts = law[5]
        if parts == 0.0:
            return 0.0
        a, b, near, part = alpha / parts, beta / parts, reach / parts, law[4] / parts
        other = (part + radius * (math.sqrt(a * a + b * b) + near)) / 32.0 + 0.25 * radius
        if entering == radius:
            return other / (parts * parts)
        length = between_circles(a, b, part, entering, radius, c, s)[0]
        first = _third(length, radius + 0.5 * part, near, 1.0, 1.0)
        return ((parts - 1.0) * other + first) / (parts * parts * parts)
    before, after, offset, parts = law[0], law[1], law[2], law[3]
    a, b, near, arm = alpha / parts, beta / parts, reach / parts, math.sqrt(radius * radius + after * after) + offset
    first = _third(at_joint(a, b, before, after, offset, entering, radius, c, s)[0], arm, near, _SECOND, _THIRD)
    if parts == 1.0:
        return first
    other = _third(at_joint(a, b, before, after, offset, radius, radius, c, s)[0], arm, near, _SECOND, _THIRD)
    return ((parts - 1.0) * other + first) / (parts * parts * parts)


@kernel(fastmath={"contract"})
def terms(
    plain: bool, trig: NDArray, angles: NDArray, joint: NDArray, hole: NDArray, law: NDArray, entering: float,
    radius: float, reach: float, out: NDArray,
) -> None:  # fmt: skip
    """Derivatives of the length of one cable in one section, and a bound of the third within `reach` (rad).

    Parameters
    ----------
    plain
        Whether the section is a link, and the cable keeps its circle: for these, the formulas of one joint.
    trig : (4,)
        Cosine and sine of α and of β.
    angles : (2,) rad
    joint : (2,) m
        h₁ and h₂.
    hole : (3,)
        Radius (m), cosine and sine of the cable.
    law : (6,)
        A row of `Robot.cable_laws`.
    entering, radius : m
        The circles in the section before and in this one.
    reach : rad
    out : (ENTRIES,)
        Derivatives by the section's angles; the bound is infinite where the cable may have no length.
    """
    if not plain:
        cable = (entering, radius, hole[1], hole[2])
        _, ga, gb, aa, bb, ab = through_section(law, angles[0], angles[1], *cable)
        out[BY_ALPHA], out[BY_BETA] = ga, gb
        out[ALPHA_TWICE], out[BETA_TWICE], out[BOTH] = aa, bb, ab
        out[THIRD] = _largest_third(law, angles[0], angles[1], *cable, reach)
        return
    ca, sa, cb, sb, h1, h2 = trig[0], trig[1], trig[2], trig[3], joint[0], joint[1]
    r, c, s = hole[0], hole[1], hole[2]
    length, ga, gb = through_joint(ca, sa, cb, sb, h1, h2, r, c, s)
    aa, bb, ab = curvature(ca, sa, cb, sb, h1, h2, r, c, s, length, ga, gb)
    out[BY_ALPHA], out[BY_BETA] = ga, gb
    out[ALPHA_TWICE], out[BETA_TWICE], out[BOTH] = aa, bb, ab
    out[THIRD] = _third(length, math.sqrt(r * r + h2 * h2), reach, _SECOND, _THIRD)
