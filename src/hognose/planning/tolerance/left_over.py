"""How far the arm is off although its weight is made up for: by errors of EA and of masses, and by friction.

Commanded lengths make up for the stretch that the robot file says. To first order, an error of all masses by a share s
moves a point p by s u(p), one of EA by -s u(p), and both are spreads. Friction in the holes holds cables back. It is
known only within bounds, and counts as evenly distributed within them (GUM, 4.3.7): a spread of 1/sqrt(3) of the bound.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.mechanics import Held, Mechanics
from hognose.mechanics.sensitivity import turned_by
from hognose.planning.tolerance.jacobian import by_zeros

Array = NDArray[np.float64]

#: The parts that are left over, as keys of the budget.
LEFT_OVER = ("axial_stiffness_percent", "mass_percent", "friction")
#: The standard deviation of what is evenly distributed from -1 to 1.
EVEN = 1.0 / math.sqrt(3.0)


def left_over(
    mechanics: Mechanics,
    shares: tuple[float, float],
    friction: float,
    angles: Array,
    gravity: Array,
    axes: Array,
    joints: Array,
    held: Held | None = None,
) -> dict[str, Array]:
    """Spread (T, n+1) m of all joints and the tip by each part of `LEFT_OVER`.

    Parameters
    ----------
    mechanics
    shares
        Standard deviations of EA and of the masses, as shares of them. That of EA as `Budget.left_over` has it: larger,
        since EA that is too small moves the arm by more than EA that is too large.
    friction
        Coefficient.
    angles : (T, n, 2) rad
        Of a motion; friction of a cable that goes on the same way at a step acts the other way.
    gravity : (T, 3) m/s²
        In the arm's own axes.
    axes : (T, n, 2, 3)
        As of `joint_axes`.
    joints : (T, n+1, 3) m
    held
        Of these angles, if it is known.
    """
    held = mechanics.hold(angles, gravity) if held is None else held
    moved = by_zeros(axes, joints, turned_by(mechanics, angles, held, gravity, friction))
    unit = np.linalg.norm(moved[..., 0], axis=2)
    rubbed = np.zeros_like(unit)
    if friction:
        ways = ways_of(held.commanded_lengths)
        known = np.linalg.norm(np.einsum("tjxk,tk->tjx", moved[..., 1:], -ways), axis=2)
        either = np.linalg.norm(moved[..., 1:], axis=2) * (ways == 0)[:, None, :]
        rubbed = EVEN * (known + either.sum(axis=2))
    return dict(zip(LEFT_OVER, (shares[0] * unit, shares[1] * unit, rubbed), strict=True))


def ways_of(lengths: Array) -> Array:
    """Which way (T, c) cables of lengths (T, c) m move at each step: 1 out, -1 in, 0 either: they stand or turn."""
    if len(lengths) < 2:
        return np.zeros_like(lengths)
    steps = np.sign(np.diff(lengths, axis=0))
    before, after = np.concatenate([steps[:1], steps]), np.concatenate([steps, steps[-1:]])
    return np.where(before == after, before, 0.0)
