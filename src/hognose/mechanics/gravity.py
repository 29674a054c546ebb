"""The weight of the arm: potential energy, its derivative by the joint angles, and its second derivative.

With S_j = Σ_{i≥j} m_i (p_i - o_j), the first moment of all that hangs on joint j about its centre, and a unit axis a of
that joint, the energy U = -Σ m_i g·p_i has the derivatives

    ∂U/∂q_a = -g · (a × S_j),      ∂²U/∂q_a∂q_b = -(g × a) · (b × S_b)   for a nearer the base than b, or a = b .

α turns about the y axis of the link before, β about the x axis of its own link.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.robot.kinematics import turned

Array = NDArray[np.float64]


@kernel(inline="always")
def _moment_on(a: NDArray, i: int, sx: float, sy: float, sz: float) -> tuple[float, float, float]:
    """Axis i of (2n, 3) across a first moment."""
    return a[i, 1] * sz - a[i, 2] * sy, a[i, 2] * sx - a[i, 0] * sz, a[i, 0] * sy - a[i, 1] * sx


@kernel(fastmath={"contract"})
def gravity_at(
    angles: NDArray, links: NDArray, tool: float, gravity: NDArray, axes: NDArray, torque: NDArray, hessian: NDArray
) -> float:
    """Add dU/dq (2n,) and d²U/dq² (2n, 2n) of one pose; returns U (J), with the first joint at height 0.

    Links are (n, 3), the tool load is at the end of the last one; axes (2n, 6) is room to work in.
    """
    n = links.shape[0]
    gx, gy, gz = gravity[0], gravity[1], gravity[2]
    xx, xy, xz = 1.0, 0.0, 0.0
    yx, yy, yz = 0.0, 1.0, 0.0
    zx, zy, zz = 0.0, 0.0, 1.0
    for j in range(n):
        axes[2 * j, 0], axes[2 * j, 1], axes[2 * j, 2] = yx, yy, yz
        xx, xy, xz, yx, yy, yz, zx, zy, zz = turned(xx, xy, xz, yx, yy, yz, zx, zy, zz, angles[j, 0], angles[j, 1])
        axes[2 * j + 1, 0], axes[2 * j + 1, 1], axes[2 * j + 1, 2] = xx, xy, xz
        axes[2 * j, 3], axes[2 * j, 4], axes[2 * j, 5] = zx, zy, zz
    mass, sx, sy, sz = tool, 0.0, 0.0, 0.0
    for j in range(n - 1, -1, -1):
        zx, zy, zz = axes[2 * j, 3], axes[2 * j, 4], axes[2 * j, 5]
        along = mass * links[j, 0] + links[j, 1] * links[j, 2]
        mass += links[j, 1]
        sx, sy, sz = sx + along * zx, sy + along * zy, sz + along * zz
        for i in (2 * j, 2 * j + 1):
            mx, my, mz = _moment_on(axes, i, sx, sy, sz)
            torque[i] -= gx * mx + gy * my + gz * mz
            axes[i, 3], axes[i, 4], axes[i, 5] = mx, my, mz
    for i in range(2 * n):
        ax, ay = gy * axes[i, 2] - gz * axes[i, 1], gz * axes[i, 0] - gx * axes[i, 2]
        az = gx * axes[i, 1] - gy * axes[i, 0]
        for k in range(i, 2 * n):
            value = ax * axes[k, 3] + ay * axes[k, 4] + az * axes[k, 5]
            hessian[i, k] -= value
            if k > i:
                hessian[k, i] -= value
    return -(gx * sx + gy * sy + gz * sz)


@kernel()
def _gravity(
    angles: NDArray, links: NDArray, tool: float, gravity: NDArray, torques: NDArray, hessians: NDArray
) -> None:
    axes = np.empty((torques.shape[1], 6))
    for t in range(angles.shape[0]):
        gravity_at(angles[t], links, tool, gravity[t], axes, torques[t], hessians[t])


def gravity_of(angles: Array, links: Array, tool: float, gravity: Array) -> tuple[Array, Array]:
    """Torques dU/dq (T, 2n) N m with which the joints hold the weight, and their derivatives (T, 2n, 2n) N m/rad.

    Parameters
    ----------
    angles : (T, n, 2) rad
    links : (n, 3)
        Length (m), mass (kg), and distance (m) of the centre of mass from the joint.
    tool : kg
        Load at the end of the last link.
    gravity : (T, 3) m/s²
        In the arm's own axes.
    """
    size = 2 * len(links)
    torques, hessians = np.zeros((len(angles), size)), np.zeros((len(angles), size, size))
    _gravity(angles, links, tool, gravity, torques, hessians)
    return torques, hessians
