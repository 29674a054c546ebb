"""One cable through one universal joint: its length, and how that changes with the joint's angles.

A cable has an azimuth with cosine c and sine s; a joint has angles whose cosines and sines are ca, sa, cb, sb. The
formula of the length is that of `hognose.robot.cables`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel


@kernel(inline="always")
def through_joint(
    ca: float, sa: float, cb: float, sb: float, before: float, after: float, radius: float, c: float, s: float
) -> Any:
    """Length (m) between the hole planes of a joint, and its first derivatives (m) by α and β."""
    hh, rh, rr = before * after, radius, radius * radius
    squared = (
        before * before
        + after * after
        + 2.0 * hh * ca * cb
        + 2.0 * rr * ((1.0 - ca) * c * c + (1.0 - cb) * s * s - sa * sb * c * s)
        + 2.0 * rh * ((after + before * ca) * sb * s - (before + after * cb) * sa * c)
    )
    by_alpha = rr * (sa * c * c - ca * sb * c * s) - hh * sa * cb
    by_alpha -= rh * ((before + after * cb) * ca * c + before * sa * sb * s)
    by_beta = rr * (sb * s * s - sa * cb * c * s) - hh * ca * sb
    by_beta += rh * (after * sb * sa * c + (after + before * ca) * cb * s)
    length = math.sqrt(squared)
    return length, by_alpha / length, by_beta / length


@kernel(inline="always")
def curvature(
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
) -> Any:
    """Second derivatives (m) of that length by α twice, by β twice, and by both, from what `through_joint` found."""
    hh, rh, rr = before * after, radius, radius * radius
    aa = rr * (ca * c * c + sa * sb * c * s) - hh * ca * cb
    aa += rh * ((before + after * cb) * sa * c - before * ca * sb * s)
    bb = rr * (cb * s * s + sa * sb * c * s) - hh * ca * cb
    bb += rh * (after * cb * sa * c - (after + before * ca) * sb * s)
    ab = hh * sa * sb - rr * ca * cb * c * s + rh * (after * sb * ca * c - before * sa * cb * s)
    scale = 1.0 / length
    return scale * (aa - by_alpha * by_alpha), scale * (bb - by_beta * by_beta), scale * (ab - by_alpha * by_beta)


def lengths_through(
    angles: NDArray[np.float64],
    before: float,
    after: float,
    radius: NDArray[np.float64],
    cosine: NDArray[np.float64],
    sine: NDArray[np.float64],
    entering: NDArray[np.float64],
    offset: float = 0.0,
) -> NDArray[np.float64]:
    """Lengths (T, c) m of cables through one joint at angles (T, 2) rad.

    They come from a circle of radius `entering` in the plane before it to one of `radius` in that behind it. The axis
    of β may be an `offset` (m) behind that of α. The others are as of `through_joint`.
    """
    ca, sa = np.cos(angles[:, :1]), np.sin(angles[:, :1])
    cb, sb = np.cos(angles[:, 1:]), np.sin(angles[:, 1:])
    # Place of the hole behind the joint, less that of the hole before it.
    x, y, x_before, y_before = radius * cosine, radius * sine, entering * cosine, entering * sine
    along = y * sb + after * cb + offset
    dx, dy, dz = ca * x + sa * along - x_before, y * cb - after * sb - y_before, ca * along - sa * x + before
    return np.sqrt(dx * dx + dy * dy + dz * dz)
