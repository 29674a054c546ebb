"""How the arm and the space that are there differ from those that were planned with."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from hognose.arguments import coordinates, floats, instance, real, whole
from hognose.errors import InputError
from hognose.mechanics import Mechanics
from hognose.robot import Robot
from hognose.robot.tension import LARGEST_FRICTION
from hognose.scene import MovingObstacle, Scene
from hognose.scene.moving import parts_of

Array = NDArray[np.float64]

#: Factors beyond these, a zero (m) off by more, or a later slider (s) is a slip or a wrong unit.
LARGEST_STIFFNESS, LARGEST_MASS, LARGEST_ZERO, LONGEST_LAG = 1e6, 1e3, 0.1, 10.0


@dataclass(frozen=True, eq=False)
class Changes:
    """How the arm and the space differ from what was planned with.

    Attributes
    ----------
    stiffness, mass
        Factors of the cables' EA, and of all masses.
    cable_zeros : (c,) m
        By how much each cable is longer than its motor says.
    shifted
        Obstacles that stand or move elsewhere, by name: (3,) m.
    friction
        Coefficient of friction of the cables in their holes; as the robot file says unless given.
    lag : s
        By how much the base is later than the cables.
    """

    stiffness: float = 1.0
    mass: float = 1.0
    cable_zeros: Array | None = None
    shifted: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    friction: float | None = None
    lag: float = 0.0

    def __post_init__(self) -> None:
        """Raise an InputError that names a value which no arm has."""
        for name, most in (("stiffness", LARGEST_STIFFNESS), ("mass", LARGEST_MASS)):
            real(name, getattr(self, name), f"a factor above 0 and up to {most:g}", lambda x, most=most: 0 < x <= most)
        if self.friction is not None:
            most = LARGEST_FRICTION
            real("friction", self.friction, f"a coefficient from 0 to {most:g}", lambda value: 0 <= value <= most)
        real("lag", self.lag, f"seconds from 0 to {LONGEST_LAG:g}", lambda value: 0 <= value <= LONGEST_LAG)
        if self.cable_zeros is not None:
            zeros = floats("cable_zeros", self.cable_zeros, "(c,)", "m")
            worst = float(np.abs(zeros).max(initial=0.0))
            if worst > LARGEST_ZERO:
                limit = f"{1e3 * LARGEST_ZERO:g} mm"
                raise InputError(f"cable_zeros: expected none beyond {limit}, got {1e3 * worst:g} mm; they are in m")
            object.__setattr__(self, "cable_zeros", zeros)
        instance("shifted", self.shifted, dict, "a dict of the names of obstacles and their shifts (3,) m")
        for name, shift in self.shifted.items():
            instance("shifted", name, str, "the name of an obstacle")
            coordinates(f"shifted: {name}", shift, "(3,)")

    @property
    def of_the_arm(self) -> bool:
        """Whether the arm is another one, so that it does not rest where it is planned to."""
        return (self.stiffness, self.mass) != (1.0, 1.0) or self.cable_zeros is not None

    def to_json(self) -> dict[str, object]:
        """What is not as planned, in SI units."""
        return {
            "stiffness": self.stiffness,
            "mass": self.mass,
            "friction": self.friction,
            "lag_s": self.lag,
            "cable_zeros_m": None if self.cable_zeros is None else self.cable_zeros.tolist(),
            "shifted_m": {name: [float(x) for x in shift] for name, shift in self.shifted.items()},
        }

    def applied(self, mechanics: Mechanics) -> Mechanics:
        """The mechanics of the arm as it is."""
        links = mechanics.links * [1.0, self.mass, 1.0]
        return replace(
            mechanics,
            links=links,
            tool_mass=self.mass * mechanics.tool_mass,
            axial_stiffness=self.stiffness * mechanics.axial_stiffness,
            friction=mechanics.friction if self.friction is None else self.friction,
        )

    def zeros(self, robot: Robot) -> Array:
        """By how much (c,) m the cables of a robot are longer than their motors say.

        Raises
        ------
        InputError
            They are those of another arm.
        """
        if self.cable_zeros is None:
            return np.zeros(robot.cables)
        if len(self.cable_zeros) != robot.cables:
            raise InputError(
                f"cable_zeros: expected one for each of the {robot.cables} cables of {robot.name}, got "
                f"{len(self.cable_zeros)}"
            )
        return self.cable_zeros

    def space(self, scene: Scene, moving: tuple[MovingObstacle, ...]) -> tuple[Scene, list[MovingObstacle]]:
        """The obstacles where they are: those that stand, and those that move.

        Raises
        ------
        InputError
            No obstacle of a name.
        """
        names = [*scene.names, *(each.name for each in moving)]
        unknown = [name for name in self.shifted if name not in names]
        if unknown:
            there = ", ".join(names) or "none"
            raise InputError(f"shifted: no obstacle is called {unknown[0]!r}; there are {there}")
        if any(name in self.shifted for name in scene.names):
            shifts = [np.array(self.shifted.get(name, (0.0, 0.0, 0.0))) for name in scene.names]
            parts = zip(parts_of(scene), shifts, strict=True)
            scene = Scene.from_parts([replace(part, triangles=part.triangles + shift) for part, shift in parts])
        return scene, [self._shifted(each) for each in moving]

    def _shifted(self, each: MovingObstacle) -> MovingObstacle:
        if each.name not in self.shifted:
            return each
        return replace(each, motion=replace(each.motion, places=each.motion.places + self.shifted[each.name]))


def random_zeros(robot: Robot, sigma: float, seed: int) -> Array:
    """Errors (c,) m of all cable zeros, normally distributed with a standard deviation of sigma (m).

    Raises
    ------
    InputError
        Sigma is negative or no such length, or the seed no whole number from 0 on.
    """
    most = LARGEST_ZERO / 5
    spread = real("zeros", sigma, "a standard deviation in m", lambda value: True)
    if not 0 <= spread <= most:
        raise InputError(f"zeros: expected a standard deviation from 0 to {1e3 * most:g} mm, got {1e3 * spread:g} mm")
    return np.random.default_rng(whole("seed", seed, 0)).normal(0.0, spread, robot.cables)


def set_zeros(robot: Robot, zeros: Array, single: tuple[tuple[int, float], ...]) -> Array:
    """The zeros (c,) m with those of single cables, by number from 1, replaced.

    Raises
    ------
    InputError
        There is no cable of a number, or it is off by an absurd length.
    """
    out = zeros.copy()
    for number, length in single:
        if not 1 <= number <= robot.cables:
            raise InputError(f"zero: no cable {number}; {robot.name} has cables 1 to {robot.cables}")
        if not math.isfinite(length) or abs(length) > LARGEST_ZERO:
            raise InputError(
                f"zero: cable {number}: expected {1e3 * LARGEST_ZERO:g} mm at most either way, got {1e3 * length:g} mm"
            )
        out[number - 1] = length
    return out
