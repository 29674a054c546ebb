"""How far joints of an arm whose cables are off can leave straight lines between two set-points."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.planning.tolerance.jacobian import changes
from hognose.robot import Robot
from hognose.robot.base import Base

Array = NDArray[np.float64]


@kernel(fastmath={"contract"})
def _growth(
    turns: NDArray, lengths: NDArray, spins: NDArray, swings: NDArray, grown: NDArray, tilted: NDArray, out: NDArray
) -> None:
    """How much (m, n+1) m the bound of each joint's bulge grows, by the recursion of `RigidLink.bulges`.

    `turns` (m, n, 4) are as of `_turns`. Errors change how joints turn in a step by up to `grown` (m, n) rad, and turn
    the link behind each joint by up to `tilted` (m, n) rad more than the one before it.
    """
    for m in range(out.shape[0]):
        out[m, 0] = 0.0
        slack, tilt = 0.0, 0.0
        before, after, gathered, more = swings[m], swings[m], 0.0, 0.0
        speed = math.sqrt(spins[m, 0] ** 2 + spins[m, 1] ** 2 + spins[m, 2] ** 2)
        faster = speed
        for i in range(lengths.size):
            spin, product, sum_, size = turns[m, i, 0], turns[m, i, 1], turns[m, i, 2], turns[m, i, 3]
            u = grown[m, i]
            tilt += tilted[m, i]
            gathered += speed * size + product
            more += faster * (size + u) + product + u * (sum_ + u)
            slack += 1.4142135623730951 * u + sum_ * tilt
            speed, faster = spin + gathered, spin + slack + more
            before += lengths[i] * (gathered + speed * speed)
            after += lengths[i] * (more + faster * faster)
            out[m, i + 1] = (after - before) / 8.0


@kernel(fastmath={"contract"})
def _turns(low: NDArray, high: NDArray, axes: NDArray, spins: NDArray, out: NDArray) -> None:
    """Of each link (m, n, 4) the size of its spin, and |α β|, |α| + |β| and √(α² + β²) of how its joint turns."""
    for m in range(out.shape[0]):
        x, y, z = spins[m, 0], spins[m, 1], spins[m, 2]
        for i in range(out.shape[1]):
            a, b = high[m, i, 0] - low[m, i, 0], high[m, i, 1] - low[m, i, 1]
            x += a * axes[m, i, 0, 0] + b * axes[m, i, 1, 0]
            y += a * axes[m, i, 0, 1] + b * axes[m, i, 1, 1]
            z += a * axes[m, i, 0, 2] + b * axes[m, i, 1, 2]
            out[m, i, 0] = math.sqrt(x * x + y * y + z * z)
            out[m, i, 1], out[m, i, 2], out[m, i, 3] = abs(a * b), abs(a) + abs(b), math.sqrt(a * a + b * b)


def bulges_of_both(
    robot: Robot, base: Base, at: Array, angles: Array, axes: Array, gains: Array, error: float
) -> tuple[Array, Array]:
    """How far joints (T-1, n+1) m can leave straight lines from each step to the next; how much farther with errors.

    Parameters
    ----------
    robot
    base
    at, angles : (T, k), (T, n, 2) rad
        At the steps; angles go linearly between them, with errors as well.
    axes : (T, n, 2, 3)
        As of `joint_axes`, in the frame of the task.
    gains : (T, n, 2, c) rad/m
        As of `angles_per_length`.
    error : m
        Length of the vector of all cables' errors at most.
    """
    low, high = np.ascontiguousarray(angles[:-1]), np.ascontiguousarray(angles[1:])
    spin, swing = base.spin(at[:-1], at[1:]), base.swing(at[:-1], at[1:])
    bulge = robot.model.bulges(low, high, robot.link_lengths, spin, swing)
    turns, more = np.empty((*low.shape[:2], 4)), np.empty_like(bulge)
    spun = base.turned(spin[:, None], at[:-1])[:, 0]
    _turns(low, high, axes[:-1], spun, turns)
    size = np.sqrt(np.einsum("tjkc,tjkc->tj", gains, gains))
    tilted = math.sqrt(2.0) * error * size[:-1]
    _growth(turns, robot.link_lengths, spun, swing, error * changes(gains), tilted, more)
    return bulge, more
