"""An arm as rigid parts with joints between them, as models of other programs have it.

A link is one part behind a universal joint, two hinges are two parts, a stack of joints is as many parts: all exact.
An arc is a chain of small joints, see `hognose.files.exports.arc_joints`. All joints of a section about one axis follow
the first of them.

An arc that extends has slides before its joints, whose values are shares of what it is longer than at rest. Its disks
are parts of their own, so that each slide belongs to one section and every disk is where it is to be at every length.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from hognose.files.exports.arc_joints import alpha_first
from hognose.files.exports.masses import link_inertia
from hognose.planning.columns import LABELS
from hognose.robot import Robot
from hognose.robot.sections import MixedSections, Piece

Array = NDArray[np.float64]

#: A body shorter than this (m) is not drawn: MuJoCo takes its ends for one point.
_THINNEST = 1e-6
#: No part weighs less than this share of its section: simulators take no body without any mass.
_LEAST = 1e-6
#: The axis of slides.
SLIDE = 2


@dataclass(frozen=True)
class Joint:
    """A hinge or a slide, which goes by a share of a coordinate of a section (0-based).

    Of axis 0, α about y, or 1, β about x; of axis 2 along z, by a share of what the section is longer than at rest.
    """

    name: str
    section: int
    axis: int
    share: float

    @property
    def slides(self) -> bool:
        """Whether it is a slide."""
        return self.axis == SLIDE


@dataclass(frozen=True)
class Part:
    """A rigid part; lengths along z, in m.

    Attributes
    ----------
    label
        `03`, or `03_07` for the seventh part of the third section.
    section
        0-based; -1 of the mount.
    shift
        From the joint of the part before to its own.
    joints
        Its hinges, which are in one place, in their order; before them a slide, if it has one, which moves this place
        along z of the part before.
    mass : kg
    centre
        Of the mass, from its joint.
    inertia : (3,) kg m²
    drawn
        From where to where a body is to be drawn from its joint on, and the section with its radius.
    planes
        Heights of its hole planes by their letters: `a` behind its joint, `b` before the next one.
    steps
        Whether cables are on the circles of the section behind it at once from its end on, with no way from their own
        to these: that section has no disks.
    """

    label: str
    section: int
    shift: float
    joints: tuple[Joint, ...] = ()
    mass: float = 0.0
    centre: float = 0.0
    inertia: Array | None = None
    drawn: tuple[tuple[float, float, int], ...] = ()
    planes: tuple[tuple[str, float], ...] = ()
    steps: bool = False


@dataclass(frozen=True)
class _Step:
    """A part before its neighbours are known: `behind` m from its joint to the end of its piece, `ahead` before it.

    Its joints are pairs of an axis and a share.
    """

    joints: tuple[tuple[int, float], ...]
    ahead: float
    behind: float
    planes: tuple[tuple[str, float], ...]


def parts_of(robot: Robot, counts: tuple[int, ...]) -> tuple[Part, ...]:
    """The mount, then all parts from the base to the tip; the last has no joints and is the tip.

    `counts` says of how many joints each section is to be, if it is an arc.
    """
    parts, before, from_section = [Part("00", -1, 0.0)], 0.0, -1
    first = {"b": -float(robot.joint_before[0])}
    parts[0] = replace(parts[0], planes=tuple(first.items()))
    labels = LABELS["link"](robot)
    for i in range(robot.sections):
        steps = list(_steps(robot, i, counts[i]))
        named = _names(steps, labels[i], i)
        parts[-1] = replace(parts[-1], steps=_diskless(robot, i))
        for j, (step, joints) in enumerate(zip(steps, named, strict=True)):
            _draw(parts, before, step.ahead, from_section, i)
            label = labels[i] if len(steps) == 1 else f"{labels[i]}_{_number(j, len(steps))}"
            mass, centre, inertia = _weight(robot, i, steps, j)
            parts.append(Part(label, i, before + step.ahead, joints, mass, centre, inertia, planes=step.planes))
            before, from_section = step.behind, i
    tool = robot.spec.tool_length
    straight = not isinstance(robot.model, MixedSections)
    before = float(robot.link_lengths[-1]) if straight else before + tool
    _draw(parts, before, 0.0, from_section, from_section)
    return (*parts, Part("tip", robot.sections - 1, before))


def _diskless(robot: Robot, i: int) -> bool:
    """Whether section i leads its cables all along."""
    if not isinstance(robot.model, MixedSections):
        return False
    section = robot.model.sections[i]
    return section.disks is None and any(piece.curved for piece in robot.model.kinds[i].pieces(section))


def _draw(parts: list[Part], before: float, ahead: float, section: int, following: int) -> None:
    """Say what is to be drawn of the last part: what is left of its own section, and what begins the next one."""
    rows = [(0.0, before, section)] if before > _THINNEST else []
    if ahead > 0.0 and section == following and rows:
        rows = [(0.0, before + ahead, section)]
    elif ahead > 0.0:
        rows.append((before, before + ahead, following))
    parts[-1] = replace(parts[-1], drawn=tuple(rows))


def _steps(robot: Robot, i: int, count: int) -> Iterator[_Step]:
    """The parts of section i, without the tool; an arc is of so many joints."""
    end = float(robot.disk_before_end[i])
    if not isinstance(robot.model, MixedSections):
        pitch, length = float(robot.pitches[i]), float(robot.link_lengths[i])
        yield _Step(((0, 1.0), (1, 1.0)), 0.0, length, (("a", float(robot.joint_after[i])), ("b", pitch - end)))
        return
    section = robot.model.sections[i]
    pieces = robot.model.kinds[i].pieces(section)
    for k, piece in enumerate(pieces):
        if piece.curved:
            extends = section.length_range is not None
            yield from (_extending_arc if extends else _arc)(piece, count, section.disks)
            continue
        shares = ((0, piece.alpha), (1, piece.beta))
        last = k == len(pieces) - 1
        # Two hinges have no hole planes between them: those of a section are around all its axes.
        within = (("a", section.after), ("b", piece.length - (end if last else section.before)))
        whole = piece.alpha != 0.0 and piece.beta != 0.0
        yield _Step(
            tuple((axis, share) for axis, share in shares if share), 0.0, piece.length, within if whole or last else ()
        )


def _arc(piece: Piece, count: int, disks: int | None) -> Iterator[_Step]:
    """The small joints of an arc, each in the middle of its part, where no disk is; disks are at ends of parts."""
    half, every = piece.length / (2 * count), 1 if disks is None else count // disks
    for j in range(count):
        yield _Step(_hinges(piece, count, j), half, half, (("a", half),) if (j + 1) % every == 0 else ())


def _extending_arc(piece: Piece, count: int, disks: int | None) -> Iterator[_Step]:
    """As `_arc`, with slides and a part for each disk: from a disk to a joint is half a part, as from it to a disk."""
    half, every = piece.length / (2 * count), 1 if disks is None else count // disks
    whole, part = (SLIDE, 1.0 / count), (SLIDE, 0.5 / count)
    for j in range(count):
        slide = part if j % every == 0 else whole
        yield _Step((slide, *_hinges(piece, count, j)), half, half, ())
        if (j + 1) % every == 0:
            yield _Step((part,), 0.0, 0.0, (("a", 0.0),))


def _hinges(piece: Piece, count: int, joint: int) -> tuple[tuple[int, float], ...]:
    """The two hinges of a joint of an arc, in their order."""
    shares = ((0, piece.alpha / count), (1, piece.beta / count))
    return shares if alpha_first(joint) else shares[::-1]


def _names(steps: list[_Step], label: str, section: int) -> list[tuple[Joint, ...]]:
    """The joints of all parts of a section; numbered, if there are several of one axis."""
    totals = [sum(axis == wanted for step in steps for axis, _ in step.joints) for wanted in range(3)]
    seen, out = [0, 0, 0], []
    for step in steps:
        row = []
        for axis, share in step.joints:
            name = f"{('alpha', 'beta', 'length')[axis]}_{label}"
            if totals[axis] > 1:
                name += f"_{_number(seen[axis], totals[axis])}"
            seen[axis] += 1
            row.append(Joint(name, section, axis, share))
        out.append(tuple(row))
    return out


def _number(index: int, total: int) -> str:
    return f"{index + 1:0{len(str(total))}d}"


def _weight(robot: Robot, i: int, steps: list[_Step], j: int) -> tuple[float, float, Array]:
    """Mass (kg) of part j of section i, its centre from the part's joint (m), and its moments of inertia (3,).

    Spread evenly along the pitch, unless the robot file says where all of it is. Parts without any length take of it.
    """
    mass, pitch = float(robot.link_masses[i]), float(robot.pitches[i])
    if len(steps) == 1:
        return mass, float(robot.centres_of_mass[i]), link_inertia(robot, i, mass, pitch)
    ends = np.cumsum([0.0, *(step.ahead + step.behind for step in steps)])
    low, length = float(ends[j]), steps[j].ahead + steps[j].behind
    rest = 1.0 - _LEAST * sum(step.ahead + step.behind == 0.0 for step in steps)
    if _group(robot, i).centre_of_mass is None:
        share, centre = rest * length / pitch if length else _LEAST, 0.5 * length
    else:
        owner = int(np.clip(np.searchsorted(ends, robot.centres_of_mass[i], side="right") - 1, 0, len(steps) - 1))
        share, centre = (rest, float(robot.centres_of_mass[i]) - low) if owner == j else (_LEAST, 0.5 * length)
    own = share * mass
    return own, centre - steps[j].ahead, link_inertia(robot, i, own, length)


def _group(robot: Robot, section: int):
    groups = [group for group in robot.spec.section for _ in range(group.count)]
    return groups[section]
