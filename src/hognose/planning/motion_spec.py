"""What a task file says of how a motion is sampled in feed and time."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, ValidationInfo, model_validator

from hognose.following import known_method
from hognose.units import FileModel, PositiveLength

#: Letters in the name of a following method.
LONGEST_METHOD = 80
#: Largest distance (m) of the points M(In).
COARSEST_SPACING = 0.005
#: Over how long (s) the feed's acceleration may build up.
ABRUPT, GRADUAL = 0.01, 60.0
#: It builds up over so many control periods at least: set-points further apart would not show it.
PERIODS_OF_SMOOTHING = 2
#: The shortest control period, and the longest time a motion may take (s): eleven days.
SHORTEST_PERIOD, LONGEST_MOTION = 1e-6, 1e6
#: In the context of a validation: that what is read was planned somewhere, maybe with a method that is not here.
PLANNED = "planned"

#: How the feed goes over time.
Profile = Literal["constant", "fastest"]


def _fine_enough(spacing: float) -> float:
    if spacing > COARSEST_SPACING:
        raise ValueError(f"{1e3 * spacing:g} mm is too coarse to follow a path; at most {1e3 * COARSEST_SPACING:g} mm")
    return spacing


def _method(name: str, info: ValidationInfo) -> str:
    return name if (info.context or {}).get(PLANNED) else known_method(name)


class MotionSpec(FileModel):
    """How the motion is sampled in feed and time, and the following method.

    The `constant` profile feeds `step` every period. The `fastest` one is as fast as the robot's limits allow, from
    rest to rest; its acceleration builds up over `smoothing_s`. A retraction has the same one unless it is given its
    own.

    `retraction_start_s` is when a retraction begins, on the clock of moving obstacles, which begins with the insertion;
    unless given, at the insertion's end.

    `tip_tolerance` is how closely the tip must reach the target and keep to exact following; unless given,
    1e-6 m for methods that are exact and 1 mm for those that look joints up among points.
    """

    step: PositiveLength = 0.0035
    period_s: Annotated[float, Field(ge=SHORTEST_PERIOD, le=LONGEST_MOTION, allow_inf_nan=False)] = 0.15
    profile: Profile = "constant"
    retraction_profile: Profile | None = None
    retraction_start_s: Annotated[float, Field(ge=0, le=LONGEST_MOTION, allow_inf_nan=False)] | None = None
    smoothing_s: Annotated[float, Field(ge=ABRUPT, le=GRADUAL, allow_inf_nan=False)] = 0.2
    method: Annotated[str, Field(max_length=LONGEST_METHOD), AfterValidator(_method)] = "exact"
    spacing: Annotated[PositiveLength, AfterValidator(_fine_enough)] = 0.0005
    tip_tolerance: PositiveLength | None = None

    @model_validator(mode="after")
    def _smooths_something(self, info: ValidationInfo) -> MotionSpec:
        given = self.smoothing_s != type(self).model_fields["smoothing_s"].default
        if given and "fastest" not in (self.profile, self.retraction_profile) and not (info.context or {}).get(PLANNED):
            raise ValueError('`smoothing_s` goes with `profile = "fastest"`, or such a `retraction_profile`')
        return self

    def profile_of(self, retracts: bool) -> Profile:
        """The profile of an insertion, or of a retraction."""
        return self.retraction_profile or self.profile if retracts else self.profile

    @property
    def feed_speed(self) -> float:
        """The feed speed (m/s) at which joints must be able to turn; 0 where the feed slows down for them both ways."""
        slows = all(self.profile_of(retracts) == "fastest" for retracts in (False, True))
        return 0.0 if slows else self.step / self.period_s

    @property
    def smoothing_time(self) -> float:
        """How long (s) acceleration takes to build up in the fastest profile."""
        return max(self.smoothing_s, PERIODS_OF_SMOOTHING * self.period_s)
