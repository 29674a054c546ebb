"""What a robot file says of how exactly the arm is where it is commanded to be."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, Field

from hognose.units import FileModel, NonNegativeLength

#: Sensitivities are linear: an error larger than this (deg) is a slip, or an arm that was not calibrated at all.
LARGEST_ERROR_DEG = 5.0

#: Of what is off by more than this (%), nothing is known.
LARGEST_SHARE = 50.0

#: Of EA even less (%): beyond, cables go slack at two standard deviations of it, and more is off than is linear.
LARGEST_SHARE_OF_EA = 15.0


def _keeps_tension(share: float) -> float:
    if share > LARGEST_SHARE_OF_EA:
        raise ValueError(
            f"with EA off by {share:g} % (1σ), cables go slack within 2σ; expected {LARGEST_SHARE_OF_EA:g} % at most: "
            "calibrate the arm, or measure its cables"
        )
    return share


#: A standard deviation in per cent of a value.
Percent = Annotated[float, Field(ge=0, le=LARGEST_SHARE, allow_inf_nan=False)]
#: That of EA.
PercentOfEA = Annotated[
    float, Field(ge=0, allow_inf_nan=False), AfterValidator(_keeps_tension), Field(le=LARGEST_SHARE_OF_EA)
]
#: A standard deviation of an angle, in degrees.
AngleError = Annotated[float, Field(ge=0, le=LARGEST_ERROR_DEG, allow_inf_nan=False)]
#: One value for all sections, or one for each.
JointErrors = AngleError | tuple[AngleError, ...]
#: What is left of the sag at the tip, or at the end of each link.
Sag = NonNegativeLength | tuple[NonNegativeLength, ...]


class RobotTolerance(FileModel):
    """How far the arm can be from where it is commanded to be.

    `calibration_deg` and `cable_zero` are standard deviations (1σ): of the zero of each joint angle, about both axes,
    and of the zero of each cable's length. `sag` is a bound: how far the arm still hangs after whatever compensates its
    weight, at the tip or at the end of every link. A single figure is that at the tip; before it, the sag is taken to
    rise in proportion to the length, which is more than a beam that is held at its base sags there.

    `axial_stiffness_percent` and `mass_percent` are standard deviations of EA and of the masses, all cables and all
    links alike: how far the arm hangs then, although its weight is made up for, follows from its mechanics.
    """

    calibration_deg: JointErrors = 0.0
    cable_zero: NonNegativeLength = 0.0
    sag: Sag = 0.0
    axial_stiffness_percent: PercentOfEA = 0.0
    mass_percent: Percent = 0.0
