"""The motion of cables that go linearly, of arms whose sections all extend.

S α, S β and S L of every section are linear in the cables, with S = sin(θ/2D)/(θ/2D), if these keep their circles. So
they go linearly, too, and angles and lengths are functions of them of which second derivatives are known. Derived in
docs/certificate.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hognose.planning.certificate.moving import Array, Moving, Pieces
from hognose.robot import Robot
from hognose.robot.base import Base, centre_line_on
from hognose.robot.sections import MixedSections

#: Lengths may be beyond the longest by this part, as rounding to motor counts has it; of others nothing is proven, nor
#: of sections that bend by more (rad) from disk to disk.
_BEYOND, _SHARPEST = 0.01, 2.0


class UndeterminedError(Exception):
    """There are cable lengths for which no angles are found, or of which nothing is proven."""


def knows_cables(robot: Robot) -> bool:
    """Whether the motion is known: every section extends, and cables keep their circles."""
    return all(section.length_range is not None for _, section in robot.section_kinds) and robot.keeps_circles


def extending_motion(robot: Robot, base: Base, at: Array, angles: Array, sections: Array, lengths: Array) -> Moving:
    """The motion of a base (T, k) and cable lengths (T, c) m that are interpolated.

    Angles (T, n, 2) rad and section lengths (T, n) m are as of these.
    """
    parameters = np.concatenate([at, angles.reshape(len(at), -1), sections, lengths], axis=1)
    made = _Motion(robot, base, at.shape[1])
    return Moving(parameters, made.place, made.travel, straight=True, on_base=at.shape[1])


@dataclass(frozen=True)
class _Motion:
    """What certificates ask: parameters are those of the base, angles, section lengths and cable lengths."""

    robot: Robot
    base: Base
    count: int

    def place(self, parameters: Array) -> tuple[Array, Array]:
        at, near, _, lengths = self._parts(parameters)
        at = self.base.settled(at)
        angles = self.robot.angles_from_cables(lengths, near)
        sections = self.robot.lengths_from_cables(lengths, near)
        if not (np.isfinite(angles).all() and (sections > 0.0).all()):
            raise UndeterminedError
        found = np.concatenate([at, angles.reshape(len(at), -1), sections, lengths], axis=1)
        return found, centre_line_on(self.base, self.robot, angles, at, sections)

    def travel(self, pieces: Pieces) -> tuple[Array, Array]:
        low_at, low, short, _ = self._parts(pieces.low)
        high_at, high, long, _ = self._parts(pieces.high)
        spin, swing = self.base.spin(low_at, high_at), self.base.swing(low_at, high_at)
        both = np.stack([short, long])
        bulge = self.robot.model.bulges(low, high, both, spin, swing) + self._off(low, high, both)
        return pieces.gone, bulge

    def _off(self, low: Array, high: Array, both: Array) -> Array:
        """How far (m, p+1) m ends of chords leave linear angles and lengths."""
        if (both > (1.0 + _BEYOND) * self.robot.length_bounds[:, 1]).any():
            raise UndeterminedError
        turned, longer = deviations_of_arcs(self.robot, low, high, *both)
        model = self.robot.model
        assert isinstance(model, MixedSections)
        # Levers and what chords leave out are those of the longest sections, which may be a little longer here.
        left = self.robot.model.sagitta(self.robot.link_lengths, self.robot.bend_limits).max()
        return (1.0 + _BEYOND) * (turned @ model.levers.T + longer @ model.passed.T) + _BEYOND * left

    def _parts(self, parameters: Array) -> tuple[Array, Array, Array, Array]:
        """Coordinates of the base (m, k), angles (m, n, 2), section lengths (m, n) and cable lengths (m, c)."""
        sections = self.robot.sections
        ends = np.cumsum([self.count, 2 * sections, sections])
        at, angles, long, lengths = np.split(parameters, ends, axis=1)
        return at, np.ascontiguousarray(angles).reshape(-1, sections, 2), long, np.ascontiguousarray(lengths)


def deviations_of_arcs(robot: Robot, low: Array, high: Array, short: Array, long: Array) -> tuple[Array, Array]:
    """How far angles (m, n) rad and lengths (m, n) m leave linear ones at most while cables go linearly.

    Angles go from low to high (m, n, 2) rad and lengths from short to long (m, n) m.

    Raises
    ------
    UndeterminedError
        A section bends too sharply between its disks.
    """
    none = np.zeros(robot.sections)
    disks = np.array([section.disks or 0 for _, section in robot.section_kinds])
    parts = 2.0 * np.where(disks > 0, disks, np.inf)  # cables that are led all along are linear
    halves = [np.hypot(each[..., 0], each[..., 1]) / parts for each in (low, high)]
    shrunk = [np.sinc(half / np.pi) for half in halves]
    turns = np.linalg.norm(high * shrunk[1][..., None] - low * shrunk[0][..., None], axis=2)
    begin, end = short * shrunk[0], long * shrunk[1]
    half = np.maximum(*halves)
    if half.max(initial=0.0) > 0.5 * _SHARPEST:
        raise UndeterminedError
    steep = 1.0 / np.cos(half) ** 3
    part, inverse = np.sin(half), np.where(disks > 0, 1.0 / parts, none)
    angles = 0.125 * part * steep * inverse * turns**2
    lengths = 2.0 * np.abs(end - begin) * part * steep / 3.0 * inverse * turns
    lengths = 0.125 * (lengths + np.maximum(begin, end) * steep * (inverse * turns) ** 2)
    return angles, lengths
