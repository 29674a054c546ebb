"""An arm as other programs have it: rigid parts, joints that follow each other, and how far that is from the arm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.cached import cached_property
from hognose.files.exports.arc_joints import cable_error, counts_of, errors_of
from hognose.files.exports.rigid_parts import Joint, Part, parts_of
from hognose.robot import Robot
from hognose.robot.backbone import bending_springs
from hognose.robot.sections import MixedSections

Array = NDArray[np.float64]

#: Arcs have so many joints that no point of the arm's line is off by more than this share of the arm's length.
WITHIN = 1e-3


@dataclass(frozen=True, eq=False)
class JointedArm:
    """An arm of rigid parts.

    Attributes
    ----------
    robot
    parts
        The mount, then all parts from the base to the tip, which is the last.
    counts : (n,)
        Of how many joints each section is, if it is an arc; 1 otherwise.
    off : m
        The farthest that a point of the arm's line is from where it is to be, at any angles and lengths within the
        limits: none if there are no arcs.
    cables_off : m
        By how much the length of a cable is off at most.
    """

    robot: Robot
    parts: tuple[Part, ...]
    counts: tuple[int, ...]
    off: float
    cables_off: float

    @classmethod
    def of(cls, robot: Robot, within: float = WITHIN) -> JointedArm:
        """The parts of an arm, its arcs as chains that leave its line by a share of its length at most.

        Where even the longest chains leave it farther, they are taken all the same: `off` is what is right.
        """
        arcs = _arcs(robot)
        counts = [1] * robot.sections
        for i in arcs:
            behind = float(robot.length_bounds[i + 1 :, 1].sum()) + robot.spec.tool_length * (i == robot.sections - 1)
            allowed = within * robot.length / len(arcs)
            for count in counts_of(_disks(robot, i)):
                counts[i] = count
                far, turned = _errors(robot, i, count)
                if far + turned * behind <= allowed:
                    break
        found = tuple(counts)
        return cls(robot, parts_of(robot, found), found, _off(robot, arcs, counts), _cables_off(robot, arcs, counts))

    @property
    def joints(self) -> list[Joint]:
        """All hinges and slides, in the order of the parts and in that of each part."""
        return [joint for part in self.parts for joint in part.joints]

    @property
    def leading(self) -> dict[tuple[int, int], Joint]:
        """The first joint of every section about each axis, and its first slide, which the others of it follow."""
        found: dict[tuple[int, int], Joint] = {}
        for joint in self.joints:
            found.setdefault((joint.section, joint.axis), joint)
        return found

    @property
    def following(self) -> list[tuple[Joint, Joint, float]]:
        """Joints that follow another one: both, and by which factor."""
        leading, found = self.leading, []
        for joint in self.joints:
            first = leading[joint.section, joint.axis]
            if joint is not first:
                found.append((joint, first, joint.share / first.share))
        return found

    def slides(self, section: int) -> list[Joint]:
        """The slides of a section (0-based) that extends, from the base on: together they are as much longer as it."""
        return [joint for joint in self.joints if joint.slides and joint.section == section]

    def bounds(self, joint: Joint) -> tuple[float, float]:
        """The lowest and the highest value of a hinge (rad) or of a slide (m)."""
        if joint.slides:
            longer = self.robot.length_bounds[joint.section] - self.robot.link_lengths[joint.section]
            low, high = (joint.share * longer).tolist()
        else:
            low, high = (joint.share * self.robot.bend_bounds[joint.section, joint.axis]).tolist()
        return low, high

    def spring(self, joint: Joint) -> float:
        """With what (N m/rad) a hinge springs back: all of a section together as its backbone does; a slide with 0."""
        return 0.0 if joint.slides else float(self._springs[joint.section] / joint.share)

    def values(self, angles: Array, lengths: Array | None = None, joints: Sequence[Joint] | None = None) -> Array:
        """Values (T, q) of hinges (rad) and slides (m), all of them unless some are given.

        At angles (T, n, 2) rad of the sections, and at lengths (T, n) m of them: those at rest unless given.
        """
        chosen = self.joints if joints is None else joints
        return np.stack([self._value(joint, angles, lengths) for joint in chosen], axis=1)

    def _value(self, joint: Joint, angles: Array, lengths: Array | None) -> Array:
        if not joint.slides:
            return joint.share * angles[:, joint.section, joint.axis]
        if lengths is None:
            return np.zeros(len(angles))
        return joint.share * (lengths[:, joint.section] - self.robot.link_lengths[joint.section])

    @cached_property
    def _springs(self) -> Array:
        return bending_springs(self.robot)

    @cached_property
    def shares(self) -> Array:
        """Derivatives (q, 2n) of the values of all joints by the angles (α₁, β₁, α₂, …) of the sections."""
        out = np.zeros((len(self.joints), 2 * self.robot.sections))
        for row, joint in enumerate(self.joints):
            if not joint.slides:
                out[row, 2 * joint.section + joint.axis] = joint.share
        return out

    @cached_property
    def length_shares(self) -> Array:
        """Derivatives (q, n) of the values of all joints by the lengths of the sections."""
        out = np.zeros((len(self.joints), self.robot.sections))
        for row, joint in enumerate(self.joints):
            if joint.slides:
                out[row, joint.section] = joint.share
        return out

    def frames(self, angles: Array, lengths: Array | None = None) -> tuple[Array, Array]:
        """Where the joints of all parts are (T, p, 3) m, mount and tip with them, and their frames (T, p, 3, 3).

        At angles (T, n, 2) rad and lengths (T, n) m as of `values`, with the arm's first section beginning at the
        origin and along +z.
        """
        frame, place = np.repeat(np.eye(3)[None], len(angles), axis=0), np.zeros((len(angles), 3))
        places, frames = [], []
        for part in self.parts:
            place = place + part.shift * frame[:, :, 2]
            for joint in part.joints:
                value = self._value(joint, angles, lengths)
                if joint.slides:
                    place = place + value[:, None] * frame[:, :, 2]
                else:
                    frame = frame @ _about(joint.axis, value)
            places.append(place)
            frames.append(frame)
        return np.stack(places, axis=1), np.stack(frames, axis=1)

    def steps_of(self, part: Part) -> NDArray[np.bool_]:
        """Which cables (c,) are on another circle at once from the end of a part on: see `Part.steps`."""
        here, circles = part.section + 1, self.robot.cable_circles
        if not part.steps:
            return np.zeros(self.robot.cables, dtype=bool)
        return (self.robot.cable_sections > part.section) & (circles[:, here] != circles[:, here + 1])

    def cable_lengths(self, angles: Array, lengths: Array | None = None) -> Array:
        """Lengths (T, c) m of the cables from hole to hole of the parts, at angles and lengths as of `values`."""
        robot, (places, frames) = self.robot, self.frames(angles, lengths)
        around = np.stack([np.cos(robot.cable_azimuths), np.sin(robot.cable_azimuths)])
        out, last = np.zeros((len(angles), robot.cables)), None
        for p, part in enumerate(self.parts):
            planes = [(height, part.section + 1) for _, height in part.planes]
            if part.steps:
                planes.append((planes[-1][0], part.section + 2))
            for height, circle in planes:
                local = np.concatenate([robot.cable_circles[:, circle] * around, np.full((1, robot.cables), height)])
                here = places[:, p, :, None] + frames[:, p] @ local
                if last is not None and circle == part.section + 1:
                    out += np.linalg.norm(here - last, axis=1) * (robot.cable_sections >= part.section)
                last = here
        return out

    @cached_property
    def remarks(self) -> list[str]:
        """What a person should know of sections that are no links, in sentences."""
        told = []
        if self.following:
            told.append(
                "a section of several joints about one axis has one angle for all of them: the first joint leads and "
                "the others follow it, each by its share of the section's angle"
            )
        if self.robot.extends:
            told.append(
                "sections that extend have slides between their joints, zero at rest, which follow the first one of "
                "their section; bodies are drawn as at rest, and leave gaps or overlap where the section is longer or "
                "shorter"
            )
        if any(count > 1 for count in self.counts):
            numbers = sorted({count for count in self.counts if count > 1})
            joints, within = " or ".join(map(str, numbers)), "bends and lengths" if self.robot.extends else "bends"
            told.append(
                f"sections that bend along their length are chains of {joints} universal joints, of which in every "
                f"four the second and the third turn about x first: at any {within} within "
                f"the limits no point of the arm's line is off by more than {1e3 * self.off:.2g} mm, and no cable's "
                f"length by more than {1e3 * self.cables_off:.2g} mm"
            )
        return told


def _arcs(robot: Robot) -> list[int]:
    """Sections (0-based) that are bent along their length."""
    if not isinstance(robot.model, MixedSections):
        return []
    model = robot.model
    kinds = enumerate(zip(model.kinds, model.sections, strict=True))
    return [i for i, (kind, section) in kinds if any(piece.curved for piece in kind.pieces(section))]


def _disks(robot: Robot, section: int) -> int | None:
    assert isinstance(robot.model, MixedSections)
    return robot.model.sections[section].disks


def _errors(robot: Robot, section: int, count: int) -> tuple[float, float]:
    assert isinstance(robot.model, MixedSections)
    given = robot.model.sections[section]
    return errors_of(given.lengths[1], given.bend_limits, count)


def _off(robot: Robot, arcs: Sequence[int], counts: Sequence[int]) -> float:
    """How far (m) a point of the line is off at most: what sections before it are off, and turn it by."""
    far, turned, worst = 0.0, 0.0, 0.0
    for i, length in enumerate(robot.length_bounds[:, 1].tolist()):
        if i in arcs:
            own, own_turn = _errors(robot, i, counts[i])
            worst = max(worst, far + turned * length + own)
            tool = robot.spec.tool_length if i == robot.sections - 1 else 0.0
            far, turned = far + turned * length + own + own_turn * tool, turned + own_turn
        else:
            far += turned * length
        worst = max(worst, far)
    return worst


def _cables_off(robot: Robot, arcs: Sequence[int], counts: Sequence[int]) -> float:
    """By how much (m) the length of a cable is off at most: the sum over the arcs that it passes."""
    total = np.zeros(robot.cables)
    for i in arcs:
        assert isinstance(robot.model, MixedSections)
        passing = robot.cable_sections >= i
        holes = robot.cable_circles[passing, i : i + 2].max(axis=1), robot.cable_azimuths[passing]
        total[passing] += cable_error(robot.model.sections[i], counts[i], *holes)
    return float(total.max(initial=0.0))


def _about(axis: int, angles: Array) -> Array:
    """Rotations (T, 3, 3) about y, of axis 0, or about x."""
    c, s = np.cos(angles), np.sin(angles)
    zero, one = np.zeros_like(c), np.ones_like(c)
    rows = (c, zero, s, zero, one, zero, -s, zero, c) if axis == 0 else (one, zero, zero, zero, c, -s, zero, s, c)
    return np.stack(rows, axis=-1).reshape(-1, 3, 3)
