"""What a calibration needs of an arm: a real one's drives and sensors, or what stands for them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError

Array = NDArray[np.float64]

#: What to do about a sensor that reads no number.
_LOOK = "look at the sensor, its cable and its driver"


@runtime_checkable
class Arm(Protocol):
    """An arm whose motors hold positions and whose cables' tensions are measured.

    A motor position is said as the length of cable that it leaves between the hole plane before the first joint and the
    disk the cable is fixed to, without tension. It is off by that cable's zero, which is what a calibration finds.
    """

    @property
    def clamped(self) -> bool:
        """Whether something holds the arm straight, in line with its base: a jig, or a trough that it lies in."""
        ...

    def release(self) -> None:
        """Take away what holds the arm straight; with a real arm, somebody is asked to."""
        ...

    def command(self, lengths: Array, at: Array, pace: float) -> None:
        """Move all motors together to positions (c,) m, none faster than `pace` (m/s), and the base to (k,).

        Coordinates of a base are those of `hognose.robot.base.Base`. Returns when the motors have arrived.
        """
        ...

    def settle(self) -> None:
        """Wait until the arm does not move any more."""
        ...

    def tensions(self) -> Array:
        """Measured tensions (c,) N; around 0 in a slack cable."""
        ...

    def motors(self) -> Array:
        """Measured motor positions (c,) m."""
        ...

    def tip(self) -> Array | None:
        """Measured place (3,) m of the tip, from the first joint and in the arm's own axes; None if it is not seen."""
        ...


@dataclass(frozen=True)
class Accuracy:
    """How exactly an arm is measured: standard deviations.

    Attributes
    ----------
    tension : N
        Of one reading of one cable.
    tip : m
        Of each coordinate of the tip.
    jig : m
        How far each joint, across, is off the straight line on which a jig holds it.
    """

    tension: float = 0.2
    tip: float = 2e-4
    jig: float = 2e-5


@dataclass(frozen=True, eq=False)
class Reading:
    """What was read of an arm at rest.

    Attributes
    ----------
    motors : (c,) m
    tensions : (c,) N
    tip : (3,) m, optional
    clamped
        Whether the arm was in the jig.
    expected : (n, 2) rad
        The angles in which the arm was thought to be.
    """

    motors: Array
    tensions: Array
    tip: Array | None
    clamped: bool
    expected: Array


def read(arm: Arm, expected: Array, number: int = 1) -> Reading:
    """Wait until an arm is at rest, and read all of it; `number` says in messages which reading it is.

    Raises
    ------
    InputError
        A sensor reads what is no finite number; says which.
    """
    arm.settle()
    where = f"reading {number}"
    motors = finite(where, "motor", arm.motors(), "m")
    tensions = finite(where, "the tension of cable", arm.tensions(), "N")
    tip = arm.tip()
    if tip is not None and not np.isfinite(tip).all():
        raise InputError(f"{where}: the tip is at {np.asarray(tip).tolist()} m, which is no place; {_LOOK}")
    return Reading(motors, tensions, tip, arm.clamped, expected)


def finite(where: str, sensor: str, values: Array, unit: str) -> Array:
    """What sensors (c,) of all cables read, in a unit; an InputError that names the first that reads no number."""
    broken = np.flatnonzero(~np.isfinite(values))
    if broken.size:
        raise InputError(f"{where}: {sensor} {broken[0] + 1} reads {values[broken[0]]} {unit}; {_LOOK}")
    return values
