"""How the lengths of cables change with a section's angles: first and second derivatives, and a bound of the third.

What `hognose.robot.joint_cable` is for one joint and one circle, for sections of all kinds and circles that change. A
cable runs through a section in equal parts, each bent by an equal share of the angles. The first of them begins on the
circle of the section before; see `hognose.robot.sections.kind.Course`. Derivations: `docs/kinematics.md`, and
`docs/certificate.md` for the third derivative.
"""

from __future__ import annotations

import math
from typing import Any

from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.robot.joint_cable import curvature, through_joint
from hognose.robot.sections.chain import arc_terms

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
def _at_joint(
    a: float, b: float, offset: float, h1: float, h2: float, entering: float, radius: float, c: float, s: float
) -> Any:
    """Of a straight part: length, its derivatives by a, b, a twice, b twice and both."""
    ca, sa, cb, sb = math.cos(a), math.sin(a), math.cos(b), math.sin(b)
    x, y = radius * c, radius * s
    m, w = y * cb - h2 * sb, y * sb + h2 * cb
    px, pz = ca * x + sa * (w + offset), ca * (w + offset) - sa * x
    dx, dy, dz = px - entering * c, m - entering * s, pz + h1
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    ga, gb = (dx * pz - dz * px) / length, (dx * sa * m - dy * w + dz * ca * m) / length
    aa = (px * px + pz * pz - dx * px - dz * pz - ga * ga) / length
    bb = (m * m + w * w - dx * sa * w - dy * m - dz * ca * w - gb * gb) / length
    ab = (pz * sa * m - px * ca * m + dx * ca * m - dz * sa * m - ga * gb) / length
    return length, ga, gb, aa, bb, ab


@kernel()
def _along_arc(a: float, b: float, part: float, entering: float, radius: float, c: float, s: float) -> Any:
    """Of a part of an arc between two disks: as of `_at_joint`."""
    t = a * a + b * b
    half, _, _, slope, sine_slope = arc_terms(t)
    # half = (1 - cos θ)/θ² and its derivatives by t = θ²; twice that is S².
    bend = (0.5 * sine_slope - 2.0 * slope) / t if t > 0.1 else 1.0 / 360.0 - t * (1.0 / 6720.0 - t / 302400.0)
    w = a * c - b * s
    first, other = part - entering * w, part - radius * w
    both, lever = first * other, -(entering * other + radius * first)
    g, ga, gb = 2.0 * half, 4.0 * slope * a, 4.0 * slope * b
    gaa, gbb, gab = 8.0 * bend * a * a + 4.0 * slope, 8.0 * bend * b * b + 4.0 * slope, 8.0 * bend * a * b
    ma, mb, twice = lever * c, -lever * s, 2.0 * entering * radius
    step = entering - radius
    length = math.sqrt(step * step + g * both)
    la, lb = 0.5 * (ga * both + g * ma) / length, 0.5 * (gb * both + g * mb) / length
    aa = (0.5 * (gaa * both + 2.0 * ga * ma + g * twice * c * c) - la * la) / length
    bb = (0.5 * (gbb * both + 2.0 * gb * mb + g * twice * s * s) - lb * lb) / length
    ab = (0.5 * (gab * both + ga * mb + gb * ma - g * twice * c * s) - la * lb) / length
    return length, la, lb, aa, bb, ab


@kernel()
def _through(
    course: NDArray, alpha: float, beta: float, entering: float, radius: float, c: float, s: float, reach: float,
    out: NDArray,
) -> None:  # fmt: skip
    """Fill `out` (ENTRIES,) for one cable in one section; the bound holds within `reach` (rad) of the angles."""
    out[:] = 0.0
    count, length, h1, h2 = course[0], course[2], course[3], course[4]
    if count == 0.0:
        out[BY_ALPHA], out[BY_BETA] = -radius * c, radius * s
        return
    a, b, near = alpha / count, beta / count, reach / count
    for part in range(2):
        comes, times = (entering, 1.0) if part == 0 else (radius, count - 1.0)
        if times == 0.0:
            break
        if course[1] == 0.0:
            way, ga, gb, aa, bb, ab = _at_joint(a, b, length, h1, h2, comes, radius, c, s)
            third = _third(way, math.sqrt(radius * radius + h2 * h2) + length, near, _SECOND, _THIRD)
        else:
            way, ga, gb, aa, bb, ab = _along_arc(a, b, length, comes, radius, c, s)
            if comes == radius:
                third = (length + radius * (math.sqrt(a * a + b * b) + near)) / 32.0 + 0.25 * radius
            else:
                third = _third(way, radius + 0.5 * length, near, 1.0, 1.0)
        once, twice = times / count, times / (count * count)
        out[BY_ALPHA], out[BY_BETA] = out[BY_ALPHA] + once * ga, out[BY_BETA] + once * gb
        out[ALPHA_TWICE], out[BETA_TWICE] = out[ALPHA_TWICE] + twice * aa, out[BETA_TWICE] + twice * bb
        out[BOTH], out[THIRD] = out[BOTH] + twice * ab, out[THIRD] + twice / count * third


@kernel(fastmath={"contract"})
def terms(
    plain: bool, trig: NDArray, angles: NDArray, joint: NDArray, hole: NDArray, course: NDArray, entering: float,
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
    course : (5,)
        A row of `Robot.cable_courses`.
    entering, radius : m
        The circles in the section before and in this one.
    reach : rad
    out : (ENTRIES,)
        Derivatives by the section's angles; the bound is infinite where the cable may have no length.
    """
    if not plain:
        _through(course, angles[0], angles[1], entering, radius, hole[1], hole[2], reach, out)
        return
    ca, sa, cb, sb, h1, h2 = trig[0], trig[1], trig[2], trig[3], joint[0], joint[1]
    r, c, s = hole[0], hole[1], hole[2]
    length, ga, gb = through_joint(ca, sa, cb, sb, h1, h2, r, c, s)
    aa, bb, ab = curvature(ca, sa, cb, sb, h1, h2, r, c, s, length, ga, gb)
    out[BY_ALPHA], out[BY_BETA] = ga, gb
    out[ALPHA_TWICE], out[BETA_TWICE], out[BOTH] = aa, bb, ab
    out[THIRD] = _third(length, math.sqrt(r * r + h2 * h2), reach, _SECOND, _THIRD)
