"""What the cables pull while the arm moves: springs with a damper that only pull, and rub in their holes.

Friction is that of a rope on a drum. At a joint of bend θ the tension changes by the factor exp(μ θ g) towards the
tip. The grip g is 1 while the cable is paid out there and -1 while it is pulled in. In between it is elastic: as the
cable slides by x towards the tip, g becomes g + x/d within -1…1, with d = `PRESLIDING` (Prandtl's element). So a cable
that stands still, or only trembles, keeps its grip, and the arm has a hysteresis.

The motor holds the length, so what it feels is EA times stretch over the mean of those factors along the cable.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.files.exports.mjcf_cables import DAMPING
from hognose.kernels import kernel
from hognose.mechanics import Mechanics
from hognose.mechanics.cables import jacobian_at
from hognose.mechanics.postures import LONG, lay_joints, lay_runs
from hognose.robot import Robot
from hognose.robot.section_cable import CableLaw
from hognose.robot.sections import MixedSections

Array = NDArray[np.float64]

#: [assumed] How far (m) a cable that rubbed neither way slides in a hole until it does so with all force.
PRESLIDING = 1e-4


@kernel()
def _rub(
    angles: NDArray,
    slid: NDArray,
    longer: NDArray,
    sections: NDArray,
    pitches: NDArray,
    bent: NDArray,
    friction: float,
    jacobian: NDArray,
    grip: NDArray,
    shares: NDArray,
    means: NDArray,
) -> None:
    """Fill the shares (c, n) of the motors' tensions at the joints, and their means (c,) along the cables.

    Angles have changed by slid (2n,) since, and cables beside sections that extend got `longer` (n,) m; grip (c, n)
    goes with them. `bent` (n,) says how, as `_bending`.
    """
    bends = np.empty(angles.shape[0])
    for j in range(angles.shape[0]):
        if bent[j] == 0.0:
            bends[j] = math.sqrt(angles[j, 0] ** 2 + angles[j, 1] ** 2)
            continue
        turned = math.cos(angles[j, 0] / bent[j]) * math.cos(angles[j, 1] / bent[j])
        bends[j] = bent[j] * math.acos(min(1.0, turned))
    for k in range(sections.size):
        beyond = 0.0
        for j in range(sections[k], -1, -1):
            grown = jacobian[k, 2 * j] * slid[2 * j] + jacobian[k, 2 * j + 1] * slid[2 * j + 1] + longer[j]
            x = (beyond + 0.5 * grown) / PRESLIDING
            beyond += grown
            grip[k, j] = min(max(grip[k, j] + x, -1.0), 1.0)
        share, total, length = 1.0, 0.0, 0.0
        for j in range(sections[k] + 1):
            half = math.exp(0.5 * friction * bends[j] * grip[k, j])
            shares[k, j] = share * half
            share = shares[k, j] * half
            total += share * pitches[j]
            length += pitches[j]
        means[k] = total / length
        shares[k, -1] = share


@kernel()
def _pull(
    angles: NDArray,
    rates: NDArray,
    growth: NDArray,
    joints: NDArray,
    sections: NDArray,
    holes: NDArray,
    straight: NDArray,
    stiff: NDArray,
    pitches: NDArray,
    bent: NDArray,
    constants: tuple[float, float, float, float],
    commanded: NDArray,
    speeds: NDArray,
    lengths: NDArray,
    jacobian: NDArray,
    grip: NDArray,
    shares: NDArray,
    means: NDArray,
    tensions: NDArray,
    extremes: NDArray,
    torques: NDArray,
) -> None:
    """Fill lengths (c,), their derivatives (c, 2n), tensions (c,) and torques (2n,) of a pose and its rates.

    Cables beside section j get longer by growth[j] m/s because it does.
    """
    free, damping, friction, step = constants
    lengths[:] = straight
    jacobian_at(angles, joints, sections, holes, lengths, jacobian)
    if friction > 0.0:
        _rub(angles, step * rates, step * growth, sections, pitches, bent, friction, jacobian, grip, shares, means)
    torques[:] = 0.0
    for k in range(sections.size):
        passed = sections[k] + 1
        faster = -speeds[k]
        for i in range(2 * passed):
            faster += jacobian[k, i] * rates[i]
        for j in range(passed):
            faster += growth[j]
        pull = stiff[k] * (lengths[k] - commanded[k]) / (lengths[k] * means[k] + free) + damping * faster
        tensions[k] = max(pull, 0.0)
        extremes[0, k] = min(extremes[0, k], tensions[k])
        extremes[1, k] = max(extremes[1, k], tensions[k])
        for j in range(passed):
            there = tensions[k] * shares[k, j]
            torques[2 * j] -= jacobian[k, 2 * j] * there
            torques[2 * j + 1] -= jacobian[k, 2 * j + 1] * there


def _bending(robot: Robot) -> Array:
    """How sections bend (n,): at so many equal joints, or along their length, which is 0.

    Two hinges count as one joint: what a cable bends at the one and at the other it does in another plane.
    """
    if not isinstance(robot.model, MixedSections):
        return np.ones(robot.sections)
    laws = [CableLaw(*law) for law in robot.cable_laws.tolist()]
    return np.array([0.0 if law.arc else law.joints for law in laws])


def _beside(laws: Array, angles: Array) -> Array:
    """By how much (n,) a cable gets longer with a section that extends, an arc: its disks' chords over their arcs."""
    disks = laws[:, CableLaw._fields.index("disks")]
    part = np.hypot(angles[:, 0], angles[:, 1]) / (2.0 * np.maximum(disks, 1.0))
    return np.where(disks > 0.0, np.sinc(part / math.pi), 1.0)


@dataclass(frozen=True, eq=False)
class CableForces:
    """The cables of an arm, and what they do at the moment.

    Attributes
    ----------
    mechanics
    lengths : (c,) m
    jacobian : (c, 2n) m/rad
    grip : (c, n)
        -1 where a cable is pulled in through a joint, 1 where it is paid out, between them as it turns.
    shares : (c, n+1)
        Of the motor's tension at each joint, and at the end of the cable.
    means : (c,)
        Of these along the cable.
    tensions : (c,) N
        At the motors.
    extremes : (2, c) N
        The smallest and the largest of them since `watch`.
    torques : (2n,) N m
        All of them are written anew by `pull`.
    """

    mechanics: Mechanics
    lengths: Array
    jacobian: Array
    grip: Array
    shares: Array
    means: Array
    tensions: Array
    extremes: Array
    torques: Array
    _layout: tuple[Array, NDArray[np.int64], Array, Array]
    _laid: tuple[Array, NDArray[np.int64], Array, Array]
    _springs: tuple[Array, Array, Array]
    _still: Array

    @classmethod
    def of(cls, mechanics: Mechanics) -> CableForces:
        """The cables of an arm, which have not slid yet."""
        c, n = mechanics.robot.cables, mechanics.robot.sections
        rubbed = np.zeros((c, n)), np.ones((c, n + 1)), np.ones(c)
        springs = mechanics.axial_stiffness, mechanics.robot.pitches, _bending(mechanics.robot)
        lengths, pulls = (np.zeros(c), np.zeros((c, 2 * n))), (np.zeros(c), np.empty((2, c)), np.zeros(2 * n))
        joints, sections, holes, straight = mechanics.layout
        laid = joints.copy(), sections, holes, straight.copy()
        made = cls(mechanics, *lengths, *rubbed, *pulls, mechanics.layout, laid, springs, np.zeros(n))
        made.watch()
        return made

    @property
    def end_tensions(self) -> Array:
        """Where the cables are fixed (c,) N."""
        return self.tensions * self.shares[:, -1]

    def loosen(self) -> None:
        """Forget which way the cables slid."""
        self.grip[:], self.shares[:], self.means[:] = 0.0, 1.0, 1.0

    def watch(self) -> None:
        """Begin to look for the smallest and the largest tensions."""
        self.extremes[0], self.extremes[1] = np.inf, -np.inf

    def pull(
        self,
        angles: Array,
        rates: Array,
        commanded: Array,
        speeds: Array,
        step: float = 0.0,
        longer: Array | None = None,
    ) -> Array:
        """Torques (2n,) N m at angles (n, 2) rad that change at rates (2n,) rad/s, and did so for a step (s).

        The motors hold the cables at lengths (c,) m without tension, which change at speeds (c,) m/s. A posture (n, 3)
        can stand in the place of angles; its sections get longer (n,) m/s.
        """
        growth, (stiff, pitches, bent) = self._still, self._springs
        if angles.shape[1] > LONG:
            joints, sections, _, straight = self._layout
            lay_joints(angles, joints, self._laid[0])
            lay_runs(angles, joints, sections, straight, self._laid[3])
            pitches = pitches * angles[:, LONG]
        if longer is not None and longer.any():
            growth = longer * _beside(self._layout[0], angles)
        constants = (self.mechanics.free_length, DAMPING, self.mechanics.friction, step)
        rubbed, pulls = (self.grip, self.shares, self.means), (self.tensions, self.extremes, self.torques)
        given = (stiff, pitches, bent, constants, commanded, speeds)
        _pull(angles, rates, growth, *self._laid, *given, self.lengths, self.jacobian, *rubbed, *pulls)
        return self.torques
