"""Which joint angles belong to given cable lengths: the inverse of `hognose.robot.cables`.

A section has three cables or more and only two angles, so not every set of lengths fits exactly. The angles are defined
section by section from the base: those of a section make the sum of squares of what its own cables differ by smallest,
with the joints before it where they are. Derivation and meaning: `docs/certificate.md`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.robot.joint_cable import through_joint

#: Newton's method ends where it moves an angle by less (rad) …
_STILL = 1e-10
#: … and gives up after so many steps.
_MOST_STEPS = 100


@kernel()
def _angles(
    lengths: NDArray,
    angles: NDArray,
    before: NDArray,
    after: NDArray,
    first_cable: NDArray,
    radius: NDArray,
    cosine: NDArray,
    sine: NDArray,
    straight: NDArray,
    left: NDArray,
) -> int:
    """Improve angles (T, n, 2) until they are those of lengths (T, c). Returns how many steps there are none for.

    Those have angles that are no numbers.
    """
    cables, sections, lost = radius.size, before.size, 0
    for t in range(lengths.shape[0]):
        for k in range(cables):
            left[k] = lengths[t, k] - straight[k]
        for i in range(sections):
            alpha, beta = angles[t, i, 0], angles[t, i, 1]
            low, high = first_cable[i], first_cable[i + 1]
            h1, h2 = before[i], after[i]
            found = False
            ca, sa, cb, sb = math.cos(alpha), math.sin(alpha), math.cos(beta), math.sin(beta)
            for _ in range(_MOST_STEPS):
                aa, ab, bb, a, b = 0.0, 0.0, 0.0, 0.0, 0.0
                for k in range(low, high):
                    length, by_alpha, by_beta = through_joint(ca, sa, cb, sb, h1, h2, radius[k], cosine[k], sine[k])
                    off = left[k] - length
                    aa, ab, bb = aa + by_alpha * by_alpha, ab + by_alpha * by_beta, bb + by_beta * by_beta
                    a, b = a + by_alpha * off, b + by_beta * off
                determinant = aa * bb - ab * ab
                if not determinant > 1e-9 * (aa + bb) * (aa + bb):
                    break
                step_a, step_b = (bb * a - ab * b) / determinant, (aa * b - ab * a) / determinant
                alpha, beta = alpha + step_a, beta + step_b
                ca, sa, cb, sb = math.cos(alpha), math.sin(alpha), math.cos(beta), math.sin(beta)
                size = math.sqrt(step_a * step_a + step_b * step_b)
                if size < _STILL:
                    found = True
                    break
            if not found:
                alpha, beta, lost = math.nan, math.nan, lost + 1
                for j in range(i, sections):
                    angles[t, j, 0], angles[t, j, 1] = alpha, beta
                break
            angles[t, i, 0], angles[t, i, 1] = alpha, beta
            for k in range(high, cables):
                left[k] -= through_joint(ca, sa, cb, sb, h1, h2, radius[k], cosine[k], sine[k])[0]
    return lost


def angles_of(
    lengths: NDArray[np.float64],
    near: NDArray[np.float64],
    before: NDArray[np.float64],
    after: NDArray[np.float64],
    first_cable: NDArray[np.int64],
    radius: NDArray[np.float64],
    azimuth: NDArray[np.float64],
    straight: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Angles (T, n, 2) rad of cable lengths (T, c) m, found from angles nearby; NaN for a step where there are none.

    Parameters
    ----------
    lengths : (T, c) m
    near : (T, n, 2) rad
    before, after : (n,) m
    first_cable : (n + 1,)
        The own cables of section i are first_cable[i] to first_cable[i + 1] - 1.
    radius, azimuth, straight : (c,)
    """
    out = np.array(near, dtype=np.float64, order="C")
    lengths = np.ascontiguousarray(lengths)
    _angles(
        lengths,
        out,
        before,
        after,
        first_cable,
        radius,
        np.cos(azimuth),
        np.sin(azimuth),
        straight,
        np.empty(radius.size),
    )
    return out
