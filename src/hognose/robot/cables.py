"""Exact lengths of cables that run through the disks of many universal joints.

A cable at azimuth φ on a circle of radius r leaves one link through a hole h₁ before the joint centre and
enters the next through a hole h₂ after it. The distance of the two holes (derivation: `docs/kinematics.md`) is

    ℓ² = 2r² + h₁² + h₂² - 2[ r²(c²φ cα + cφ sφ sα sβ + s²φ cβ) + h₂ r(cφ sα cβ - sφ sβ)
                              - h₁ r(-sα cφ + cα sβ sφ) - h₁ h₂ cα cβ ].

A cable of section i passes joints 1…i, so every angle before its own section changes its length too.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel


@kernel(fastmath={"contract"})
def _lengths(
    angles: NDArray,
    before: NDArray,
    after: NDArray,
    first_cable: NDArray,
    radius: NDArray,
    cos_azimuth: NDArray,
    sin_azimuth: NDArray,
    straight: NDArray,
    out: NDArray,
) -> None:
    """Cables are sorted by section: cables first_cable[j]… pass joint j."""
    cables = out.shape[1]
    for t in range(angles.shape[0]):
        for k in range(cables):
            out[t, k] = straight[k]
        for j in range(angles.shape[1]):
            ca, sa = math.cos(angles[t, j, 0]), math.sin(angles[t, j, 0])
            cb, sb = math.cos(angles[t, j, 1]), math.sin(angles[t, j, 1])
            h1, h2 = before[j], after[j]
            constant = h1 * h1 + h2 * h2 + 2.0 * h1 * h2 * ca * cb
            along_cos = 2.0 * (h1 + h2 * cb) * sa
            along_sin = 2.0 * (h2 + h1 * ca) * sb
            cc, ss, cs = 2.0 * (1.0 - ca), 2.0 * (1.0 - cb), 2.0 * sa * sb
            passing = first_cable[j]
            # Slices, so that the compiler sees indices from 0 up and works on several cables at once.
            cosines, sines, radii = cos_azimuth[passing:], sin_azimuth[passing:], radius[passing:]
            lengths = out[t, passing:]
            for k in range(lengths.size):
                c, s, r = cosines[k], sines[k], radii[k]
                squared = constant + r * (r * (cc * c * c + ss * s * s - cs * c * s) - along_cos * c + along_sin * s)
                lengths[k] += math.sqrt(squared)


def lengths_of(
    angles: NDArray[np.float64],
    before: NDArray[np.float64],
    after: NDArray[np.float64],
    first_cable: NDArray[np.int64],
    radius: NDArray[np.float64],
    azimuth: NDArray[np.float64],
    straight: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Cable lengths (T, c) m of angles (T, n, 2) rad."""
    out = np.empty((angles.shape[0], radius.size))
    _lengths(angles, before, after, first_cable, radius, np.cos(azimuth), np.sin(azimuth), straight, out)
    return out
