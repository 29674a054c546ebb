"""An arm as other programs have it: rigid parts, hinges that follow each other, and how far that is from the arm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.cached import cached_property
from hognose.errors import InputError
from hognose.files.exports.arc_joints import cable_error, counts_of, errors_of
from hognose.files.exports.rigid_parts import Part, Turn, parts_of
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
        The farthest that a point of the arm's line is from where it is to be, at any angles within the limits: none if
        there are no arcs.
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

        Raises
        ------
        InputError
            Sections extend, which no chain of hinges does.
        """
        if robot.extends:
            raise InputError(
                f"the sections of {robot.name} change their length, and models for MuJoCo, ROS and others have hinges "
                "alone: write .csv, .parquet or .json, which have the lengths, or leave length_range out of the "
                "robot file to have a model of the arm at rest"
            )
        arcs = _arcs(robot)
        counts = [1] * robot.sections
        for i in arcs:
            behind = float(robot.link_lengths[i + 1 :].sum()) + robot.spec.tool_length * (i == robot.sections - 1)
            allowed = within * robot.length / len(arcs)
            for count in counts_of(_disks(robot, i)):
                counts[i] = count
                far, turned = _errors(robot, i, count)
                if far + turned * behind <= allowed:
                    break
        found = tuple(counts)
        return cls(robot, parts_of(robot, found), found, _off(robot, arcs, counts), _cables_off(robot, arcs, counts))

    @property
    def turns(self) -> list[Turn]:
        """All hinges, in the order of the parts and in that of each part."""
        return [turn for part in self.parts for turn in part.turns]

    @property
    def leading(self) -> dict[tuple[int, int], Turn]:
        """The first hinge of every section about each axis, which the others of it follow."""
        found: dict[tuple[int, int], Turn] = {}
        for turn in self.turns:
            found.setdefault((turn.section, turn.axis), turn)
        return found

    @property
    def following(self) -> list[tuple[Turn, Turn, float]]:
        """Hinges that follow another one: both, and by which factor."""
        leading, found = self.leading, []
        for turn in self.turns:
            first = leading[turn.section, turn.axis]
            if turn is not first:
                found.append((turn, first, turn.share / first.share))
        return found

    def bounds(self, turn: Turn) -> tuple[float, float]:
        """The lowest and the highest value (rad) of a hinge."""
        low, high = (turn.share * self.robot.bend_bounds[turn.section, turn.axis]).tolist()
        return low, high

    def spring(self, turn: Turn) -> float:
        """With what (N m/rad) a hinge springs back: all of a section together as its backbone does."""
        return float(self._springs[turn.section] / turn.share)

    def values(self, angles: Array, turns: Sequence[Turn] | None = None) -> Array:
        """Values (T, q) rad of hinges, all of them unless given, at angles (T, n, 2) rad of the sections."""
        chosen = self.turns if turns is None else turns
        return np.stack([turn.share * angles[:, turn.section, turn.axis] for turn in chosen], axis=1)

    @cached_property
    def _springs(self) -> Array:
        return bending_springs(self.robot)

    @cached_property
    def shares(self) -> Array:
        """Derivatives (q, 2n) of the values of all hinges by the angles (α₁, β₁, α₂, …) of the sections."""
        out = np.zeros((len(self.turns), 2 * self.robot.sections))
        for row, turn in enumerate(self.turns):
            out[row, 2 * turn.section + turn.axis] = turn.share
        return out

    def frames(self, angles: Array) -> tuple[Array, Array]:
        """Where the joints of all parts are (T, p, 3) m, mount and tip with them, and their frames (T, p, 3, 3).

        At angles (T, n, 2) rad, with the arm's first section beginning at the origin and along +z.
        """
        frame, place = np.repeat(np.eye(3)[None], len(angles), axis=0), np.zeros((len(angles), 3))
        places, frames = [], []
        for part in self.parts:
            place = place + part.shift * frame[:, :, 2]
            for turn in part.turns:
                frame = frame @ _about(turn.axis, turn.share * angles[:, turn.section, turn.axis])
            places.append(place)
            frames.append(frame)
        return np.stack(places, axis=1), np.stack(frames, axis=1)

    def cable_lengths(self, angles: Array) -> Array:
        """Lengths (T, c) m of the cables from hole to hole of the parts, at angles (T, n, 2) rad."""
        robot, (places, frames) = self.robot, self.frames(angles)
        around = np.stack([np.cos(robot.cable_azimuths), np.sin(robot.cable_azimuths)])
        out, last = np.zeros((len(angles), robot.cables)), None
        for p, part in enumerate(self.parts):
            for _, height in part.planes:
                holes = robot.cable_circles[:, part.section + 1] * around
                local = np.concatenate([holes, np.full((1, robot.cables), height)])
                here = places[:, p, :, None] + frames[:, p] @ local
                if last is not None:
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
        if any(count > 1 for count in self.counts):
            numbers = sorted({count for count in self.counts if count > 1})
            joints = " or ".join(map(str, numbers))
            told.append(
                f"sections that bend along their length are chains of {joints} universal joints, of which in every "
                "four the second and the third turn about x first: at any bends within "
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
    return errors_of(given.pitch, given.bend_limits, count)


def _off(robot: Robot, arcs: Sequence[int], counts: Sequence[int]) -> float:
    """How far (m) a point of the line is off at most: what sections before it are off, and turn it by."""
    far, turned, worst = 0.0, 0.0, 0.0
    for i, length in enumerate(robot.link_lengths.tolist()):
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
