"""One cable through one universal joint: its length, and how that changes with the joint's angles."""

from __future__ import annotations

import math
from typing import Any

from hognose.kernels import kernel


@kernel(inline="always")
def through_joint(
    ca: float, sa: float, cb: float, sb: float, before: float, after: float, radius: float, c: float, s: float
) -> Any:
    """Length (m) between the hole planes of a joint, and its first derivatives by α and β.

    The formula is that of `hognose.robot.cables`, for a cable at an azimuth with cosine c and sine s, through a joint
    whose angles have the cosines and sines ca, sa, cb, sb.
    """
    hh, rh, rr = before * after, radius, radius * radius
    squared = (
        before * before
        + after * after
        + 2.0 * hh * ca * cb
        + 2.0 * rr * ((1.0 - ca) * c * c + (1.0 - cb) * s * s - sa * sb * c * s)
        + 2.0 * rh * ((after + before * ca) * sb * s - (before + after * cb) * sa * c)
    )
    by_alpha = (
        rr * (sa * c * c - ca * sb * c * s)
        - hh * sa * cb
        - rh * ((before + after * cb) * ca * c + before * sa * sb * s)
    )
    by_beta = (
        rr * (sb * s * s - sa * cb * c * s) - hh * ca * sb + rh * (after * sb * sa * c + (after + before * ca) * cb * s)
    )
    length = math.sqrt(squared)
    return length, by_alpha / length, by_beta / length


@kernel(inline="always")
def curvature_through_joint(
    ca: float,
    sa: float,
    cb: float,
    sb: float,
    before: float,
    after: float,
    radius: float,
    c: float,
    s: float,
    length: float,
    by_alpha: float,
    by_beta: float,
) -> float:
    """Frobenius norm (m) of the second derivatives of that length, of which the length and its slopes are given."""
    hh, rh, rr = before * after, radius, radius * radius
    twice_alpha = (
        rr * (ca * c * c + sa * sb * c * s)
        - hh * ca * cb
        + rh * ((before + after * cb) * sa * c - before * ca * sb * s)
    )
    twice_beta = (
        rr * (cb * s * s + sa * sb * c * s) - hh * ca * cb + rh * (after * cb * sa * c - (after + before * ca) * sb * s)
    )
    mixed = hh * sa * sb - rr * ca * cb * c * s + rh * (after * sb * ca * c - before * sa * cb * s)
    aa, bb, ab = twice_alpha - by_alpha * by_alpha, twice_beta - by_beta * by_beta, mixed - by_alpha * by_beta
    return math.sqrt(aa * aa + bb * bb + 2.0 * ab * ab) / length
