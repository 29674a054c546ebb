"""What a robot file says of a motor that pulls a cable."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field, model_validator

from hognose.units import FileModel, PositiveLength

#: Cable travel (m) of one motor count; beyond this a number of the transmission is wrong.
PLAUSIBLE_TRAVEL = (1e-12, 0.01)

#: A drive's position is a whole number of 64 bits at most.
COUNT_LIMIT = 2**63

#: Speeds, accelerations and ratios beyond these are a slip, and would overflow or vanish.
PositiveNumber = Annotated[float, Field(ge=1e-9, le=1e9, allow_inf_nan=False)]


class Transmission(FileModel):
    """How a motor pulls a cable: a lead screw or a drum, behind a gear."""

    screw_lead: PositiveLength | None = None
    drum_diameter: PositiveLength | None = None
    gear_ratio: PositiveNumber
    counts_per_turn: Annotated[int, Field(gt=0, lt=COUNT_LIMIT)]

    @model_validator(mode="after")
    def _one_kind(self) -> Transmission:
        if (self.screw_lead is None) == (self.drum_diameter is None):
            raise ValueError("give either screw_lead or drum_diameter, exactly one of them")
        low, high = PLAUSIBLE_TRAVEL
        if not low <= self.travel_per_count <= high:
            raise ValueError(
                f"one motor count moves the cable by {self.travel_per_count:.3g} m, expected {low:g} to {high:g} m: "
                "are lead or diameter, gear_ratio and counts_per_turn right?"
            )
        return self

    @property
    def travel_per_count(self) -> float:
        """Cable travel (m) of one encoder count at the motor."""
        per_turn = math.pi * self.drum_diameter if self.drum_diameter is not None else self.screw_lead
        assert per_turn is not None, "validated: exactly one of the two is given"
        return per_turn / (self.gear_ratio * self.counts_per_turn)
