"""What a task file says of tolerances: how exactly the space is known, and where the base stands in it."""

from __future__ import annotations

import difflib
from typing import Annotated

from pydantic import Field, field_validator, model_validator

from hognose.robot.tolerance import AngleError, JointErrors, Percent, PercentOfEA, RobotTolerance, Sag
from hognose.scene.obstacle_motion import LATEST
from hognose.units import FileModel, NonNegativeLength, Point


class ToleranceSpec(FileModel):
    """How far body and obstacles can be from where the files say.

    `cad` is a bound: how far surfaces may be from the drawing, or from what a scan saw of them. How far a mesh is from
    its surface is for the obstacle's own `tolerance`. `registration` and `registration_deg` are standard deviations
    (1σ): of the base's place along each axis, and of its turn about each, measured at `registration_at`.
    `timing_s` is a bound: how much earlier or later obstacles that move may be, unless they say it themselves.
    The other tolerances are the robot's; those that are given here count instead of those in its file.
    """

    cad: NonNegativeLength = 0.0
    registration: NonNegativeLength = 0.0
    registration_deg: AngleError = 0.0
    registration_at: Point | None = None
    timing_s: Annotated[float, Field(ge=0, le=LATEST, allow_inf_nan=False)] = 0.0
    calibration_deg: JointErrors | None = None
    cable_zero: NonNegativeLength | None = None
    sag: Sag | None = None
    axial_stiffness_percent: PercentOfEA | None = None
    mass_percent: Percent | None = None
    assumed: tuple[str, ...] = ()

    @field_validator("assumed")
    @classmethod
    def _names_keys(cls, assumed: tuple[str, ...]) -> tuple[str, ...]:
        known = [key for key in cls.model_fields if key != "assumed"]
        for key in assumed:
            if key not in known:
                near = difflib.get_close_matches(key, known, 1)
                hint = f"; did you mean {near[0]!r}?" if near else "."
                raise ValueError(f"unknown key {key!r}{hint} Known here: {', '.join(known)}")
        return assumed

    @model_validator(mode="after")
    def _goes_together(self) -> ToleranceSpec:
        for key in self.assumed:
            # Of the robot's tolerances, its file may have the value.
            if key not in RobotTolerance.model_fields and key not in self.model_fields_set:
                raise ValueError(f"`assumed`: {key!r} goes with a value of `{key}`, and none is given; leave it out")
        if self.registration_at is not None and not {"registration", "registration_deg"} & self.model_fields_set:
            raise ValueError(
                "`registration_at` goes with `registration` or `registration_deg`, of which neither is given; leave it "
                "out"
            )
        return self

    def of_robot(self, name: str, robot: RobotTolerance) -> tuple[float | tuple[float, ...], bool]:
        """The value of one of the robot's tolerances, and whether it is from this table."""
        own = getattr(self, name)
        return (getattr(robot, name), False) if own is None else (own, True)
