"""What a robot file says of its cables as springs that are pretensioned."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from hognose.units import FileModel, NonNegativeLength

#: Cables of any snake arm are within these axial stiffnesses EA (N), from a thread to a rod of 25 mm of steel.
SOFTEST, STIFFEST = 100.0, 1e8
#: A cable that is stretched by more than this is no linear spring, or its stiffness is wrong by orders of magnitude.
LARGEST_STRAIN = 0.05
#: Coefficients of friction beyond this are a slip.
LARGEST_FRICTION = 1.0
#: Between set-points, and where motors start and stop at once, tensions at the limit exceed it by less than this.
AT_LIMIT = 1.01
#: A larger safety against buckling is a slip.
LARGEST_FACTOR = 100.0

#: Axial stiffness EA, N.
Stiffness = Annotated[float, Field(ge=SOFTEST, le=STIFFEST, allow_inf_nan=False)]
#: A tension, N.
Tension = Annotated[float, Field(ge=0, le=STIFFEST, allow_inf_nan=False)]


class CablesSpec(FileModel):
    """The cables as springs that only pull; without this table, mechanics are not judged.

    A cable is stretched over its length in the arm and the free length behind the base. `axial_stiffness_N` and
    `pretension_N` hold for all cables, or there is one value for those of each section.
    """

    axial_stiffness_N: Stiffness | tuple[Stiffness, ...]
    free_length: NonNegativeLength
    pretension_N: Tension | tuple[Tension, ...]
    tension_min_N: Tension
    tension_max_N: Tension
    friction: Annotated[float, Field(ge=0, le=LARGEST_FRICTION, allow_inf_nan=False)] = 0.0
    load_factor_min: Annotated[float, Field(ge=1, le=LARGEST_FACTOR, allow_inf_nan=False)] = 1.5

    @model_validator(mode="after")
    def _tensions_fit(self) -> CablesSpec:
        low, high = self.tension_min_N, self.tension_max_N
        if not low < high:
            raise ValueError(f"tension_min_N {low:g} N must be below tension_max_N, which is {high:g} N")
        for tension in _each(self.pretension_N):
            if not low <= tension <= high:
                raise ValueError(
                    f"pretension_N {tension:g} N is outside of tension_min_N to tension_max_N, {low:g} to {high:g} N"
                )
        softest = min(_each(self.axial_stiffness_N))
        if high > LARGEST_STRAIN * softest:
            raise ValueError(
                f"tension_max_N {high:g} N stretches a cable of axial_stiffness_N {softest:g} N by "
                f"{100 * high / softest:.3g} %, expected {100 * LARGEST_STRAIN:g} % at most: is EA given in N?"
            )
        return self

    def for_cables(self, key: str, sections: NDArray[np.int64]) -> NDArray[np.float64]:
        """The value (c,) of `axial_stiffness_N` or `pretension_N` of cables that end in sections (c,), 0-based."""
        given = np.array(_each(getattr(self, key)), np.float64)
        return given[sections] if given.size > 1 else np.repeat(given, len(sections))


def _each(given: float | tuple[float, ...]) -> tuple[float, ...]:
    return given if isinstance(given, tuple) else (given,)


def is_assumed(key: str, assumed: Iterable[str]) -> bool:
    """Whether a key, or the table that it is in, is among those that nobody measured."""
    return any(key == each or key.startswith(f"{each}.") for each in assumed)
