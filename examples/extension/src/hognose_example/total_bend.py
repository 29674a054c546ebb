"""A check: how far the whole arm bends, for cables run round all of it.

A cable that runs round bends of together θ loses the part 1 - e^(-μθ) of its pull to friction (Euler and Eytelwein).
At half a turn and μ = 0.1 that is a quarter.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from hognose.planning.checks import Check, Criterion, Shared, most
from hognose.planning.motion import Motion

#: rad
MOST_BEND = math.pi


def total_bend(motion: Motion, shared: Shared) -> Iterator[Check]:
    """The bends of all joints add up to half a turn at most, so that friction leaves cables enough of their pull."""
    bends = np.arccos(np.cos(motion.angles).prod(axis=-1)).sum(axis=-1)
    step = int(bends.argmax())
    yield most(bends[step], MOST_BEND, step=step)


TOTAL_BEND = Criterion("total_bend", "total bend", "rad", total_bend)
