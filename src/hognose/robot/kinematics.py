"""The kinematics of a chain of universal joints: paper eqs. 13–16 and table 1.

Joint i stands at the end of link i - 1 and turns link i by R_y(α_i) R_x(β_i); all links lie along +z at
rest, and the first joint slides along +z by the feed. With every twist axis of table 1 crossing the z axis,
the product of exponentials (eq. 13) is the chain of these rotations, each followed by a shift along the link.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.kernels import kernel


@kernel(inline="always")
def turned(
    xx: float,
    xy: float,
    xz: float,
    yx: float,
    yy: float,
    yz: float,
    zx: float,
    zy: float,
    zz: float,
    alpha: float,
    beta: float,
) -> Any:
    """The axes of a link's frame after R_y(α) R_x(β); α turns about the old y axis, β about the new x axis."""
    ca, sa, cb, sb = math.cos(alpha), math.sin(alpha), math.cos(beta), math.sin(beta)
    ux, uy, uz = sa * xx + ca * zx, sa * xy + ca * zy, sa * xz + ca * zz
    xx, xy, xz = ca * xx - sa * zx, ca * xy - sa * zy, ca * xz - sa * zz
    zx, zy, zz = cb * ux - sb * yx, cb * uy - sb * yy, cb * uz - sb * yz
    return xx, xy, xz, cb * yx + sb * ux, cb * yy + sb * uy, cb * yz + sb * uz, zx, zy, zz


@kernel(fastmath={"contract"})
def _angles(joints: NDArray, out: NDArray) -> tuple[int, int]:
    """Inverse resolution (eqs. 14–16) of (T, n+1, 3) joint positions, quadrant-safe.

    Returns the step and the link where two joints coincide to a nanometre, or (-1, -1).
    """
    for t in range(joints.shape[0]):
        xx, xy, xz = 1.0, 0.0, 0.0
        yx, yy, yz = 0.0, 1.0, 0.0
        zx, zy, zz = 0.0, 0.0, 1.0
        for i in range(out.shape[1]):
            dx = joints[t, i + 1, 0] - joints[t, i, 0]
            dy = joints[t, i + 1, 1] - joints[t, i, 1]
            dz = joints[t, i + 1, 2] - joints[t, i, 2]
            squared = dx * dx + dy * dy + dz * dz
            if squared < 1e-18:
                return t, i
            scale = 1.0 / math.sqrt(squared)
            dx, dy, dz = dx * scale, dy * scale, dz * scale
            x = dx * xx + dy * xy + dz * xz
            y = dx * yx + dy * yy + dz * yz
            z = dx * zx + dy * zy + dz * zz
            cos_beta = math.sqrt(x * x + z * z)
            out[t, i, 0] = math.atan2(x, z)
            out[t, i, 1] = math.atan2(-y, cos_beta)
            cos_alpha, sin_alpha = 1.0, 0.0
            if cos_beta > 0.0:
                per_cos = 1.0 / cos_beta
                cos_alpha, sin_alpha = z * per_cos, x * per_cos
            xx, xy, xz = (
                cos_alpha * xx - sin_alpha * zx,
                cos_alpha * xy - sin_alpha * zy,
                cos_alpha * xz - sin_alpha * zz,
            )
            zx, zy, zz = dx, dy, dz
            yx, yy, yz = zy * xz - zz * xy, zz * xx - zx * xz, zx * xy - zy * xx
    return -1, -1


@kernel(fastmath={"contract"})
def _positions(angles: NDArray, feeds: NDArray, lengths: NDArray, joints: NDArray, frames: NDArray) -> None:
    """Eq. 13 up to every joint: (T, n+1, 3) positions and the (T, 3, 3) orientation of the last link."""
    for t in range(angles.shape[0]):
        xx, xy, xz = 1.0, 0.0, 0.0
        yx, yy, yz = 0.0, 1.0, 0.0
        zx, zy, zz = 0.0, 0.0, 1.0
        px, py, pz = 0.0, 0.0, feeds[t]
        joints[t, 0, 0], joints[t, 0, 1], joints[t, 0, 2] = px, py, pz
        for i in range(angles.shape[1]):
            alpha, beta = angles[t, i, 0], angles[t, i, 1]
            xx, xy, xz, yx, yy, yz, zx, zy, zz = turned(xx, xy, xz, yx, yy, yz, zx, zy, zz, alpha, beta)
            px, py, pz = px + lengths[i] * zx, py + lengths[i] * zy, pz + lengths[i] * zz
            joints[t, i + 1, 0], joints[t, i + 1, 1], joints[t, i + 1, 2] = px, py, pz
        frames[t, 0, 0], frames[t, 1, 0], frames[t, 2, 0] = xx, xy, xz
        frames[t, 0, 1], frames[t, 1, 1], frames[t, 2, 1] = yx, yy, yz
        frames[t, 0, 2], frames[t, 1, 2], frames[t, 2, 2] = zx, zy, zz


@kernel(fastmath={"contract"})
def _axes(angles: NDArray, out: NDArray) -> None:
    """Axes (T, n, 2, 3) of α and β, in the arm's own frame."""
    for t in range(angles.shape[0]):
        xx, xy, xz, yx, yy, yz, zx, zy, zz = 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0
        for i in range(angles.shape[1]):
            alpha, beta = angles[t, i, 0], angles[t, i, 1]
            out[t, i, 0, 0], out[t, i, 0, 1], out[t, i, 0, 2] = yx, yy, yz
            xx, xy, xz, yx, yy, yz, zx, zy, zz = turned(xx, xy, xz, yx, yy, yz, zx, zy, zz, alpha, beta)
            out[t, i, 1, 0], out[t, i, 1, 1], out[t, i, 1, 2] = xx, xy, xz


def angles_of(joints: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles (T, n, 2) rad of joint positions (T, n+1, 3) m."""
    out = np.empty((joints.shape[0], joints.shape[1] - 1, 2))
    step, link = _angles(joints, out)
    if step >= 0:
        raise InputError(f"joints: both ends of link {link + 1} are the same point at step {step}; it has no direction")
    return out


def positions_of(
    angles: NDArray[np.float64], feeds: NDArray[np.float64], lengths: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Joint positions (T, n+1, 3) m and tip orientations (T, 3, 3) of angles (T, n, 2) rad."""
    joints = np.empty((angles.shape[0], angles.shape[1] + 1, 3))
    frames = np.empty((angles.shape[0], 3, 3))
    _positions(angles, feeds, lengths, joints, frames)
    return joints, frames


def axes_of_joints(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vectors (T, n, 2, 3), in the arm's own frame, about which angles (T, n, 2) rad turn what is behind them."""
    out = np.empty((*angles.shape, 3))
    _axes(np.ascontiguousarray(angles), out)
    return out
