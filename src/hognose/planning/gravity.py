"""Gravity as a task file says it."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import AfterValidator

from hognose.units import Number

#: Gravity (m/s²) unless a task says otherwise: its y points up.
DOWN = (0.0, -9.80665, 0.0)
#: Weaker or stronger gravity (m/s²) is in another unit, unless there is none.
WEAKEST, STRONGEST = 0.01, 100.0


def _is_gravity(vector: tuple[float, float, float]) -> tuple[float, float, float]:
    size = math.hypot(*vector)
    if size and not WEAKEST <= size <= STRONGEST:
        raise ValueError(f"is {size:.4g} m/s² strong, expected 0 or {WEAKEST:g} to {STRONGEST:g}: is it in m/s²?")
    return vector


#: Acceleration of gravity, m/s², in the frame of the task.
Gravity = Annotated[tuple[Number, Number, Number], AfterValidator(_is_gravity)]
