"""What a task file says of tolerances: how exactly the space is known, and where the base stands in it."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from hognose.robot.tolerance import AngleError, JointErrors, RobotTolerance, Sag
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
    assumed: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _names_its_keys(self) -> ToleranceSpec:
        for key in self.assumed:
            if key == "assumed" or key not in type(self).model_fields:
                raise ValueError(f"assumed: {key!r} is not a key of this table")
        return self

    def of_robot(self, name: str, robot: RobotTolerance) -> tuple[object, bool]:
        """The value of one of the robot's tolerances, and whether it is from this table."""
        own = getattr(self, name)
        return (getattr(robot, name), False) if own is None else (own, True)
