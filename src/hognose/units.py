"""Length units of the files people write, and the validated quantities built on them.

Python values are SI throughout. A file names its length unit once; while it is validated, the context
carries that unit's size and every `Length` is converted on the way in. Without a context (a value made in
Python) lengths are metres already.
"""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationInfo, model_validator

#: Metres in one of each length unit a file may declare.
LENGTH_UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}


#: Lengths and coordinates (m) beyond this are a wrong unit, not a space for a snake arm.
LARGEST_LENGTH = 10_000.0


def _to_metres(value: float, info: ValidationInfo) -> float:
    metres = value * (info.context or {}).get("metres_per_unit", 1.0)
    if abs(metres) > LARGEST_LENGTH:
        raise ValueError(f"{metres:.4g} m is out of range (at most {LARGEST_LENGTH:,.0f} m): is `units` right?")
    return metres


#: Any length: metres in Python, the declared unit in a file.
Length = Annotated[float, Field(allow_inf_nan=False), AfterValidator(_to_metres)]
#: A length greater than zero.
PositiveLength = Annotated[float, Field(gt=0, allow_inf_nan=False), AfterValidator(_to_metres)]
#: A length of zero or more.
NonNegativeLength = Annotated[float, Field(ge=0, allow_inf_nan=False), AfterValidator(_to_metres)]
#: Nothing that is in the way is thinner (m): what is would be lost in rounding.
THINNEST = 1e-9


def _is_a_size(length: float) -> float:
    if length < THINNEST:
        raise ValueError(f"{length:g} m is too small for a part of an obstacle (at least a nanometre)")
    return length


#: A diameter, a thickness or an edge of something in the way.
Size = Annotated[PositiveLength, AfterValidator(_is_a_size)]
#: A point or an offset in space.
Point = tuple[Length, Length, Length]
Number = Annotated[float, Field(allow_inf_nan=False)]

#: Directions are shorter and longer than these: outside, squares of their components would be lost in rounding.
SHORTEST_DIRECTION, LONGEST_DIRECTION = 1e-9, 1e9


def _is_a_direction(direction: tuple[float, float, float]) -> tuple[float, float, float]:
    if not any(direction):
        raise ValueError("is zero; it must be a direction")
    size = math.hypot(*direction)
    if not SHORTEST_DIRECTION <= size <= LONGEST_DIRECTION:
        raise ValueError(
            f"has a length of {size:g}; the length of a direction does not matter, but must be between "
            f"{SHORTEST_DIRECTION:g} and {LONGEST_DIRECTION:g}"
        )
    return direction


#: A direction; its length does not matter.
Direction = Annotated[tuple[Number, Number, Number], AfterValidator(_is_a_direction)]


class FileModel(BaseModel):
    """The base of everything read from a file: frozen, strict, and closed to unknown keys.

    Arrays in files and NumPy arrays in Python become tuples; numbers never come from text or booleans.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    @model_validator(mode="before")
    @classmethod
    def _sequences_become_tuples(cls, data: Any) -> Any:
        return {key: _tupled(value) for key, value in data.items()} if isinstance(data, dict) else data


def _tupled(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    return tuple(_tupled(item) for item in value) if isinstance(value, list | tuple) else value
