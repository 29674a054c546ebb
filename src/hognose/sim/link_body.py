"""The body of an arm of links alone, as MuJoCo integrates it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hognose.files.exports.jointed_arm import JointedArm
from hognose.files.exports.mjcf import DRIVE_DAMPING, bare
from hognose.files.exports.mounting import Mounting
from hognose.files.exports.subject import Subject
from hognose.files.exports.xml import document
from hognose.planning import Task
from hognose.sim.contact import Touch
from hognose.sim.mujoco_import import mujoco

Array = NDArray[np.float64]


#: Only masses and where touches push are those of chains of small joints, so arcs may be coarser than in a file.
_WITHIN = 5e-3


class Model:
    """What the bodies of all arms have in common: MuJoCo's model of the arm on its base.

    Attributes
    ----------
    first
        1 if the base is moved by a drive, whose coordinate comes before the angles; 0 if it is carried.
    per_feed
        Of that coordinate per metre of feed.
    """

    def __init__(self, task: Task, mass: float) -> None:
        """The model of a task's arm, its masses times a factor, straight and at feed 0.

        Raises
        ------
        MissingExtraError
            MuJoCo is not installed, or cannot be imported.
        """
        self.mj, self.arm = mujoco(), JointedArm.of(task.robot, _WITHIN)
        mounting = Mounting.of(task.base, task.robot)
        self.model = self.mj.MjModel.from_xml_string(document(bare(Subject.of_task(task), self.arm)).decode())
        #: The bodies of all parts and of the tip, which weigh something.
        self.bodies = [self.model.body(f"link_{part.label}").id for part in self.arm.parts[1:-1]]
        self.bodies.append(self.model.body("tip").id)
        self.model.body_mass[self.bodies] *= mass
        self.model.body_inertia[self.bodies] *= mass
        self.data = self.mj.MjData(self.model)
        self.first = int(mounting.kind != "pose")
        self.per_feed = 1.0 / (mounting.radius or 1.0)
        if self.first:  # as the joint's own, it is integrated implicitly: as a force it would be unstable
            self.model.dof_damping[0] = DRIVE_DAMPING / self.per_feed**2

    @property
    def time_step(self) -> float:
        """Of the integration, s."""
        return float(self.model.opt.timestep)

    @time_step.setter
    def time_step(self, step: float) -> None:
        self.model.opt.timestep = step

    def carry(self, at: Array) -> None:
        """Put a base at coordinates (k,) if it is carried; any other is driven, and goes by itself."""
        if not self.first:
            self.data.mocap_pos[0], self.data.mocap_quat[0] = at[:3], at[3:]

    def base(self, driven: Array) -> Array:
        """Coordinates (k,) of the base, of that (1,) of its drive."""
        if self.first:
            return driven / self.per_feed
        return np.concatenate([self.data.mocap_pos[0], self.data.mocap_quat[0]])


class LinkBody(Model):
    """An arm of links alone.

    Attributes
    ----------
    angles : (n, 2) rad
    velocity : (first + 2n,)
        Of the base's drive and of all angles, in rad/s; the last 2n are `rates`.
    applied : (first + 2n,)
        What acts on them in a step, for the caller to fill.
    line : (n+1, 3) m
        Joints and tip, as of the beginning of a step.
    longer : (n,) m/s
        How fast sections get longer; None if no section ever does.
    """

    longer: Array | None = None

    def __init__(self, task: Task, mass: float) -> None:
        super().__init__(task, mass)
        data, first, links = self.data, self.first, self.bodies
        # Views, which MuJoCo fills: a step must not take longer than the integration.
        self.line = data.xpos[links[0] : links[-1] + 1]
        self.angles, self.rates = data.qpos[first:].reshape(-1, 2), data.qvel[first:]
        self.velocity, self.applied = data.qvel, data.qfrc_applied
        self._jacobian, self._passed = np.zeros((3, self.model.nv)), 0.0

    @property
    def driven(self) -> Array:
        """The coordinate (1,) of the base's drive, or (0,)."""
        return self.data.qpos[: self.first]

    def joints(self) -> Array:
        """Joints and tip (n+1, 3) m."""
        self.mj.mj_kinematics(self.model, self.data)
        return self.line.copy()

    def points(self) -> Array:
        """Ends (p+1, 3) m of the body's chords: the joints."""
        return self.joints()

    @property
    def posture(self) -> Array:
        """Angles (n, 2) rad, or with the lengths of sections that extend a posture (n, 3), as mechanics ask."""
        return self.angles

    def extend(self, lengths: Array, speeds: Array) -> None:
        """Hold sections at lengths (n,) m, which change at speeds (n,) m/s; those of links never do."""

    @property
    def fell_apart(self) -> bool:
        """Whether the integration came to figures that are none."""
        return abs(self.data.time - self._passed) > 0.5 * self.time_step  # then it begins anew by itself

    def put(self, at: Array, angles: Array) -> None:
        """Set it to rest with its base at coordinates (k,) and at angles (n, 2) rad."""
        data = self.data
        self.mj.mj_resetData(self.model, data)
        self._passed = 0.0
        self.carry(at)
        if self.first:
            data.qpos[0] = at[0] * self.per_feed
        data.qpos[self.first :] = angles.ravel()
        self.mj.mj_forward(self.model, data)

    def begin(self) -> None:
        """Find where everything is at the beginning of a step."""
        self.mj.mj_step1(self.model, self.data)

    def way(self, touch: Touch) -> Array:
        """How fast (first + 2n,) the place of a touch leaves the obstacle, by the velocities."""
        self.mj.mj_jac(self.model, self.data, self._jacobian, None, touch.place, self.bodies[touch.link])
        return touch.normal @ self._jacobian

    def end(self, pushed: Sequence[Array], stiffness: float, damping: float) -> None:
        """Integrate a step with what is applied; the springs of touches are in that."""
        self.mj.mj_step2(self.model, self.data)
        self._passed += self.model.opt.timestep

    def inertia(self) -> tuple[Array, Array, Array]:
        """Mass (2n, 2n), damping (2n, 2n) and springs (2n, 2n) of the angles as they are."""
        mass = np.zeros((self.model.nv, self.model.nv))
        self.mj.mj_fullM(self.model, self.data, mass)
        damping = np.diag(self.model.dof_damping[self.first :])
        return mass[self.first :, self.first :], damping, np.zeros_like(damping)
