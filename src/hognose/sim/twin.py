"""The twin of an arm: it moves as its cables, its weight and its contacts make it move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.arguments import instance
from hognose.errors import InputError
from hognose.files.exports.jointed_arm import JointedArm
from hognose.files.exports.mjcf import DRIVE, DRIVE_DAMPING, bare
from hognose.files.exports.mjcf_cables import DAMPING
from hognose.files.exports.mounting import Mounting
from hognose.files.exports.subject import Subject
from hognose.files.exports.xml import document
from hognose.mechanics import Mechanics
from hognose.mechanics.stiffness import load_factors
from hognose.planning import Task
from hognose.sim import contact
from hognose.sim.cable_forces import PRESLIDING, CableForces
from hognose.sim.changes import Changes
from hognose.sim.contact import Contact, Touch
from hognose.sim.mujoco_import import mujoco

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
        self._mj, self._task = mujoco(), task
        self._mounting = Mounting.of(task.base, task.robot)
        self._model = self._mj.MjModel.from_xml_string(document(bare(Subject.of_task(task), JointedArm.of(task.robot))).decode())
        self._links = self._bodies()
        self._model.body_mass[self._links] *= changes.mass
        self._model.body_inertia[self._links] *= changes.mass
        self._data = self._mj.MjData(self._model)
        links, data = self._links, self._data
        # Views, which MuJoCo fills: a step must not take longer than the integration.
        self._joints = data.xpos[links[0] : links[-1] + 1]
        self._first = int(self._mounting.kind != "pose")
        first = self._first
        self._q, self._rates, self._torques = data.qpos[first:].reshape(-1, 2), data.qvel[first:], data.qfrc_applied
        self._per_feed = 1.0 / (self._mounting.radius or 1.0)
        if self._first:  # as the joint's own, MuJoCo integrates it implicitly: as a force it would be unstable
            self._model.dof_damping[0] = DRIVE_DAMPING / self._per_feed**2
        self._forces = CableForces.of(self.mechanics)
        self._zeros = changes.zeros(task.robot)
        self._contact = Contact(task.robot, *changes.space(task.scene, task.moving))
        self._jacobian = np.zeros((3, self._model.nv))
        self._passed = 0.0

    def _bodies(self) -> list[int]:
        """The bodies of the links and of the tip, which weigh something."""
        count = self._task.robot.sections
        return [*(self._model.body(f"link_{i:02d}").id for i in range(1, count + 1)), self._model.body("tip").id]

    @property
    def time_step(self) -> float:
        """Of the integration, s."""
        return float(self._model.opt.timestep)

    @time_step.setter
    def time_step(self, step: float) -> None:
        self._model.opt.timestep = step

    @property
    def angles(self) -> Array:
        """Joint angles (n, 2) rad."""
        return self._q.copy()

    @property
    def joints(self) -> Array:
        """Joints and tip (n+1, 3) m in the frame of the task."""
        self._mj.mj_kinematics(self._model, self._data)
        return self._joints.copy()

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
        return abs(self._data.time - self._passed) > 0.5 * self.time_step  # then it begins anew by itself

    @property
    def crossed(self) -> tuple[int, str] | None:
        """The link (0-based) whose axis has crossed a surface, and the obstacle's name."""
        return self._contact.crossed

    def inside(self, time: float = 0.0) -> tuple[int, str] | None:
        """The first link (0-based) inside an obstacle at a time (s) on the clock of what moves, and its name."""
        return self._contact.inside(self.joints, time)

    def put(self, at: Array, angles: Array, commanded: Array | None = None) -> None:
        """Set it to rest with its base at coordinates (k,) and at angles (n, 2) rad.

        The motors command lengths without tension (c,) m; unless given, those that hold the arm there.
        """
        data = self._data
        self._mj.mj_resetData(self._model, data)
        self._passed = 0.0
        self.carry(at)
        if self._first:
            data.qpos[0] = at[0] * self._per_feed
        data.qpos[self._first :] = angles.ravel()
        self._mj.mj_forward(self._model, data)
        if commanded is None:
            held = self.mechanics.hold(angles[None], self._task.gravity(at[None])[0])
            lengths = held.commanded_lengths[0]
        else:
            lengths = commanded + self._zeros
        self._forces.loosen()
        self._forces.pull(angles, data.qvel[self._first :], lengths, np.zeros(self._task.robot.cables))

    def resting(self, at: Array, angles: Array, commanded: Array) -> Array | None:
        """Angles (n, 2) rad at which it rests that is to be at some; None if it would buckle.

        The base is at coordinates (k,), and the motors command lengths without tension (c,) m.
        """
        lengths, downward = (commanded + self._zeros)[None], self._task.gravity(at[None])
        found = self.mechanics.settle(angles[None], lengths, downward)
        return found.angles[0] if found.is_stable[0] else None

    def carry(self, at: Array) -> None:
        """Put a base at coordinates (k,) if it is carried; any other is driven, and goes by itself."""
        if not self._first:
            self._data.mocap_pos[0], self._data.mocap_quat[0] = at[:3], at[3:]

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
        data, first, torques = self._data, self._first, self._torques
        self.carry(at)
        self._mj.mj_step1(self._model, data)
        step = self._model.opt.timestep
        torques[first:] = self._forces.pull(self._q, self._rates, commanded + self._zeros, speeds, step)
        if first:  # along the feed, whatever turns a drum
            ahead = at[0] - data.qpos[0] / self._per_feed
            torques[0] = (DRIVE * ahead + DRIVE_DAMPING * at_speed[0]) / self._per_feed
        self._touch(torques, time)
        self._mj.mj_step2(self._model, data)
        self._passed += self._model.opt.timestep

    def _touch(self, applied: Array, time: float) -> None:
        """Add what obstacles do."""
        self.touches, self._pushed = [], []
        for touch in self._contact.touches(self._joints, time):
            body = self._links[touch.link]
            self._mj.mj_jac(self._model, self._data, self._jacobian, None, touch.place, body)
            out = touch.normal @ self._jacobian  # how fast the place leaves where it is, by the joints' rates
            leaving = float(out @ self._data.qvel - touch.normal @ touch.velocity)
            force = max(0.0, contact.STIFFNESS * touch.depth - contact.DAMPING * leaving)
            applied += force * out
            self.touches.append((touch, force))
            self._pushed.append(out[self._first :].copy())

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
        robot, mechanics, pulls = self._task.robot, self.mechanics, self._forces.tensions
        at = self.base
        mean = (pulls * self._forces.means)[None]
        elastic, rest = mechanics.stiffness(self.angles[None], mean, self._task.gravity(at[None])[0])
        slack = pulls <= 0
        if slack.any():
            k = mechanics.spring_constants(robot.cable_lengths(self.angles))[slack]
            elastic = elastic - np.einsum("c,ci,cj->ij", k, self._forces.jacobian[slack], self._forces.jacobian[slack])
        for out in self._pushed:
            elastic = elastic + contact.STIFFNESS * np.outer(out, out)
        return elastic, rest

    @property
    def base(self) -> Array:
        """Coordinates (k,) of the base."""
        if self._first:
            return self._data.qpos[:1] / self._per_feed
        return np.concatenate([self._data.mocap_pos[0], self._data.mocap_quat[0]])

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
        model, data, first = self._model, self._data, self._first
        mass = np.zeros((model.nv, model.nv))
        self._mj.mj_fullM(model, data, mass)
        mass = mass[first:, first:] + step * np.diag(model.dof_damping[first:])
        J = self._forces.jacobian
        k = self.mechanics.spring_constants(self._forces.lengths)
        k = k + self._forces.tensions * self.mechanics.friction * bends / PRESLIDING
        n = len(mass)
        by_angle, by_rate = np.linalg.solve(mass, J.T * k @ J), np.linalg.solve(mass, DAMPING * J.T @ J)
        by_rate += np.linalg.solve(mass, np.diag(model.dof_damping[first:]))
        rates = np.hstack([-step * by_angle, np.eye(n) - step * by_rate])
        whole = np.vstack([np.hstack([np.eye(n), np.zeros((n, n))]) + step * rates, rates])
        return float(np.abs(np.linalg.eigvals(whole)).max())
