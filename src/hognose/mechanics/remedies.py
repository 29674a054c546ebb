"""What would have to be different for an arm to be held, and not to buckle, in one pose.

Pose and gravity are those of a single step: angles (1, n, 2) rad, gravity (3,) or (1, 3) m/s² in the arm's axes.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hognose.mechanics.mechanics import Mechanics
from hognose.robot.tension import STIFFEST

Array = NDArray[np.float64]

#: Halvings of the interval in which a value is sought: to a millionth of it.
_HALVINGS = 20


def tension_needed(mechanics: Mechanics, angles: Array, gravity: Array) -> float:
    """The least `tension_max` (N) with which cables hold a pose; infinite if none does."""

    def holds(most: float) -> bool:
        return bool(replace(mechanics, tension_max=most).hold(angles, gravity).is_held[0])

    high = 2.0 * mechanics.tension_max
    while not holds(high):
        high *= 2.0
        if high > STIFFEST:
            return math.inf
    low = max(high / 2.0, mechanics.tension_min)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def pretension_allowed(mechanics: Mechanics, angles: Array, gravity: Array, factor: float) -> Array | None:
    """The largest pretensions (c,) N, all lowered alike, with which the load factor of a pose is reached.

    None if it is not even with the least tension.
    """

    def pretension(share: float) -> Array:
        return np.maximum(share * mechanics.pretension, mechanics.tension_min)

    def stands(share: float) -> bool:
        held = replace(mechanics, pretension=pretension(share)).hold(angles, gravity)
        return bool(held.is_held[0] and held.load_factor[0] >= factor)

    low, high = 0.0, 1.0
    if not stands(low):
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stands(middle) else (low, middle)
    return pretension(low)


def softest_section(mechanics: Mechanics, angles: Array, tensions: Array, gravity: Array) -> int:
    """The section (0-based) that turns the most where the arm begins to buckle; tensions are (1, c) N."""
    elastic, geometric = mechanics.stiffness(angles, tensions, gravity)
    try:
        inverse = np.linalg.inv(np.linalg.cholesky(elastic[0]))
    except np.linalg.LinAlgError:  # nothing holds some joint
        turned = np.linalg.eigh(elastic[0])[1][:, 0]
    else:
        turned = inverse.T @ np.linalg.eigh(-inverse @ geometric[0] @ inverse.T)[1][:, -1]
    return int(np.argmax(np.hypot(turned[0::2], turned[1::2])))
