"""How good a spline is for the arm that follows it, and how that changes with its way-points.

Everything wanted is a residual that is zero where it is fulfilled: clearance of the links, bends, speeds, reach. The
derivatives hold the splines' parameters and, at bends, the frames before them: first order along the way to a minimum,
where sliding along the path changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.cached import cached_property
from hognose.path import Path
from hognose.path.constructors import sensitivity
from hognose.robot import Robot, bends
from hognose.robot.base import Base, axes_of
from hognose.route.fit.apart import room_of
from hognose.route.fit.base_rows import reach_row, turn_rates, turn_rows, workspace_rows
from hognose.route.fit.motion import Motion, frames, insertion, nose_of, touching
from hognose.route.fit.section_rows import section_frames, section_rows
from hognose.route.fit.tip_rows import tip_rows
from hognose.route.lengths import Lengths
from hognose.scene import Scene

Array = NDArray[np.float64]

#: What counts as one unit of a residual: a part of half the width needed; rad; a part of the joints' speed.
LENGTH_UNIT, HALF_DEGREE, SPEED_UNIT = 0.033, np.radians(0.5), 0.029
#: Parts of the limits that are made use of: the coarse steps see a little less than the fine ones.
BEND_PART, SPEED_PART = 0.985, 0.96
#: Clearances beyond this many times half the width needed are as good as any; they are looked for a little farther.
FAR, BEYOND = 1.9, 1.1
#: How deep (in parts of half the width needed) a link that cuts a surface seems to be at most.
DEEPEST = 1.0
#: Places that are passed over are looked at beside those whose clearance is so little (as above) above the smallest.
TIGHT = 0.5
#: What exceeds its limits is worse than what cuts surfaces by so many times half the width needed.
EXCEEDED = 30.0
#: Weight of the curve's bending, against clearance: it only decides what nothing else decides.
STIFFNESS = 0.05


@dataclass(frozen=True, eq=False)
class Objective:
    """What a route is wanted for.

    Attributes
    ----------
    base
        What the arm stands on.
    draw
        Makes the path, the slider's run in front, through way-points (m, 3) m.
    order
        Degree of the spline.
    feed_speed : m/s
    margin : m
        Clearance to be kept.
    guide : (g, 3) m
        A curve through the passage that touches nothing: where a link cuts a surface, this is where it shall go.
    free : (m-1,) bool
        Which way-points behind the entrance may move.
    tip_direction : (3,) or None
        Unit vector along which the nose shall point at the target.
    tip_cone : rad
        By how much it may differ.
    turn_speed : rad/s
        At most, of the arm's axes on a carrier.
    method
        How the arm follows, if its sections are no links.
    """

    robot: Robot
    base: Base
    scene: Scene
    draw: Callable[[Array], Path]
    order: int
    feed_speed: float
    margin: float
    guide: Array
    free: NDArray[np.bool_]
    tip_direction: Array | None = None
    tip_cone: float = np.pi
    turn_speed: float = np.inf
    method: str = "exact"

    @cached_property
    def lengths(self) -> Lengths:
        """What steps and tolerances are measured by."""
        return Lengths.of(self.robot, self.margin, self.base.reach(self.robot))

    @property
    def far(self) -> float:
        """Clearances (m) beyond this are as good as any."""
        return FAR * self.lengths.half

    @property
    def unit(self) -> float:
        """What counts as one unit of a residual of lengths, m."""
        return LENGTH_UNIT * self.lengths.half

    @property
    def joint_speed(self) -> float:
        """Limit, rad/s."""
        return float(np.radians(self.robot.spec.limits.joint_speed_deg_s))


@dataclass(frozen=True, eq=False)
class Judged:
    """A spline and what the arm makes of it.

    Attributes
    ----------
    way_points : (m, 3) m
    clearance : m
        The smallest of a link; below zero where links cut surfaces.
    excess
        By how much limits are exceeded, as a part of each, summed up over their worst places; 0 is feasible.
    """

    objective: Objective
    way_points: Array
    motion: Motion
    clearances: Array
    normals: Array
    chord: NDArray[np.int64]
    step: NDArray[np.int64]
    fraction: Array

    @property
    def clearance(self) -> float:
        """The smallest clearance of any link, m; below zero it is a guess."""
        return float(self.clearances.min())

    @cached_property
    def overruns(self) -> dict[str, float]:
        """How far each limit is used at its worst place: 1 is all of it."""
        robot, motion = self.objective.robot, self.motion
        speed = np.abs(self.speeds).max(initial=0.0) / self.objective.joint_speed
        used = {
            "bend": float(bends.used(motion.angles, robot.bend_bounds).max()),
            "speed": float(speed),
            "turn": float(self.turn_rates.max(initial=0.0) / self.objective.turn_speed),
            "reach": float(motion.feeds[-1] / self.objective.base.feed_limit(robot)),
        }
        if self.outside.any():
            used["workspace"] = 1.0 + float(np.linalg.norm(self.outside, axis=1).max() / robot.length)
        if self.objective.tip_direction is not None:
            used["tip"] = float(
                np.arccos(np.clip(self._tip @ self.objective.tip_direction, -1, 1)) / self.objective.tip_cone
            )
        return used

    @cached_property
    def outside(self) -> Array:
        """Ways (T, 3) m from where the base can take the first joint to where it would be."""
        return self.objective.base.outside(self.motion.joints[:, 0])

    @cached_property
    def turn_rates(self) -> Array:
        """How fast (T-1,) rad/s the base turns the arm's axes."""
        return turn_rates(self.objective.base, self.motion, self.objective.feed_speed)

    @property
    def feasible(self) -> bool:
        """Whether no limit is exceeded and the body does not touch itself, as far as the coarse steps show."""
        used = self.overruns
        within = used["bend"] <= 0.9995 and max(used["speed"], used["turn"]) <= 0.985 and max(used.values()) <= 1.0
        return within and self.touching is None

    @cached_property
    def touching(self) -> tuple[int, int, int] | None:
        """A step at which the body touches itself and the two links (0-based) that do, or None; see `touching`."""
        return touching(self.objective.robot, self.objective.base, self.motion)

    @property
    def score(self) -> float:
        """The larger the better, m: clearance if feasible, at most what is looked for; else far below."""
        if self.feasible:
            return min(self.clearance, self.objective.far)
        over = sum(max(0.0, part - 1.0) for part in self.overruns.values())
        return min(self.clearance - self.objective.margin, 0.0) - EXCEEDED * self.objective.lengths.half * (1.0 + over)

    @property
    def speeds(self) -> Array:
        """Joint speeds (T-1, n, 2) rad/s."""
        per_feed = np.diff(self.motion.angles, axis=0) / np.diff(self.motion.feeds)[:, None, None]
        return per_feed * self.objective.feed_speed

    @property
    def _tip(self) -> Array:
        return nose_of(self.objective.robot, self.objective.base, self.motion)

    def residuals(self, wanted: float, strict: float) -> tuple[Array, Array]:
        """Residuals (r,) and their derivatives (r, 3 f) by the coordinates of the free way-points.

        Parameters
        ----------
        wanted
            Clearance in m that every link shall have.
        strict
            Weight of the limits against it.
        """
        of_base = (self._reach_row(), self._workspace_rows(), self._turn_rows())
        limits = (self._bend_rows(), self._speed_rows(), of_base[0], self._tip_rows(), *of_base[1:])
        weighed = [(strict * value, strict * row) for value, row in limits]
        values, rows = zip(self._clearance_rows(wanted), self._stiffness_rows(), *weighed, strict=True)
        return np.concatenate(values), np.concatenate(rows)

    def merit(self, wanted: float, strict: float) -> float:
        """Sum of squared residuals, as `residuals` has them, without their derivatives."""
        robot, motion = self.objective.robot, self.motion
        short = np.maximum(wanted - self.clearances, 0.0) / self.objective.unit
        bent = np.maximum(bends.beyond(motion.angles, robot.bend_bounds, BEND_PART), 0.0) / HALF_DEGREE
        top = SPEED_PART * self.objective.joint_speed
        fast = np.maximum(np.abs(self.speeds) - top, 0.0) / (SPEED_UNIT * self.objective.joint_speed)
        others = (self._reach_row(), self._tip_rows(), self._workspace_rows(), self._turn_rows())
        over = sum(float(np.sum(value**2)) for value in (bent, fast, *(value for value, _ in others)))
        return float(np.sum(short**2) + np.sum(self._bending**2)) + strict**2 * over

    @property
    def _unknowns(self) -> int:
        return 3 * int(self.objective.free.sum())

    @cached_property
    def _sensitivity(self) -> tuple[Array, Array]:
        return sensitivity(self.way_points, self.objective.order)

    def _basis(self, u: Array, derivative: int = 0) -> Array:
        """How much the curve at parameters u (...) moves with each free way-point (..., f)."""
        breaks, rates = self._sensitivity
        segment = np.clip(np.searchsorted(breaks, u, side="right") - 1, 0, len(breaks) - 2)
        h = np.maximum(u - breaks[segment], 0.0)[..., None]
        chosen = rates[segment][..., self.objective.free]
        out = np.zeros((*u.shape, chosen.shape[-1]))
        for j in range(rates.shape[1] - 1, derivative - 1, -1):
            factor = float(np.prod(np.arange(j, j - derivative, -1))) if derivative else 1.0
            out = out * h + factor * chosen[..., j, :]
        return np.where((u >= breaks[0])[..., None], out, 0.0)

    @cached_property
    def _joint_basis(self) -> Array:
        return self._basis(self.motion.parameters)

    @cached_property
    def _line_basis(self) -> Array:
        return self._joint_basis if self.objective.robot.straight_links else self._basis(self.motion.feet)

    def _clearance_rows(self, wanted: float) -> tuple[Array, Array]:
        rows = np.flatnonzero(self.clearances < wanted)
        chord, step, part = self.chord[rows], self.step[rows], self.fraction[rows, None]
        moved = (1 - part) * self._line_basis[step, chord] + part * self._line_basis[step, chord + 1]
        slope = -moved[:, :, None] * self.normals[rows][:, None, :]
        short = (wanted - self.clearances[rows]) / self.objective.unit
        return short, slope.reshape(len(rows), self._unknowns) / self.objective.unit

    @cached_property
    def _frames(self) -> Array:
        make = frames if self.objective.robot.straight_links else section_frames
        return make(self.motion.angles, axes_of(self.objective.base, self.motion.at))

    def _angle_rows(self, step: NDArray[np.int64], section: NDArray[np.int64], axis: NDArray[np.int64]) -> Array:
        """Derivatives (q, 3 f) of chosen joint angles."""
        lengths, basis, frame = self.objective.robot.link_lengths, self._joint_basis, self._frames
        if not self.objective.robot.straight_links:
            rows = section_rows(self._basis(self.motion.parameters, 1), frame, step, section, axis)
            return rows.reshape(len(step), self._unknowns)
        sign = np.where(axis == 0, 1.0, -1.0)[:, None]
        behind = sign * frame[step, section + 1, :, axis] / lengths[section, None]
        before = sign * frame[step, section, :, axis] / lengths[np.maximum(section - 1, 0), None]
        before[section == 0] = 0.0
        previous = basis[step, np.maximum(section - 1, 0)]
        here, after = basis[step, section], basis[step, section + 1]
        out = (after - here)[:, :, None] * behind[:, None, :] - (here - previous)[:, :, None] * before[:, None, :]
        return out.reshape(len(step), self._unknowns)

    def _bend_rows(self) -> tuple[Array, Array]:
        angles = self.motion.angles
        over = bends.beyond(angles, self.objective.robot.bend_bounds, BEND_PART)
        chosen = np.nonzero(over > 0)
        sign = np.sign(angles[chosen])
        return over[chosen] / HALF_DEGREE, sign[:, None] * self._angle_rows(*chosen) / HALF_DEGREE

    def _speed_rows(self) -> tuple[Array, Array]:
        speeds = self.speeds
        over = np.abs(speeds) - SPEED_PART * self.objective.joint_speed
        step, section, axis = chosen = np.nonzero(over > 0)
        fed = self.motion.feeds[step + 1] - self.motion.feeds[step]
        rate = self.objective.feed_speed / fed * np.sign(speeds[chosen])
        rows = self._angle_rows(step + 1, section, axis) - self._angle_rows(step, section, axis)
        return over[chosen] / (SPEED_UNIT * self.objective.joint_speed), rate[:, None] * rows / (
            SPEED_UNIT * self.objective.joint_speed
        )

    def _reach_row(self) -> tuple[Array, Array]:
        robot, motion, unit = self.objective.robot, self.motion, self.objective.unit
        over = motion.feeds[-1] - self.objective.base.feed_limit(robot) + 0.2 * unit
        return reach_row(over, unit, motion, robot.link_lengths, self._joint_basis)

    def _workspace_rows(self) -> tuple[Array, Array]:
        return workspace_rows(self.outside, self.objective.unit, self._joint_basis)

    def _turn_rows(self) -> tuple[Array, Array]:
        most, speed = self.objective.turn_speed, self.objective.feed_speed
        over = self.turn_rates - SPEED_PART * most
        return turn_rows(over, SPEED_UNIT * most, self.motion, self._joint_basis, speed)

    def _tip_rows(self) -> tuple[Array, Array]:
        wanted = self.objective
        return tip_rows(self.motion, self._tip, wanted.tip_direction, wanted.tip_cone, HALF_DEGREE, self._line_basis)

    @cached_property
    def _bending_sites(self) -> Array:
        breaks = self._sensitivity[0]
        return (breaks[:-1, None] + np.diff(breaks)[:, None] * np.array([0.1, 0.5, 0.9])).ravel()

    @cached_property
    def _bending(self) -> Array:
        """Second derivatives (3 s,) of the curve, in parts of what the joints can bend."""
        path, u = self.motion.path, self._bending_sites
        segment = np.clip(np.searchsorted(path.breaks, u, side="right") - 1, 0, len(path.breaks) - 2)
        h = (u - path.breaks[segment])[:, None]
        second = np.zeros((len(u), 3))
        for j in range(path.degree, 1, -1):
            second = second * h + j * (j - 1) * path.coefficients[segment, j]
        return STIFFNESS * self._link * second.ravel()

    @property
    def _link(self) -> float:
        return float(self.objective.robot.link_lengths.max() / self.objective.robot.bend_limits.min()) * np.sqrt(10.0)

    def _stiffness_rows(self) -> tuple[Array, Array]:
        basis = STIFFNESS * self._link * self._basis(self._bending_sites, 2)
        rows = basis[:, None, :, None] * np.eye(3)[None, :, None, :]
        return self._bending, rows.reshape(len(basis) * 3, -1)


def judge(objective: Objective, way_points: Array) -> Judged | None:
    """What the arm makes of a spline; None where it cannot follow it."""
    motion = insertion(objective.draw(way_points), robot := objective.robot, objective.base, objective.method)
    if motion is None:
        return None
    upper = BEYOND * objective.far + float(robot.chord_radii.max())
    lengths, guide = objective.lengths, objective.guide
    found = room_of(motion, robot, objective.scene, upper, guide, DEEPEST * lengths.half, TIGHT * lengths.half)
    return Judged(objective, way_points, motion, *found)
