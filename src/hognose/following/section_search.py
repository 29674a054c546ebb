"""The first point of a path at which a section can end, searched for in strides: where nothing is remembered.

What `sections` and `arc` begin with, and come back to where Newton's method fails.
"""

from __future__ import annotations

import math

from numpy.typing import NDArray

from hognose.following.crossing import OVERRUN, Traced
from hognose.kernels import kernel
from hognose.path.polynomial import evaluate, segment_at
from hognose.robot.sections.chain import towards

#: Pieces (q, 4) and where each section's begin (n+1,); gains (n, 2); lengths (n,) m; λ L (n,) m; 1/k (n,); and which
#: sections (n,) are a single arc whose end is on the path.
Arm = tuple[NDArray, NDArray, NDArray, NDArray, NDArray, NDArray, NDArray]

#: A search begins at this part of a section's length and strides by this part.
_BEGIN, _STRIDE = 0.25, 1 / 24
#: Steps of feed, in the shortest section's lengths, over which angles are carried on.
FARTHEST = 0.25


@kernel(inline="always")
def _dot(frame: NDArray, row: int, x: float, y: float, z: float) -> float:
    return frame[row, 0] * x + frame[row, 1] * y + frame[row, 2] * z


@kernel(fastmath={"contract"})
def _beyond(
    curve: Traced, arm: Arm, i: int, start: NDArray, frame: NDArray, u: float, found: NDArray, work: NDArray
) -> float:
    """How far (m) the path at u is beyond the place to which section i gets in that direction; angles into `found`."""
    breaks, coefficients, _, evaluations = curve
    table, first, gains, _, _, _, _ = arm
    evaluations[0] += 1
    segment = segment_at(breaks, u)
    x, y, z, _, _, _, _, _, _ = evaluate(coefficients, segment, u - breaks[segment])
    x, y, z = x - start[0], y - start[1], z - start[2]
    away = math.sqrt(x * x + y * y + z * z)
    if away < 1e-9:
        return -1.0
    ahead = (_dot(frame, 0, x, y, z), _dot(frame, 1, x, y, z), _dot(frame, 2, x, y, z))
    found[1], found[2], reach = towards(table, first[i], first[i + 1], gains[i], ahead[0], ahead[1], ahead[2], work)
    return -1.0 if math.isnan(reach) else away - reach


@kernel(fastmath={"contract"})
def sought(
    curve: Traced, arm: Arm, i: int, before: float, start: NDArray, frame: NDArray, found: NDArray, work: NDArray
) -> bool:
    """The first u > before at which section i can end on the path, and its angles, into `found`."""
    breaks, _, fastest, _ = curve
    length, end = arm[3][i], breaks[-1]
    low = before + _BEGIN * length / fastest[segment_at(breaks, before)]
    high = low
    while True:
        gap = _beyond(curve, arm, i, start, frame, min(high, end), found, work)
        if gap >= 0.0:
            break
        if high >= end:
            found[0] = end
            return gap >= -OVERRUN
        low = high
        high += _STRIDE * length / fastest[segment_at(breaks, high)]
    high = min(high, end)
    while high - low > 1e-9 * length:
        middle = 0.5 * (low + high)
        if _beyond(curve, arm, i, start, frame, middle, found, work) >= 0.0:
            high = middle
        else:
            low = middle
    _beyond(curve, arm, i, start, frame, high, found, work)
    found[0] = high
    return True
