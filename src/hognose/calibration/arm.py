"""What a calibration needs of an arm: a real one's drives and sensors, or what stands for them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


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


def read(arm: Arm, expected: Array) -> Reading:
    """Wait until an arm is at rest, and read all of it."""
    arm.settle()
    return Reading(arm.motors(), arm.tensions(), arm.tip(), arm.clamped, expected)
