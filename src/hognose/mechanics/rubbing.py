"""What friction in the holes does to tensions at the motors, and how much of the load factor it takes, at most.

With friction, the tension of a cable at its motor is another than the mean over its length, which is what a motor that
holds the length keeps. Friction turns the joints a little, too (see `sensitivity`), which changes all tensions. Cables
that go on the same way are known; those that turn or stand rub either way, whichever is worse.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.mechanics.mechanics import Mechanics
from hognose.mechanics.sensitivity import lost_by_friction, turned_by
from hognose.mechanics.states import Held
from hognose.mechanics.stiffness import load_factors

Array = NDArray[np.float64]

#: Poses that are looked at together.
_TOGETHER = 400


def rubbing(mechanics: Mechanics, angles: Array, held: Held, gravity: Array, ways: Array) -> tuple[Array, Array]:
    """By how much (T, c) N tensions at the motors change at most, and 1 / load factor (T,) grows.

    Parameters
    ----------
    mechanics
        With its friction.
    angles : (T, n, 2) rad
    held
        Of these angles.
    gravity : (T, 3) m/s²
        In the arm's own axes.
    ways : (T, c)
        1 where a cable goes out, -1 where it comes in, 0 where it turns or stands.
    """
    tensions, factors = np.zeros_like(held.tensions), np.zeros(len(angles))
    sound = np.flatnonzero(held.is_held & (held.load_factor > 1.0))
    turned = turned_by(mechanics, angles, held, gravity, mechanics.friction)[..., 1:]
    for start in range(0, len(sound), _TOGETHER):
        rows = sound[start : start + _TOGETHER]
        pulls, count = held.tensions[rows], len(rows)
        J = mechanics.cable_jacobian(angles[rows])
        moved = held.spring_constants[rows, :, None] * (J @ turned[rows].reshape(count, J.shape[2], -1))
        known = np.abs(np.einsum("tkc,tc->tk", moved, -ways[rows]))
        either = np.abs(moved) @ (ways[rows] == 0)[..., None]
        share, along = lost_by_friction(mechanics, angles[rows], mechanics.friction)
        tensions[rows] = known + either[..., 0] + pulls * share
        elastic, geometric = mechanics.stiffness(angles[rows], pulls * (1.0 + along), gravity[rows])
        with np.errstate(divide="ignore"):
            factors[rows] = np.maximum(1.0 / load_factors(elastic, geometric) - 1.0 / held.load_factor[rows], 0.0)
    return tensions, factors
