"""Length units of the files people write, and the validated quantities built on them.

Python values are SI throughout. A file names its length unit once; while it is validated, the context
carries that unit's size and every `Length` is converted on the way in. Without a context (a value made in
Python) lengths are metres already.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, get_args

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationInfo, field_validator, model_validator

from hognose.plain_text import is_plain

#: Metres in one of each length unit a file may declare.
LENGTH_UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}


#: Lengths and coordinates (m) beyond this are a wrong unit, not a space for a snake arm.
LARGEST_LENGTH = 10_000.0
#: Sizes (m) below this are a wrong unit or a slip: rounding of coordinates would swallow them.
SMALLEST_SIZE = 1e-9


def _to_metres(value: float, info: ValidationInfo) -> float:
    metres = value * (info.context or {}).get("metres_per_unit", 1.0)
    if abs(metres) > LARGEST_LENGTH:
        raise ValueError(f"{metres:.4g} m is out of range (at most {LARGEST_LENGTH:,.0f} m): is `units` right?")
    return metres


def _is_a_size(metres: float) -> float:
    if metres < SMALLEST_SIZE:
        raise ValueError(f"{metres:.3g} m is too small (at least {SMALLEST_SIZE:g} m): is `units` right?")
    return metres


#: Any length: metres in Python, the declared unit in a file.
Length = Annotated[float, Field(allow_inf_nan=False), AfterValidator(_to_metres)]
#: A length greater than zero, and than what rounding swallows.
PositiveLength = Annotated[
    float, Field(gt=0, allow_inf_nan=False), AfterValidator(_to_metres), AfterValidator(_is_a_size)
]
#: A length of zero or more.
NonNegativeLength = Annotated[float, Field(ge=0, allow_inf_nan=False), AfterValidator(_to_metres)]
#: A point or an offset in space.
Point = tuple[Length, Length, Length]
#: An angle in degrees; more than a turn is a slip.
Angle = Annotated[float, Field(ge=-360, le=360, allow_inf_nan=False)]
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

    @field_validator("*", mode="after")
    @classmethod
    def _texts_are_plain(cls, value: Any, info: ValidationInfo) -> Any:
        for text in value if isinstance(value, tuple | list) else (value,):
            if isinstance(text, str) and not is_plain(text, lines=info.field_name in ("description", "source")):
                raise ValueError(f"holds a control character: {text[:60]!r}; use letters, digits, signs and spaces")
        return value

    @model_validator(mode="before")
    @classmethod
    def _sequences_become_tuples(cls, data: Any) -> Any:
        return {key: _tupled(value) for key, value in data.items()} if isinstance(data, dict) else data


def _tupled(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    return tuple(_tupled(item) for item in value) if isinstance(value, list | tuple) else value


def names_a_field(model: Any, keys: list[str]) -> bool:
    """Whether keys, one within the other, are those of a model's field."""
    if not keys:
        return True
    candidates = [model, *get_args(model)]
    models = [c for c in candidates if isinstance(c, type) and issubclass(c, BaseModel)]
    return any(
        keys[0] in m.model_fields and names_a_field(m.model_fields[keys[0]].annotation, keys[1:]) for m in models
    )
