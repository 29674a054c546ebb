"""An arm without a machine: it comes to rest as statics say, its truth is hidden, and its sensors are noisy."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hognose.arguments import instance, real, whole
from hognose.calibration.arm import Accuracy
from hognose.calibration.calibration import Calibration
from hognose.calibration.model import jig_angles
from hognose.mechanics import Mechanics

Array = NDArray[np.float64]

#: How hidden truths are drawn unless said otherwise: zeros normal with this σ (m), EA of each section uniform within.
ZERO, STIFFNESS = 5e-4, 0.2
#: How far each joint of an arm that lies in a trough is off a straight line, standard deviation (m).
TROUGH = 5e-4


@dataclass(frozen=True, eq=False)
class Hidden:
    """How an arm is, which its calibration does not know.

    Attributes
    ----------
    zeros : (c,) m
        By how much each cable is longer than its motor says.
    stiffness : (n,)
        Factor of EA of each section's own cables.
    jig : (2n,)
        How far each joint is off its line in the jig along x and y, in standard deviations.
    """

    zeros: Array
    stiffness: Array
    jig: Array

    @classmethod
    def drawn(cls, mechanics: Mechanics, seed: int, zero: float = ZERO, share: float = STIFFNESS) -> Hidden:
        """Zeros normal with standard deviation `zero` (m), factors uniform within `share` of 1.

        Raises
        ------
        InputError
            The seed is no whole number from 0 on, the deviation below 0, or the share not from 0 to below 1.
        """
        instance("mechanics", mechanics, Mechanics, "hognose.mechanics.Mechanics, as of `Mechanics.of(robot)`")
        whole("seed", seed, 0)
        real("zero", zero, "a standard deviation of 0 or more, in m", lambda value: 0 <= value < math.inf)
        real("share", share, "a share from 0 to below 1", lambda value: 0 <= value < 1)
        rng, n = np.random.default_rng(seed), mechanics.robot.sections
        zeros = rng.normal(0.0, zero, mechanics.robot.cables)
        return cls(zeros, rng.uniform(1.0 - share, 1.0 + share, n), rng.normal(size=2 * n))

    def by_cable(self, mechanics: Mechanics) -> Array:
        """The factor (c,) of EA of every cable."""
        return self.stiffness[mechanics.robot.cable_sections]

    def applied(self, mechanics: Mechanics) -> Mechanics:
        """The mechanics of the arm as it is."""
        return replace(mechanics, axial_stiffness=mechanics.axial_stiffness * self.by_cable(mechanics))


class Sensors:
    """What measures an arm, with noise."""

    def __init__(self, accuracy: Accuracy, seed: int, sees_tip: bool, gain: float = 0.0) -> None:
        """Sensors whose noise begins with a seed; those of tension read factors of 1 with standard deviation `gain`."""
        whole("seed", seed, 0)
        self.accuracy, self._sees_tip, self._gain, self._seed = accuracy, sees_tip, gain, seed
        self._rng = np.random.default_rng([seed, 1])

    def tensions(self, true: Array) -> Array:
        """A reading (c,) N of all cables."""
        factors = np.random.default_rng([self._seed, 2]).normal(1.0, self._gain, true.shape)
        return factors * true + self._rng.normal(0.0, self.accuracy.tension, true.shape)

    def tip(self, true: Array) -> Array | None:
        """A reading (3,) m of the tip."""
        return true + self._rng.normal(0.0, self.accuracy.tip, 3) if self._sees_tip else None


def held_pose(mechanics: Mechanics, hidden: Hidden, off: float) -> Array:
    """Angles (n, 2) rad of an arm whose joints are held on a straight line but for a standard deviation `off` (m)."""
    return (jig_angles(mechanics.robot.link_lengths) @ (off * hidden.jig)).reshape(-1, 2)


def held_tensions(mechanics: Mechanics, angles: Array, motors: Array) -> Array:
    """Tensions (c,) N of an arm that is held at angles (n, 2) rad; mechanics and motors (c,) m as they are."""
    lengths = mechanics.robot.cable_lengths(angles)
    return np.maximum(mechanics.spring_constants(lengths) * (lengths - motors), 0.0)


class StaticArm:
    """An arm that is at rest at once, in free space; it implements `Arm`.

    Attributes
    ----------
    angles : (n, 2) rad
        As it is.
    clamped
        Whether it is held straight.
    """

    angles: Array
    clamped: bool

    def __init__(
        self, mechanics: Mechanics, gravity: Array, hidden: Hidden, sensors: Sensors, off: float | None = TROUGH
    ) -> None:
        """An arm at rest and straight, with its motors where a nominal arm's are; gravity (3,) m/s² in its axes.

        It is held on a straight line but for a standard deviation `off` (m) of every joint; None for one that hangs.
        """
        self._true, self._gravity, self._hidden, self._sensors = hidden.applied(mechanics), gravity, hidden, sensors
        self.clamped, self.angles = off is not None, held_pose(mechanics, hidden, off or 0.0)
        self._motors = mechanics.hold(self.angles[None], gravity).commanded_lengths[0]
        self._pulls = np.zeros(mechanics.robot.cables)

    def release(self) -> None:
        """See `Arm.release`."""
        self.clamped = False
        self.settle()

    def command(self, lengths: Array, at: Array, pace: float) -> None:
        """See `Arm.command`; the base stays."""
        del at, pace
        self._motors = np.array(lengths)
        self.settle()

    def settle(self) -> None:
        """See `Arm.settle`."""
        true, lengths = self._true, self._motors + self._hidden.zeros
        if self.clamped:
            self._pulls = held_tensions(true, self.angles, lengths)
            return
        for _ in range(2):  # the spring constants are those of the pose before
            found = true.settle(self.angles[None], lengths[None], self._gravity)
            self.angles, self._pulls = found.angles[0], found.tensions[0]

    def tensions(self) -> Array:
        """See `Arm.tensions`."""
        return self._sensors.tensions(self._pulls)

    def motors(self) -> Array:
        """See `Arm.motors`."""
        return self._motors.copy()

    def tip(self) -> Array | None:
        """See `Arm.tip`."""
        return self._sensors.tip(self._true.robot.joint_positions(self.angles)[-1])


def true_errors(
    calibration: Calibration,
    mechanics: Mechanics,
    hidden: Hidden,
    angles: Array,
    gravity: Array,
    built: Mechanics | None = None,
) -> Array:
    """How far (T,) m the tip is off where a calibrated arm is commanded to angles (T, n, 2) rad, by statics.

    `mechanics` are nominal; the arm is built by `built`, if its file is wrong in more than what is hidden. Gravity (3,)
    or (T, 3) m/s² is in the arm's own axes.
    """
    true = hidden.applied(mechanics if built is None else built)
    lengths = calibration.motors(mechanics, angles, gravity) + hidden.zeros
    return np.linalg.norm(true.settle(angles, lengths, gravity).tip_shift, axis=1)
