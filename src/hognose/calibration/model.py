"""What an arm with given cable zeros and stiffness would show, and how that changes with them.

The unknowns are θ = (δ, s, u): the zero δ of every cable (m), the logarithm s of the factor of EA of every section's
own cables, and, if readings are from a jig, how far u each joint is off its line (m). A motor at c leaves a cable of
c + δ. With tangent stiffness K and torques r of the joints, a free arm moves by dq = -K⁻¹ dr:

    zero of a cable       dr = -Jᵀ k dδ          dT = k (J dq - dδ)
    stiffness of section  dr =  Jᵀ T ds          dT = k J dq + T ds

Clamped, the angles are q = D u, and dT = k (J D du - dδ) + T ds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hognose.calibration.arm import Reading
from hognose.errors import InputError
from hognose.mechanics import Mechanics
from hognose.mechanics.sensitivity import tip_jacobian
from hognose.robot.sections import MixedSections

Array = NDArray[np.float64]

#: Solutions of the equilibrium: spring constants follow the pose, which has to follow them once more.
_REPEATS = 2


@dataclass(frozen=True, eq=False)
class Shown:
    """What an arm shows in T poses, and the derivatives by p unknowns.

    Attributes
    ----------
    angles : (T, n, 2) rad
    tensions : (T, c) N
    tips : (T, 3) m
        In the arm's own axes, from the first joint.
    by_angles : (T, 2n, p)
    by_tensions : (T, c, p)
    by_tips : (T, 3, p)
    stable : (T,)
        Where the arm rests on its cables alone.
    """

    angles: Array
    tensions: Array
    tips: Array
    by_angles: Array
    by_tensions: Array
    by_tips: Array
    stable: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Model:
    """An arm whose zeros and stiffness are sought.

    Attributes
    ----------
    nominal
        Its mechanics as its file says.
    gravity : (3,) m/s²
        In the arm's own axes.

    Raises
    ------
    InputError
        The arm is not one of rigid links, which do not bend back.
    """

    nominal: Mechanics
    gravity: Array

    def __post_init__(self) -> None:
        robot = self.nominal.robot
        if isinstance(robot.model, MixedSections) or self.nominal.springs.any():
            raise InputError(
                f"calibration of {robot.name}: expected an arm of rigid links with one universal joint each; zeros and "
                "stiffness of other sections, and of those that bend back, are not sought. Give the values of [cables] "
                "in the robot file as you measured them"
            )

    @property
    def cables(self) -> int:
        """Number of cables c."""
        return self.nominal.robot.cables

    @property
    def groups(self) -> NDArray[np.int64]:
        """Which factor (c,) of EA each cable has: that of the section it ends in."""
        return self.nominal.robot.cable_sections

    @property
    def unknowns(self) -> int:
        """Number of zeros and factors."""
        return self.cables + self.nominal.robot.sections

    def arm(self, theta: Array) -> Mechanics:
        """The mechanics with the stiffness of unknowns θ."""
        factors = np.exp(theta[self.cables : self.unknowns])
        return replace(self.nominal, axial_stiffness=self.nominal.axial_stiffness * factors[self.groups])

    def free(self, theta: Array, motors: Array, start: Array) -> Shown:
        """What the arm shows at rest with motors at (T, c) m; sought from angles (T, n, 2) rad."""
        arm, lengths = self.arm(theta), motors + theta[: self.cables]
        found = arm.settle(start, lengths, self.gravity)
        for _ in range(_REPEATS - 1):
            found = arm.settle(found.angles, lengths, self.gravity)
        return self.derived(arm, found.angles, found.tensions, found.is_stable)

    def derived(self, arm: Mechanics, angles: Array, tensions: Array, stable: NDArray[np.bool_]) -> Shown:
        """What an arm shows that rests at angles (T, n, 2) rad with tensions (T, c) N, with all derivatives."""
        J, k = self._springs(arm, angles, tensions)
        held = np.swapaxes(J * k[..., None], 1, 2)
        rest = arm.stiffness(angles, tensions, self.gravity)[1]
        pulls = self._by_section(tensions)
        torques = np.concatenate([-held, np.swapaxes(J, 1, 2) @ pulls], axis=2)
        K = held @ J + rest
        turned = np.zeros_like(torques)
        # A pose that falls has no derivatives.
        turned[stable] = -np.linalg.solve(K[stable], torques[stable])
        by_tensions = (J * k[..., None]) @ turned
        by_tensions += np.concatenate([-self._diagonal(k), pulls], axis=2)
        return Shown(
            angles,
            tensions,
            arm.robot.joint_positions(angles)[:, -1],
            turned,
            by_tensions,
            tip_jacobian(arm, angles) @ turned,
            stable,
        )

    def clamped(self, theta: Array, motors: Array) -> Shown:
        """What the arm shows in a jig with motors at (T, c) m."""
        arm, bent = self.arm(theta), jig_angles(arm_lengths=self.nominal.robot.link_lengths)
        angles = np.tile((bent @ theta[self.unknowns :]).reshape(-1, 2), (len(motors), 1, 1))
        lengths = arm.robot.cable_lengths(angles)
        tensions = np.maximum(arm.spring_constants(lengths) * (lengths - motors - theta[: self.cables]), 0.0)
        J, k = self._springs(arm, angles, tensions)
        none = np.zeros((len(motors), len(bent), self.unknowns))
        turned = np.concatenate([none, np.tile(bent, (len(motors), 1, 1))], axis=2)
        by_tensions = (J * k[..., None]) @ turned
        by_tensions[..., : self.unknowns] += np.concatenate([-self._diagonal(k), self._by_section(tensions)], axis=2)
        tips = arm.robot.joint_positions(angles)[:, -1]
        stable = np.ones(len(motors), np.bool_)
        return Shown(angles, tensions, tips, turned, by_tensions, tip_jacobian(arm, angles) @ turned, stable)

    def _springs(self, arm: Mechanics, angles: Array, tensions: Array) -> tuple[Array, Array]:
        """Jacobian (T, c, 2n) of the lengths, and spring constants (T, c), 0 of cables that are slack."""
        constants = arm.spring_constants(arm.robot.cable_lengths(angles))
        return arm.cable_jacobian(angles), np.where(tensions > 0, constants, 0.0)

    def _by_section(self, tensions: Array) -> Array:
        """Tensions as (T, c, n): those of a section in its column."""
        own = self.groups[:, None] == np.arange(self.nominal.robot.sections)
        return tensions[..., None] * own

    def _diagonal(self, values: Array) -> Array:
        return values[..., None] * np.eye(self.cables)


def jig_angles(arm_lengths: Array) -> Array:
    """D (2n, 2n) rad/m: angles of an arm of links (n,) m whose joints are off a line by (x₁, y₁, x₂, …) m.

    The first joint is on the line, and the last place is the tip's.
    """
    n = len(arm_lengths)
    slope = (np.eye(n) - np.eye(n, k=-1)) / arm_lengths[:, None]
    bend = (np.eye(n) - np.eye(n, k=-1)) @ slope
    out = np.zeros((2 * n, 2 * n))
    out[0::2, 0::2], out[1::2, 1::2] = bend, -bend  # α turns the nose along +x, β along -y
    return out


def stacked(readings: Sequence[Reading], clamped: bool) -> tuple[Array, Array, Array]:
    """Motors (T, c) m, tensions (T, c) N and expected angles (T, n, 2) rad of readings in the jig, or of the others."""
    chosen = [each for each in readings if each.clamped == clamped]
    return (
        np.array([each.motors for each in chosen]),
        np.array([each.tensions for each in chosen]),
        np.array([each.expected for each in chosen]),
    )
