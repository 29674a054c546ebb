"""The way of an arm of sections of any kinds: set-points of feed and angles, between which both go linearly.

Joints of such sections do not glide along the path, so what they do between two places is chosen so that it can be
proven: where the nose has gone on, the method places the arm anew, and feed and angles go there linearly. What has been
gone is kept, so that the way back is the same to the last bit.
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InfeasibleError, InputError
from hognose.following import OF_SECTIONS
from hognose.following.growing import GrowingSections
from hognose.robot import Robot
from hognose.robot.base import Base, angles_on, axes_of, centre_line, joints_on
from hognose.robot.sections import MixedSections
from hognose.steering.grown_curve import ARC_SLACK, GrownCurve
from hognose.steering.way import PlacedArm

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Stretch:
    """From one set-point, of feed and angles (1 + 2 n,), at a depth (m) to another."""

    start: float
    end: float
    low: Array
    high: Array

    def at(self, depth: float) -> Array:
        """Feed and angles in between, or at the end to the last bit."""
        if depth == self.end:
            return self.high
        return self.low + (depth - self.start) / (self.end - self.start) * (self.high - self.low)


class SectionWay:
    """Set-points by the depth of the nose. It is an `ArmWay`.

    Parameters
    ----------
    robot, model
        The arm, and how its sections bend.
    base
        One that does not turn.
    curve
        On which the arm lies straight at first.
    method
        One of those that steer.
    """

    def __init__(self, robot: Robot, model: MixedSections, base: Base, curve: GrownCurve, method: str) -> None:
        self._robot, self._base, self._curve = robot, base, curve
        axes = axes_of(base, np.zeros((1, 1)))[0]
        self._sections = GrowingSections(model, robot.link_lengths, OF_SECTIONS[method], axes, 1.0 + ARC_SLACK)
        self._still = np.zeros((1, 3)), np.zeros(1)
        start = np.zeros(1 + 2 * robot.sections)
        # Where each stretch ends, and what it goes between: one that was cut keeps the end that it had.
        self._ends, self._stretches = [0.0], [_Stretch(-1.0, 0.0, start, start)]

    def place(self, depths: Array) -> tuple[Array, Array]:
        """See `Way.place`: the marks are feed and angles."""
        marks = np.stack([self._mark(depth) for depth in depths.tolist()])
        return marks, self._bodies(marks)[1]

    def travel(self, marks: Array, vertices: Array) -> Array:
        """See `Way.travel`: the way from end to end, and twice what it can bulge in between, there and back."""
        angles = marks[:, 1:].reshape(len(marks), -1, 2)
        spin, swing = (np.repeat(still, len(marks) - 1, axis=0) for still in self._still)
        bulge = self._robot.model.bulges(angles[:-1], angles[1:], self._robot.link_lengths, spin, swing)
        return np.linalg.norm(np.diff(vertices, axis=0), axis=2) + 2.0 * bulge

    def arm(self, depth: float) -> PlacedArm:
        """See `ArmWay.arm`."""
        mark = self._mark(depth)
        joints, vertices = self._bodies(mark[None])
        angles = mark[1:].reshape(-1, 2).copy()
        return PlacedArm(depth, float(mark[0]), joints[0], vertices[0], angles, self._robot.cable_lengths(angles))

    def end(self, arm: PlacedArm) -> Array:
        """See `ArmWay.end`: between two set-points the tip is a little beside the curve."""
        return self._curve.derivatives(self._curve.end)[0]

    def reach(self) -> None:
        """See `ArmWay.reach`: one more set-point, at the end of the curve."""
        before, depth = self._ends[-1], self._curve.end
        low = self._mark(before)
        feed, joints = self._sections.reach(*self._curve.pieces, float(low[0]) + depth - before)
        try:
            angles = angles_on(self._base, self._robot, joints[None], np.array([[feed]]))
        except InputError as error:
            raise InfeasibleError(str(error)) from error
        self._ends.append(depth)
        self._stretches.append(_Stretch(before, depth, low, np.append(feed, angles)))

    def cut(self, depth: float) -> None:
        """See `ArmWay.cut`."""
        kept = bisect_left(self._ends, depth)
        del self._ends[kept + 1 :], self._stretches[kept + 1 :]
        self._ends[kept] = depth

    def _mark(self, depth: float) -> Array:
        """Feed and angles (1 + 2 n,) at a depth."""
        return self._stretches[bisect_left(self._ends, depth)].at(depth)

    def _bodies(self, marks: Array) -> tuple[Array, Array]:
        """Joints (T, n+1, 3) m and ends (T, p+1, 3) m of the chords."""
        at, angles = np.ascontiguousarray(marks[:, :1]), np.ascontiguousarray(marks[:, 1:]).reshape(len(marks), -1, 2)
        joints = joints_on(self._base, self._robot, angles, at)
        return joints, centre_line(self._base, self._robot, joints, at, angles)
