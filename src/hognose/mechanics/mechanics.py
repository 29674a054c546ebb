"""The mechanics of one arm: what its cables must pull, how stiff it is then, and how far it hangs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.arguments import coordinates, floats, instance
from hognose.cached import cached_array, read_only
from hognose.errors import InputError
from hognose.mechanics import cables, gravity, stiffness, tensions
from hognose.mechanics.pieces import weights_of
from hognose.mechanics.postures import angles_of, checked, times_of
from hognose.mechanics.states import Held, Settled
from hognose.mechanics.statics import STABLE, settle
from hognose.robot import Robot
from hognose.robot.backbone import bending_springs

Array = NDArray[np.float64]

#: Mechanics are dense matrices: beyond so many sections a single step would take seconds.
MOST_SECTIONS = 300
#: Entries of the largest array that is made at a time: longer plans are judged in parts.
_LARGEST_PART = 4_000_000
#: Accelerations (m/s²) beyond this are a wrong unit.
_LARGEST_GRAVITY = 1e4


@dataclass(frozen=True, eq=False)
class Mechanics:
    """An arm whose sections have masses and may bend back by themselves, and whose cables are springs that only pull.

    Angles are numbered q = (α₁, β₁, α₂, …) where a matrix has 2n rows: all that a section does follows from its two.
    Torques are dU/dq of weight and bending: what the cables must add up to, -Jᵀ T = dU/dq. Vary an arm with
    `dataclasses.replace`; its arrays cannot be written to. Angles (T, n, 2) are those of sections as long as at rest;
    where sections extend, `postures` (T, n, 3) can stand in their place, and lengths are held by the backbones.

    Attributes
    ----------
    robot
    links : (n, 3)
        Length (m) and mass (kg) of each section, distance (m) of its centre of mass from its beginning.
    tool_mass : kg
        At the tip.
    axial_stiffness, pretension : (c,) N
    tension_min, tension_max : N
    free_length : m
        Of each cable behind the base.
    friction
        Coefficient of friction in the holes.
    load_factor_min
        The load factor that the arm must have.
    bending : (n,) N m/rad
        With what α and β of each section spring back, as long as at rest, see `hognose.robot.backbone`.
    """

    robot: Robot
    links: Array
    tool_mass: float
    axial_stiffness: Array
    pretension: Array
    tension_min: float
    tension_max: float
    free_length: float
    friction: float
    load_factor_min: float
    bending: Array

    def __post_init__(self) -> None:
        for name in ("links", "axial_stiffness", "pretension", "bending"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @classmethod
    def of(cls, robot: Robot) -> Mechanics:
        """The mechanics of a robot whose file says them.

        Raises
        ------
        InputError
            The robot file has no table `[cables]`, or there are too many sections.
        """
        instance("robot", robot, Robot, "a hognose.Robot; `hognose.load_robot` reads one from a file")
        if why := why_unknown(robot):
            raise InputError(f"mechanics of {robot.name}: {why}")
        spec = robot.spec.cables
        assert spec is not None, "why_unknown"
        stiff, wanted = (spec.for_cables(key, robot.cable_sections) for key in ("axial_stiffness_N", "pretension_N"))
        return cls(
            robot,
            np.column_stack([robot.link_lengths, robot.link_masses, robot.centres_of_mass]),
            robot.tool_mass,
            stiff,
            wanted,
            spec.tension_min_N,
            spec.tension_max_N,
            spec.free_length,
            spec.friction,
            spec.load_factor_min,
            bending_springs(robot),
        )

    @property
    def layout(self) -> tuple[Array, NDArray[np.int64], Array, Array]:
        """Hole planes (n, 2), sections (c,), holes (c, 3) and runs (c,) of the cables, see `Robot`.

        Of an arm whose sections are not all links or whose cables change circles, the `CableLaw` (n, 6) of each section
        in the place of its hole planes, and the circles behind the holes (c, 3 + n + 1).
        """
        robot = self.robot
        if robot.plain_cables:
            return robot.hole_planes, robot.cable_sections, robot.cable_holes, robot.cable_runs
        holes = np.column_stack([robot.cable_holes, robot.cable_circles])
        return robot.cable_laws, robot.cable_sections, holes, robot.cable_runs

    @cached_array
    def pieces(self) -> Array:
        """The pieces (p, 7) of all sections with their masses, see `hognose.mechanics.pieces.Weight`."""
        return weights_of(self.robot, self.links)

    @cached_array
    def springs(self) -> Array:
        """What all angles spring back with (2n,) N m/rad, of sections as long as at rest."""
        return np.repeat(self.bending, 2)

    def cable_lengths(self, angles: ArrayLike) -> Array:
        """Lengths (T, c) m of the cables; raises as `cable_jacobian`."""
        return self._jacobians(self._angles(angles))[0]

    def cable_jacobian(self, angles: ArrayLike) -> Array:
        """Derivatives J (T, c, 2n) m/rad of the cable lengths at angles (T, n, 2) rad.

        Raises
        ------
        InputError
            Wrong shape, or values that are not finite.
        """
        return self._jacobians(self._angles(angles))[1]

    def cable_hessian(self, angles: ArrayLike) -> Array:
        """Second derivatives (T, c, n, 2, 2) m/rad² of the cable lengths by α and β of each section.

        A length is a sum over sections, so those by angles of two sections are zero. Raises as `cable_jacobian`.
        """
        return cables.hessians_of(self._angles(angles), *self.layout[:3])

    def gravity_torque(self, angles: ArrayLike, gravity: ArrayLike) -> Array:
        """Torques dU/dq (T, 2n) N m that hold the weight of links and tool.

        Parameters
        ----------
        angles : (T, n, 2) rad
        gravity : (3,) or (T, 3) m/s²
            In the arm's own axes, in which it lies along +z: `Base.aligned` turns a vector into them.

        Raises
        ------
        InputError
            Wrong shapes, or values that are not finite.
        """
        return self._weight(self._angles(angles), gravity)[0]

    def gravity_stiffness(self, angles: ArrayLike, gravity: ArrayLike) -> Array:
        """Derivatives d²U/dq² (T, 2n, 2n) N m/rad of the torques of the weight; arguments as in `gravity_torque`."""
        return self._weight(self._angles(angles), gravity)[1]

    def torque(self, angles: ArrayLike, gravity: ArrayLike) -> Array:
        """Torques (T, 2n) N m that cables hold: of weight and bending; arguments as in `gravity_torque`."""
        poses = self._angles(angles)
        return self._bent(poses, self._weight(poses, gravity)[0])

    def spring_constants(self, cable_lengths: ArrayLike) -> Array:
        """Spring constants k = EA / (length + free length) (..., c) N/m of cables of lengths (..., c) m.

        Raises
        ------
        InputError
            Wrong shape, or values that are not finite.
        """
        lengths = coordinates("cable_lengths", cable_lengths, f"(..., {self.robot.cables})")
        return self.axial_stiffness / (lengths + self.free_length)

    def hold(self, angles: ArrayLike, gravity: ArrayLike) -> Held:
        """How the cables hold the arm in poses: tensions, stiffness, load factor, lengths to be commanded.

        Parameters
        ----------
        angles : (T, n, 2) rad
        gravity : (3,) or (T, 3) m/s²
            In the arm's own axes.

        Raises
        ------
        InputError
            Wrong shapes, or values that are not finite.
        """
        poses = self._angles(angles)
        downward = self._gravity(gravity, len(poses))
        largest = max(self.robot.cables, 2 * self.robot.sections) * 2 * self.robot.sections
        part = max(1, _LARGEST_PART // largest)
        parts = [
            self._hold(poses[start : start + part], downward[start : start + part])
            for start in range(0, max(1, len(poses)), part)
        ]
        return parts[0] if len(parts) == 1 else Held.joined(parts)

    def stiffness(self, angles: ArrayLike, tensions: ArrayLike, gravity: ArrayLike) -> tuple[Array, Array]:
        """Elastic and geometric stiffness (T, 2n, 2n) N m/rad with the motors held; their sum is the tangent stiffness.

        Parameters
        ----------
        angles : (T, n, 2) rad
        tensions : (T, c) N
        gravity : (3,) or (T, 3) m/s²

        Raises
        ------
        InputError
            Wrong shapes, or values that are not finite.
        """
        poses = self._angles(angles)
        pulls = floats("tensions", tensions, f"({len(poses)}, {self.robot.cables})", "N")
        lengths, jacobians = self._jacobians(poses)
        weight = self._weight(poses, gravity)[1]
        elastic = self._elastic(poses, jacobians, self.spring_constants(lengths))
        return elastic, weight + cables.geometric_stiffness(poses, *self.layout[:3], pulls)

    def settle(
        self, angles: ArrayLike, commanded: ArrayLike, gravity: ArrayLike, start: ArrayLike | None = None
    ) -> Settled:
        """Where the arm comes to rest whose motors hold cables at lengths that they have without tension.

        Parameters
        ----------
        angles : (T, n, 2) rad
            The poses that the lengths were meant for; the spring constants are those of the cables there.
        commanded : (T, c) m
        gravity : (3,) or (T, 3) m/s²
        start : (T, n, 2) rad, optional
            Where the arm is when the motors begin to move; in those poses unless given.

        Raises
        ------
        InputError
            Wrong shapes, or values that are not finite.
        """
        poses = self._angles(angles)
        final = coordinates("commanded", commanded, f"({len(poses)}, {self.robot.cables})")
        downward = self._gravity(gravity, len(poses))
        held = self.hold(poses, downward)
        arm = (*self.layout, self.pieces, self.tool_mass, self.springs)
        begin = poses
        if start is not None:
            begin = poses.copy()
            begin[..., :2] = floats("start", start, f"({len(poses)}, {self.robot.sections}, 2)", "rad")
        found = settle(
            begin, self.robot.bend_bounds, arm, downward, held.spring_constants, held.commanded_lengths, final
        )
        stable = found[2] == STABLE
        return Settled(*found, self._tip_shift(poses, found[0]), stable)

    def uncompensated(self, angles: ArrayLike, gravity: ArrayLike) -> Settled:
        """Where the arm comes to rest if cables are commanded without regard to weight and bending: pretension alone.

        Arguments as in `hold`.
        """
        lengths = self._jacobians(self._angles(angles))[0]
        return self.settle(angles, lengths - self.pretension / self.spring_constants(lengths), gravity)

    def _hold(self, angles: Array, downward: Array) -> Held:
        lengths, jacobians = self._jacobians(angles)
        torques, weight = gravity.gravity_of(angles, self.pieces, self.tool_mass, downward)
        torques = self._bent(angles, torques)
        count = self.robot.cables
        low, high = np.full(count, self.tension_min), np.full(count, self.tension_max)
        sections = self.robot.cable_sections
        pulls, left, status = tensions.distribute(jacobians, torques, sections, self.pretension, low, high)
        constants = self.spring_constants(lengths)
        elastic = self._elastic(angles, jacobians, constants)
        weight += cables.geometric_stiffness(angles, *self.layout[:3], pulls)
        return Held(
            lengths,
            pulls,
            constants,
            left,
            status,
            stiffness.load_factors(elastic, weight),
            partial(self._softest, angles, pulls, downward),
        )

    def _softest(self, angles: Array, pulls: Array, downward: Array) -> Array:
        elastic, geometric = self.stiffness(angles, pulls, downward)
        return stiffness.smallest_eigenvalues(elastic + geometric)

    def _tip_shift(self, planned: Array, reached: Array) -> Array:
        lengths = self.robot.link_lengths * times_of(planned)
        tip = [self.robot.joint_positions(angles, 0.0, lengths)[:, -1] for angles in (angles_of(planned), reached)]
        return tip[1] - tip[0]

    def _jacobians(self, angles: Array) -> tuple[Array, Array]:
        return cables.jacobians_of(angles, *self.layout)

    def _weight(self, angles: Array, downward: ArrayLike) -> tuple[Array, Array]:
        return gravity.gravity_of(angles, self.pieces, self.tool_mass, self._gravity(downward, len(angles)))

    def _bent(self, angles: Array, torques: Array) -> Array:
        """Torques (T, 2n) of the weight with those of bending."""
        if not self.springs.any():
            return torques
        return torques + self._springs_in(angles) * angles_of(angles).reshape(len(angles), -1)

    def _springs_in(self, angles: Array) -> Array:
        """What all angles spring back with (T, 2n) N m/rad: a rod that is longer does with less."""
        return self.springs / np.repeat(times_of(angles), 2, axis=1)

    def _elastic(self, angles: Array, jacobians: Array, constants: Array) -> Array:
        """The elastic stiffness of cables and of bending."""
        elastic = stiffness.elastic_stiffness(jacobians, self.robot.cable_sections, constants)
        if self.springs.any():
            diagonal = np.arange(self.springs.size)
            elastic[:, diagonal, diagonal] += self._springs_in(angles)
        return elastic

    def _angles(self, angles: ArrayLike) -> Array:
        return checked(self.robot, angles)

    def _gravity(self, given: ArrayLike, steps: int) -> Array:
        array = floats("gravity", given, "(..., 3)", "m/s²", _LARGEST_GRAVITY)
        if array.shape not in ((3,), (steps, 3)):
            raise InputError(f"gravity: expected shape (3,) or ({steps}, 3), one for every step, got {array.shape}")
        return np.array(np.broadcast_to(array, (steps, 3)), order="C")


def why_unknown(robot: Robot) -> str:
    """Why the mechanics of a robot are not known, in words for a message; empty if they are."""
    if robot.spec.cables is None:
        return (
            "the robot file has no table [cables]; give axial_stiffness_N, free_length, pretension_N, tension_min_N "
            "and tension_max_N there, and plan again"
        )
    if robot.sections > MOST_SECTIONS:
        return f"{robot.sections:,} sections are too many; at most {MOST_SECTIONS}"
    return ""
