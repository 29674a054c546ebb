"""The body of an arm whose sections are not all links: two angles a section move all the joints and arcs of it.

MuJoCo has the arm as parts with hinges, q of them (`hognose.files.exports.jointed_arm`), with arcs as chains of small
joints. The values of these are linear in the velocities' coordinates x, the base's and the 2n angles: G x. So with the
mass M and the forces f of the parts, which MuJoCo finds, the equations of motion of the sections are, exactly,

    Gᵀ M G ẍ = Gᵀ f + applied.

Nothing but these coordinates moves: there is no constraint that could give way, and no small joint whose own swing
would need small steps. Springs, dampers, stops and touches are integrated implicitly. Where the body is, is not taken
from the chains but from the sections themselves.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hognose.mechanics import postures
from hognose.planning import Task
from hognose.robot.sections import MixedSections
from hognose.robot.sections.chain import vertices_along
from hognose.sim.contact import Touch
from hognose.sim.link_body import Model

Array = NDArray[np.float64]

#: [assumed] A stop at a bend limit resists with so many times what the cables do, and for so long (s) to its motion.
_STOP, _STOP_TIME = 30.0, 0.01
#: Coordinates that change faster than this (rad/s or m/s) are no figures of an arm any more.
_FASTEST = 1e6


class SectionBody(Model):
    """An arm of sections of any kinds; attributes as of `LinkBody`, `line` being the ends (p+1, 3) m of its chords."""

    def __init__(self, task: Task, mass: float, elastic: Array) -> None:
        """The body of a task's arm, with its masses times a factor; cables resist its angles with (2n,) N m/rad."""
        super().__init__(task, mass)
        robot, first = task.robot, self.first
        assert isinstance(robot.model, MixedSections), "links alone are a LinkBody"
        self._robot, self._sections = robot, robot.model
        count = first + 2 * robot.sections
        self._x, self.velocity, self.applied = np.zeros(count), np.zeros(count), np.zeros(count)
        self.angles, self.rates = self._x[first:].reshape(-1, 2), self.velocity[first:]
        self._G = np.zeros((self.model.nv, count))
        self._G[:first, :first] = np.eye(first)
        self._G[first:, first:] = self.arm.shares
        self._stiff, self._owners = self.model.jnt_stiffness.copy(), np.argmax(self.arm.shares != 0.0, axis=1)
        self._springs_at_rest = self._reduced(np.diag(self._stiff)).diagonal()[first:]
        self._springs = np.append(np.zeros(first), self._springs_at_rest)
        self.sections, self.longer = robot.link_lengths.copy(), np.zeros(robot.sections) if robot.extends else None
        self._stops, self._bounds = _STOP * elastic, robot.bend_bounds.reshape(-1, 2).T
        self._none, self._dampers = np.zeros(2 * robot.sections), (self._G.T * self.model.dof_damping) @ self._G
        self._chain = np.zeros((3, self.model.nv))
        self._bias, self._mass = np.zeros(self.model.nv), np.zeros((self.model.nv, self.model.nv))
        chords = len(robot.chord_sections)
        self._placed, self.line = np.zeros((1, chords + 1, 3)), np.zeros((chords + 1, 3))
        arcs = self._sections.arcs(robot.link_lengths)
        self._chord_arcs, self._chord_begins = arcs, np.append(0.0, np.cumsum(arcs[:-1]))
        self._part_begins = np.cumsum([part.shift for part in self.arm.parts[1:]])
        self._mount, self._broken = self.model.body("mount").id, False

    @property
    def driven(self) -> Array:
        """See `LinkBody.driven`."""
        return self._x[: self.first]

    def joints(self) -> Array:
        """See `LinkBody.joints`."""
        self._kinematics()
        return self._in_task(self._own_joints()[0])

    def points(self) -> Array:
        """See `LinkBody.points`."""
        self._kinematics()
        self._draw()
        return self.line.copy()

    @property
    def fell_apart(self) -> bool:
        """See `LinkBody.fell_apart`."""
        return self._broken

    @property
    def posture(self) -> Array:
        """See `LinkBody.posture`."""
        if self.longer is None:
            return self.angles
        return postures(self._robot, self.angles[None], self.sections[None])[0]

    def extend(self, lengths: Array, speeds: Array) -> None:
        """See `LinkBody.extend`: backbones that are longer spring back with less."""
        self.sections[:], self.longer = lengths, speeds
        times = np.repeat(lengths / self._robot.link_lengths, 2)
        self.model.jnt_stiffness[self.first :] = self._stiff[self.first :] / times[self._owners]
        self._springs[self.first :] = self._springs_at_rest / times

    def put(self, at: Array, angles: Array) -> None:
        """See `LinkBody.put`."""
        self.mj.mj_resetData(self.model, self.data)
        self._x[:], self.velocity[:], self.applied[:], self._broken = 0.0, 0.0, 0.0, False
        self.carry(at)
        if self.first:
            self._x[0] = at[0] * self.per_feed
        self.angles[:] = angles
        self.begin()

    def begin(self) -> None:
        """See `LinkBody.begin`."""
        mj, model, data = self.mj, self.model, self.data
        self._kinematics()
        mj.mj_comPos(model, data)
        mj.mj_crb(model, data)
        mj.mj_comVel(model, data)
        mj.mj_passive(model, data)
        mj.mj_rne(model, data, 0, self._bias)
        self._draw()

    def way(self, touch: Touch) -> Array:
        """See `LinkBody.way`."""
        begin, along = self.line[touch.chord], self.line[touch.chord + 1] - self.line[touch.chord]
        share = float(np.clip((touch.place - begin) @ along / (along @ along), 0.0, 1.0))
        at = self._chord_begins[touch.chord] + share * self._chord_arcs[touch.chord]
        part = int(np.searchsorted(self._part_begins[:-1], at, side="right")) - 1
        body = self._mount if part < 0 else self.bodies[part]
        self.mj.mj_jac(self.model, self.data, self._chain, None, touch.place, body)
        return touch.normal @ self._chain @ self._G

    def end(self, pushed: Sequence[Array], stiffness: float, damping: float) -> None:
        """Integrate a step with what is applied; touches push along ways (first + 2n,) as springs and dampers."""
        step, v = self.time_step, self.velocity
        forces = self._G.T @ (self.data.qfrc_passive - self._bias) + self.applied
        springs, dampers = np.diag(self._springs), self._dampers.copy()
        stops, turns = self._stopped()
        forces[self.first :] += turns
        diagonal = np.arange(self.first, len(v))
        springs[diagonal, diagonal] += stops
        dampers[diagonal, diagonal] += _STOP_TIME * stops
        for way in pushed:
            springs += stiffness * np.outer(way, way)
            dampers += damping * np.outer(way, way)
        whole = self._whole_mass() + step * dampers + step**2 * springs
        change = np.linalg.solve(whole, step * (forces - step * (springs @ v)))
        if not (np.abs(v + change) < _FASTEST).all():
            self._broken = True
            return
        v += change
        self._x += step * v

    def inertia(self) -> tuple[Array, Array, Array]:
        """See `LinkBody.inertia`."""
        first = self.first
        return (
            self._whole_mass()[first:, first:],
            self._dampers[first:, first:],
            np.diag(self._springs[first:]),
        )

    def _stopped(self) -> tuple[Array, Array]:
        """Springs (2n,) of the stops that are reached, and the torques (2n,) with which these push back."""
        q = self._x[self.first :]
        beyond = q - np.minimum(np.maximum(q, self._bounds[0]), self._bounds[1])
        if not beyond.any():
            return self._none, self._none
        outwards = beyond * self.rates > 0.0
        stops = np.where(beyond != 0.0, self._stops, 0.0)
        return stops, -stops * (beyond + np.where(outwards, _STOP_TIME * self.rates, 0.0))

    def _reduced(self, of_parts: Array) -> Array:
        return self._G.T @ of_parts @ self._G

    def _whole_mass(self) -> Array:
        self.mj.mj_fullM(self.model, self.data, self._mass)
        return self._reduced(self._mass)

    def _kinematics(self) -> None:
        self.data.qpos[:] = self._G @ self._x
        self.data.qvel[:] = self._G @ self.velocity
        if self.longer is not None:
            self.data.qpos[self.first :] += self.arm.length_shares @ (self.sections - self._robot.link_lengths)
            self.data.qvel[self.first :] += self.arm.length_shares @ self.longer
        self.mj.mj_kinematics(self.model, self.data)

    def _own_joints(self) -> Array:
        """Joints (1, n+1, 3) m in the mount's frame, which the arm leaves at its origin and along +z."""
        return self._sections.positions(self.angles[None], np.zeros(1), self.sections[None])[0]

    def _draw(self) -> None:
        model = self._sections
        arm = (model.table, model.counts, model.first, self._placed)
        if self._robot.extends:
            vertices_along(self.angles[None], self._own_joints(), *arm, model.scales(self.sections[None]))
        else:
            vertices_along(self.angles[None], self._own_joints(), *arm)
        self.line[:] = self._in_task(self._placed[0])

    def _in_task(self, points: Array) -> Array:
        data = self.data
        return data.xpos[self._mount] + points @ data.xmat[self._mount].reshape(3, 3).T
