"""How joint angles change with cable lengths: the derivative of `Robot.angles_from_cables`.

The angles of a section follow from its own cables, with the joints before it where they are. With J_ij the derivative
of the lengths that section i's cables have in joint j, and P_i = (J_iiᵀ J_ii)⁻¹ J_iiᵀ, changes dλ of the lengths turn
it by

    dθ_i = P_i (dλ_i - Σ_{j<i} J_ij dθ_j) .

The lengths are taken to fit the angles, as those of `Robot.cable_lengths` do.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.robot.cable_terms import BY_ALPHA, BY_BETA, ENTRIES, terms
from hognose.robot.robot import Robot

Array = NDArray[np.float64]


@kernel(fastmath={"contract"})
def _gains(
    angles: NDArray, plain: bool, joints: NDArray, first: NDArray, holes: NDArray, laws: NDArray, circles: NDArray,
    out: NDArray,
) -> None:  # fmt: skip
    """dθ/dλ (T, n, 2, c); the cables are as of `terms`, of all sections and cables; `out` holds zeros.

    NaN from the first section whose own cables do not determine its angles.
    """
    sections, cables = joints.shape[0], holes.shape[0]
    left, slopes, trig = np.empty(cables), np.empty((cables, sections, 2)), np.empty((sections, 4))
    found = np.empty(ENTRIES)
    for t in range(angles.shape[0]):
        for i in range(sections):
            alpha, beta = angles[t, i, 0], angles[t, i, 1]
            trig[i, 0], trig[i, 1] = math.cos(alpha), math.sin(alpha)
            trig[i, 2], trig[i, 3] = math.cos(beta), math.sin(beta)
            low, high = first[i], first[i + 1]
            aa, ab, bb = 0.0, 0.0, 0.0
            for k in range(low, high):
                for j in range(i + 1):
                    terms(
                        plain, trig[j], angles[t, j], joints[j], holes[k], laws[j], circles[k, j],
                        circles[k, j + 1], 0.0, found,
                    )  # fmt: skip
                    slopes[k, j, 0], slopes[k, j, 1] = found[BY_ALPHA], found[BY_BETA]
                ga, gb = slopes[k, i, 0], slopes[k, i, 1]
                aa, ab, bb = aa + ga * ga, ab + ga * gb, bb + gb * gb
            determinant = aa * bb - ab * ab
            if not determinant > 1e-9 * (aa + bb) * (aa + bb):
                out[t, i:] = math.nan
                break
            for k in range(low, high):
                left[:high] = 0.0
                left[k] = 1.0
                for j in range(i):
                    ga, gb = slopes[k, j, 0], slopes[k, j, 1]
                    for m in range(first[j + 1]):
                        left[m] -= ga * out[t, j, 0, m] + gb * out[t, j, 1, m]
                ga, gb = slopes[k, i, 0], slopes[k, i, 1]
                pa, pb = (bb * ga - ab * gb) / determinant, (aa * gb - ab * ga) / determinant
                for m in range(high):
                    out[t, i, 0, m] += pa * left[m]
                    out[t, i, 1, m] += pb * left[m]


def angles_per_length(robot: Robot, angles: Array) -> Array:
    """Changes (T, n, 2, c) rad/m of the joint angles with every cable's length, at angles (T, n, 2) rad.

    NaN from the first section whose own cables do not determine its angles.
    """
    out = np.zeros((len(angles), robot.sections, 2, robot.cables))
    cables = (robot.plain_cables, robot.hole_planes, robot.first_cables, robot.cable_holes)
    _gains(np.ascontiguousarray(angles), *cables, robot.cable_laws, robot.cable_circles, out)
    return out
