"""The twin of an arm: it moves as its cables, its weight and its contacts make it move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.arguments import instance
from hognose.errors import InputError
from hognose.files.exports.mjcf import DRIVE, DRIVE_DAMPING
from hognose.files.exports.mjcf_cables import DAMPING
from hognose.mechanics import Mechanics, postures
from hognose.mechanics.postures import times_of
from hognose.mechanics.stiffness import load_factors
from hognose.planning import Task
from hognose.robot.sections import MixedSections
from hognose.sim import contact
from hognose.sim.cable_forces import PRESLIDING, CableForces
from hognose.sim.changes import Changes
from hognose.sim.contact import Contact, Touch
from hognose.sim.link_body import LinkBody
from hognose.sim.section_body import SectionBody

Array = NDArray[np.float64]

#: A shorter time step (s) would take longer than the arm itself.
SHORTEST_STEP = 5e-5
#: A step whose free oscillation grows by more than this is too long.
_GROWTH = 1.0 + 1e-9


class Twin:
    """An arm that moves; everything about it is as it is now.

    Attributes
    ----------
    mechanics
        Of the arm as it is, with its changes.
    touches
        Where it touched obstacles at the last step, with the force (N) of each.
    """

    mechanics: Mechanics
    touches: list[tuple[Touch, float]]

    def __init__(self, task: Task, changes: Changes | None = None) -> None:
        """The twin of a task's arm, straight and at feed 0.

        Raises
        ------
        InputError
            The mechanics of the robot are not known, or the changes do not fit.
        MissingExtraError
            MuJoCo is not installed, or cannot be imported.
        """
        instance("task", task, Task, "a hognose.Task")
        changes = Changes() if changes is None else instance("changes", changes, Changes, "a hognose.sim.Changes")
        self.mechanics = changes.applied(Mechanics.of(task.robot))
        self.touches, self._pushed = [], []
        self._task = task
        self._body = self._body_of(changes.mass)
        self._forces = CableForces.of(self.mechanics)
        self._zeros = changes.zeros(task.robot)
        self._contact = Contact(task.robot, *changes.space(task.scene, task.moving))

    def _body_of(self, mass: float) -> LinkBody | SectionBody:
        robot = self._task.robot
        if not isinstance(robot.model, MixedSections):
            return LinkBody(self._task, mass)
        straight = np.zeros((1, robot.sections, 2))
        elastic = self.mechanics.stiffness(straight, np.zeros((1, robot.cables)), np.zeros(3))[0]
        return SectionBody(self._task, mass, elastic[0].diagonal())

    @property
    def time_step(self) -> float:
        """Of the integration, s."""
        return self._body.time_step

    @time_step.setter
    def time_step(self, step: float) -> None:
        self._body.time_step = step

    @property
    def angles(self) -> Array:
        """Joint angles (n, 2) rad."""
        return self._body.angles.copy()

    @property
    def sections(self) -> Array:
        """Lengths (n,) m at which backbones hold the sections."""
        return self._task.robot.link_lengths * times_of(self._body.posture[None])[0]

    @property
    def joints(self) -> Array:
        """Joints and tip (n+1, 3) m in the frame of the task."""
        return self._body.joints()

    @property
    def tensions(self) -> Array:
        """Of the cables at their motors (c,) N at the last step."""
        return self._forces.tensions.copy()

    def tension_range(self) -> Array:
        """The smallest and the largest (2, c) N at the motors since this was asked last, and now."""
        now = self._forces.tensions
        found = np.stack([np.minimum(self._forces.extremes[0], now), np.maximum(self._forces.extremes[1], now)])
        self._forces.watch()
        return found

    @property
    def end_tensions(self) -> Array:
        """Of the cables where they are fixed (c,) N at the last step; friction makes the difference."""
        return self._forces.end_tensions

    @property
    def pressed(self) -> Array:
        """The force (n,) N with which each link was pressed at the last step."""
        out = np.zeros(self._task.robot.sections)
        for touch, force in self.touches:
            out[touch.link] += force
        return out

    @property
    def fell_apart(self) -> bool:
        """Whether the integration came to figures that are none."""
        return self._body.fell_apart

    @property
    def crossed(self) -> tuple[int, str] | None:
        """The link (0-based) whose axis has crossed a surface, and the obstacle's name."""
        return self._contact.crossed

    def inside(self, time: float = 0.0) -> tuple[int, str] | None:
        """The first link (0-based) inside an obstacle at a time (s) on the clock of what moves, and its name."""
        return self._contact.inside(self._body.points(), time)

    def extend(self, lengths: Array, speeds: Array) -> None:
        """From now on hold sections that extend at lengths (n,) m, which change at speeds (n,) m/s.

        They are as the backbones' drives hold them, whatever pulls. At the start they are as long as at rest.
        """
        self._body.extend(lengths, speeds)

    def put(self, at: Array, angles: Array, commanded: Array | None = None) -> None:
        """Set it to rest with its base at coordinates (k,) and at angles (n, 2) rad.

        The motors command lengths without tension (c,) m; unless given, those that hold the arm there.
        """
        self._body.put(at, angles)
        if commanded is None:
            held = self.mechanics.hold(self._body.posture[None], self._task.gravity(at[None])[0])
            lengths = held.commanded_lengths[0]
        else:
            lengths = commanded + self._zeros
        self._forces.loosen()
        self._forces.pull(self._body.posture, self._body.rates, lengths, np.zeros(self._task.robot.cables))

    def resting(self, at: Array, angles: Array, commanded: Array) -> Array | None:
        """Angles (n, 2) rad at which it rests that is to be at some; None if it would buckle.

        The base is at coordinates (k,), and the motors command lengths without tension (c,) m.
        """
        lengths, downward = (commanded + self._zeros)[None], self._task.gravity(at[None])
        planned = postures(self._task.robot, angles[None], self.sections[None])
        found = self.mechanics.settle(planned, lengths, downward)
        return found.angles[0] if found.is_stable[0] else None

    def carry(self, at: Array) -> None:
        """Put a base at coordinates (k,) if it is carried; any other is driven, and goes by itself."""
        self._body.carry(at)

    def step(self, commanded: Array, speeds: Array, at: Array, at_speed: Array, time: float = 0.0) -> None:
        """One step of the integration.

        Parameters
        ----------
        commanded, speeds : (c,) m, (c,) m/s
            Lengths without tension that the motors command now, and how these change.
        at, at_speed : (k,)
            Where the base is to be now, and how that changes in a second.
        time : s
            Now, on the clock of obstacles that move.
        """
        body, first = self._body, self._body.first
        body.carry(at)
        body.begin()
        applied = body.applied
        told = commanded + self._zeros, speeds, body.time_step, body.longer
        applied[first:] = self._forces.pull(body.posture, body.rates, *told)
        if first:  # along the feed, whatever turns a drum
            ahead = at[0] - body.driven[0] / body.per_feed
            applied[0] = (DRIVE * ahead + DRIVE_DAMPING * at_speed[0]) / body.per_feed
        pushed = self._touch(applied, time)
        body.end(pushed, contact.STIFFNESS, contact.DAMPING)

    def _touch(self, applied: Array, time: float) -> list[Array]:
        """Add what obstacles do; the ways along which they push as springs."""
        self.touches, self._pushed, pushed = [], [], []
        body = self._body
        for touch in self._contact.touches(body.line, time):
            out = body.way(touch)
            leaving = float(out @ body.velocity - touch.normal @ touch.velocity)
            force = max(0.0, contact.STIFFNESS * touch.depth - contact.DAMPING * leaving)
            applied += force * out
            self.touches.append((touch, force))
            self._pushed.append(out[body.first :].copy())
            if force > 0.0:
                pushed.append(out)
        return pushed

    def stability(self) -> tuple[float, float]:
        """Smallest eigenvalue (N m/rad) of the tangent stiffness as it is, and the load factor of buckling.

        Below 0, or 1, it buckles. Slack cables are none, and what is touched is a spring, too. By the load factor all
        tensions and the weight would have to grow.
        """
        elastic, rest = self._stiffnesses()
        smallest = float(np.linalg.eigvalsh(elastic + rest)[0, 0])
        return smallest, float(load_factors(elastic, rest)[0])

    def softest_section(self) -> int:
        """The section (0-based) that turns the most as the arm yields where it is softest."""
        elastic, rest = self._stiffnesses()
        way = np.linalg.eigh((elastic + rest)[0])[1][:, 0].reshape(-1, 2)
        return int(np.argmax(np.hypot(*way.T)))

    def _stiffnesses(self) -> tuple[Array, Array]:
        """Elastic and geometric stiffness (1, 2n, 2n) N m/rad as it is; see `stability`."""
        mechanics, pulls = self.mechanics, self._forces.tensions
        at = self.base
        mean = (pulls * self._forces.means)[None]
        posture = self._body.posture[None]
        elastic, rest = mechanics.stiffness(posture, mean, self._task.gravity(at[None])[0])
        slack = pulls <= 0
        if slack.any():
            k = mechanics.spring_constants(mechanics.cable_lengths(posture))[0, slack]
            elastic = elastic - np.einsum("c,ci,cj->ij", k, self._forces.jacobian[slack], self._forces.jacobian[slack])
        for out in self._pushed:
            elastic = elastic + contact.STIFFNESS * np.outer(out, out)
        return elastic, rest

    @property
    def base(self) -> Array:
        """Coordinates (k,) of the base."""
        return self._body.base(self._body.driven)

    def shorten_step(self, bends: float = 0.0) -> None:
        """Halve the time step until it is short enough for the stiffness, so that the arm does not fly apart.

        Cables that rub are stiffer: as all joints are to be bent, by so much altogether (rad).

        Raises
        ------
        InputError
            Not even `SHORTEST_STEP` is short enough.
        """
        while (growth := self._growth(self.time_step, bends)) > _GROWTH:
            if self.time_step < 2 * SHORTEST_STEP:
                mu = self.mechanics.friction
                rub, friction = (f" that rub with a coefficient of {mu:g}", " and friction") if mu * bends else ("", "")
                raise InputError(
                    f"time step: {1e3 * self.time_step:g} ms, the shortest, is too long for cables of EA "
                    f"{self.mechanics.axial_stiffness.max():.4g} N{rub}, whose oscillation would grow by {growth:.3g} "
                    f"a step. Is EA{friction} right?"
                )
            self.time_step /= 2

    def _growth(self, step: float, bends: float) -> float:
        """By how much the free oscillation of the arm, as it is, grows in a step (s) of the integration."""
        mass, damping, springs = self._body.inertia()
        mass = mass + step * damping + step**2 * springs
        J = self._forces.jacobian
        k = self.mechanics.spring_constants(self._forces.lengths)
        k = k + self._forces.tensions * self.mechanics.friction * bends / PRESLIDING
        n = len(mass)
        by_angle, by_rate = np.linalg.solve(mass, J.T * k @ J + springs), np.linalg.solve(mass, DAMPING * J.T @ J)
        by_rate += np.linalg.solve(mass, damping + step * springs)
        rates = np.hstack([-step * by_angle, np.eye(n) - step * by_rate])
        whole = np.vstack([np.hstack([np.eye(n), np.zeros((n, n))]) + step * rates, rates])
        return float(np.abs(np.linalg.eigvals(whole)).max())
