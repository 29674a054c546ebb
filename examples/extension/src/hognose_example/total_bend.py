"""A check: the sum of all bends, which determines the friction of the cables.

A cable that passes bends with the sum θ loses the part 1 - e^(-μθ) of its tension to friction (Euler and Eytelwein).
For half a turn and μ = 0.1 that is a quarter.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hognose.planning.checks import Check, Criterion, Shared, most
from hognose.planning.motion import Motion

#: rad
MOST_BEND = math.pi


def bends(motion: Motion) -> NDArray[np.float64]:
    """The sum of the bends of all joints, (T,) rad."""
    return np.arccos(np.cos(motion.angles).prod(axis=-1)).sum(axis=-1)


def total_bend(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The bends of all joints add up to at most half a turn, which limits the friction of the cables."""
    found = bends(motion)
    step = int(found.argmax())
    yield most(found[step], MOST_BEND, step=step)


TOTAL_BEND = Criterion("total_bend", "total bend", "rad", total_bend)
