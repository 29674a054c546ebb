"""The twin of an arm: it moves as its cables, its weight and its contacts make it move."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError, MissingExtraError
from hognose.files.exports.mjcf import DRIVE, DRIVE_DAMPING, bare
from hognose.files.exports.mjcf_cables import DAMPING
from hognose.files.exports.mounting import Mounting
from hognose.files.exports.subject import Subject
from hognose.files.exports.xml import document
from hognose.mechanics import Mechanics
from hognose.planning import Task
from hognose.scene import Scene
from hognose.scene.moving import parts_of
from hognose.sim import contact
from hognose.sim.cable_forces import CableForces
from hognose.sim.contact import Contact, Touch

Array = NDArray[np.float64]

#: A step whose free oscillation grows by more than this is too long.
_GROWTH = 1.0 + 1e-9


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
        Obstacles that stand elsewhere, by name: (3,) m.
    """

    stiffness: float = 1.0
    mass: float = 1.0
    cable_zeros: Array | None = None
    shifted: dict[str, tuple[float, float, float]] = field(default_factory=dict)

    def applied(self, mechanics: Mechanics) -> Mechanics:
        """The mechanics of the arm as it is."""
        links = mechanics.links * [1.0, self.mass, 1.0]
        stiff = self.stiffness * mechanics.axial_stiffness
        return replace(mechanics, links=links, tool_mass=self.mass * mechanics.tool_mass, axial_stiffness=stiff)

    def scene(self, scene: Scene) -> Scene:
        """The obstacles as they stand.

        Raises
        ------
        InputError
            No obstacle of a name.
        """
        unknown = [name for name in self.shifted if name not in scene.names]
        if unknown:
            raise InputError(f"shifted: no obstacle is called {unknown[0]!r}; there are {', '.join(scene.names)}")
        if not self.shifted:
            return scene
        shifts = [np.array(self.shifted.get(name, (0.0, 0.0, 0.0))) for name in scene.names]
        parts = zip(parts_of(scene), shifts, strict=True)
        return Scene.from_parts([replace(part, triangles=part.triangles + shift) for part, shift in parts])


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
            MuJoCo is not installed.
        """
        changes = Changes() if changes is None else changes
        self.mechanics = changes.applied(Mechanics.of(task.robot))
        self.touches, self._pushed = [], []
        self._mj, self._task = _mujoco(), task
        self._mounting = Mounting.of(task.base, task.robot)
        self._model = self._mj.MjModel.from_xml_string(document(bare(Subject.of_task(task))).decode())
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
        self._zeros = np.zeros(task.robot.cables) if changes.cable_zeros is None else np.asarray(changes.cable_zeros)
        self._contact = Contact(task.robot, changes.scene(task.scene))
        self._jacobian = np.zeros((3, self._model.nv))

    def _bodies(self) -> list[int]:
        """The bodies of the links and of the tip, which weigh something."""
        count = self._task.robot.sections
        return [*(self._model.body(f"link_{i:02d}").id for i in range(1, count + 1)), self._model.body("tip").id]

    @property
    def time_step(self) -> float:
        """Of the integration, s."""
        return float(self._model.opt.timestep)

    @property
    def angles(self) -> Array:
        """Joint angles (n, 2) rad."""
        return self._q.copy()

    @property
    def joints(self) -> Array:
        """Joints and tip (n+1, 3) m in the frame of the task."""
        return self._joints.copy()

    @property
    def tensions(self) -> Array:
        """Of the cables (c,) N at the last step."""
        return self._forces.tensions.copy()

    @property
    def crossed(self) -> tuple[int, str] | None:
        """The link (0-based) whose axis has crossed a surface, and the obstacle's name."""
        return self._contact.crossed

    def put(self, at: Array, angles: Array) -> None:
        """Set it to rest with its base at coordinates (k,) and at angles (n, 2) rad, its cables pulling as planned."""
        data = self._data
        self._mj.mj_resetData(self._model, data)
        if self._first:
            data.qpos[0] = at[0] * self._per_feed
        else:
            data.mocap_pos[0], data.mocap_quat[0] = at[:3], at[3:]
        data.qpos[self._first :] = angles.ravel()
        self._mj.mj_forward(self._model, data)
        held = self.mechanics.hold(angles[None], self._task.gravity(at[None])[0])
        self._forces.pull(
            angles, data.qvel[self._first :], held.commanded_lengths[0], np.zeros(self._task.robot.cables)
        )

    def step(self, commanded: Array, speeds: Array, at: Array, at_speed: Array) -> None:
        """One step of the integration.

        The motors command lengths without tension (c,) m that change at speeds (c,) m/s, and the base coordinates (k,)
        that change at (k,) a second.
        """
        data, first, torques = self._data, self._first, self._torques
        torques[first:] = self._forces.pull(self._q, self._rates, commanded + self._zeros, speeds)
        if first:  # along the feed, whatever turns a drum
            ahead = at[0] - data.qpos[0] / self._per_feed
            torques[0] = (DRIVE * ahead + DRIVE_DAMPING * at_speed[0]) / self._per_feed
        else:
            data.mocap_pos[0], data.mocap_quat[0] = at[:3], at[3:]
        self._touch(torques)
        self._mj.mj_step(self._model, data)

    def _touch(self, applied: Array) -> None:
        """Add what obstacles do."""
        self.touches, self._pushed = [], []
        for touch in self._contact.touches(self._joints):
            body = self._links[touch.link]
            self._mj.mj_jac(self._model, self._data, self._jacobian, None, touch.place, body)
            out = touch.normal @ self._jacobian  # how fast the place leaves the obstacle, by the joints' rates
            leaving = float(out @ self._data.qvel)
            force = max(0.0, contact.STIFFNESS * touch.depth - contact.DAMPING * leaving)
            applied += force * out
            self.touches.append((touch, force))
            self._pushed.append(out[self._first :].copy())

    def smallest_stiffness(self) -> float:
        """Smallest eigenvalue (N m/rad) of the tangent stiffness as it is; below 0 it buckles.

        Slack cables are none, and what is touched is a spring, too.
        """
        robot, mechanics, pulls = self._task.robot, self.mechanics, self._forces.tensions
        at = self._coordinates()
        elastic, rest = mechanics.stiffness(self.angles[None], pulls[None], self._task.gravity(at[None])[0])
        slack = pulls <= 0
        if slack.any():
            k = mechanics.spring_constants(robot.cable_lengths(self.angles))[slack]
            elastic = elastic - np.einsum("c,ci,cj->ij", k, self._forces.jacobian[slack], self._forces.jacobian[slack])
        for out in self._pushed:
            rest = rest + contact.STIFFNESS * np.outer(out, out)
        return float(np.linalg.eigvalsh(elastic + rest)[0, 0])

    def _coordinates(self) -> Array:
        """Coordinates (k,) of the base as it is."""
        if self._first:
            return self._data.qpos[:1] / self._per_feed
        return np.concatenate([self._data.mocap_pos[0], self._data.mocap_quat[0]])

    def refuse_long_steps(self) -> None:
        """Raise an InputError if the time step is too long for the stiffness, so that the arm would fly apart."""
        step, growth = self.time_step, self._growth(self.time_step)
        if growth <= _GROWTH:
            return
        fits = step
        while self._growth(fits) > _GROWTH and fits > 1e-9:
            fits /= 2
        raise InputError(
            f"time step: {1e3 * step:g} ms is too long for cables of EA {self.mechanics.axial_stiffness.max():.4g} N, "
            f"whose oscillation would grow by {growth:.3g} a step; {1e3 * fits:.3g} ms would do. Is EA right?"
        )

    def _growth(self, step: float) -> float:
        """By how much the free oscillation of the arm, as it is, grows in a step (s) of the integration."""
        model, data, first = self._model, self._data, self._first
        mass = np.zeros((model.nv, model.nv))
        self._mj.mj_fullM(model, data, mass)
        mass = mass[first:, first:] + step * np.diag(model.dof_damping[first:])
        J = self._forces.jacobian
        k = self.mechanics.spring_constants(self._forces.lengths)
        n = len(mass)
        by_angle, by_rate = np.linalg.solve(mass, J.T * k @ J), np.linalg.solve(mass, DAMPING * J.T @ J)
        by_rate += np.linalg.solve(mass, np.diag(model.dof_damping[first:]))
        rates = np.hstack([-step * by_angle, np.eye(n) - step * by_rate])
        whole = np.vstack([np.hstack([np.eye(n), np.zeros((n, n))]) + step * rates, rates])
        return float(np.abs(np.linalg.eigvals(whole)).max())


def _mujoco() -> Any:
    try:
        import mujoco
    except ImportError:
        raise MissingExtraError(
            "the twin needs the package mujoco; install it with: pip install 'hognose[sim]'"
        ) from None
    return mujoco
