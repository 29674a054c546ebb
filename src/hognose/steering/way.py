"""The way of a steered arm: where all of it is with the nose at any depth, and how far it goes in between."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hognose.robot import Robot
from hognose.robot.base import Base, angles_on
from hognose.steering.grown_curve import GrownCurve

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PlacedArm:
    """The arm with its nose at one place.

    Attributes
    ----------
    depth, feed : m
        How far the nose is along its path from the entrance, and the slider.
    joints : (n+1, 3) m
    vertices : (p+1, 3) m
        Ends of the chords of the body.
    angles : (n, 2) rad
    cables : (c,) m
    """

    depth: float
    feed: float
    joints: Array
    vertices: Array
    angles: Array
    cables: Array


class Way(Protocol):
    """Bodies by the depth of the nose."""

    def place(self, depths: Array, /) -> tuple[Array, Array]:
        """Marks (T, k) that say where the arm is, and ends (T, p+1, 3) m of its chords, at depths (T,) m."""
        ...

    def travel(self, marks: Array, vertices: Array, /) -> Array:
        """How far (T-1, p+1) m ends of chords go at most from each place to the next."""
        ...


class ArmWay(Way, Protocol):
    """The way of a whole arm on a curve that grows."""

    def arm(self, depth: float) -> PlacedArm:
        """The arm with its nose at a depth (m) to which the way goes."""
        ...

    def end(self, arm: PlacedArm) -> Array:
        """Where (3,) m the curve ends, and grows on, with the nose of this arm at its end."""
        ...

    def reach(self) -> None:
        """Go on to the end of the curve, which has grown.

        Raises
        ------
        InfeasibleError
            The arm cannot follow.
        """
        ...

    def cut(self, depth: float) -> None:
        """Drop what is beyond a depth (m)."""
        ...


class LinkWay:
    """That of rigid links, whose joints glide on the curve: a function of the depth, whatever was before.

    It is an `ArmWay`.
    """

    def __init__(self, robot: Robot, base: Base, curve: GrownCurve) -> None:
        self._robot, self._base, self._curve = robot, base, curve

    def place(self, depths: Array) -> tuple[Array, Array]:
        """See `Way.place`: the marks are the joints' parameters."""
        return self._curve.place(depths)

    def travel(self, marks: Array, vertices: Array) -> Array:
        """See `Way.travel`."""
        return self._curve.travel(marks, vertices)

    def arm(self, depth: float) -> PlacedArm:
        """See `ArmWay.arm`."""
        at, joints = self._curve.place(np.array([depth]))
        feed = float(at[0, 0] - self._curve.start)
        angles = angles_on(self._base, self._robot, joints, self._base.coordinates(np.array([feed]), joints))[0]
        return PlacedArm(depth, feed, joints[0], joints[0], angles, self._robot.cable_lengths(angles))

    def end(self, arm: PlacedArm) -> Array:
        """See `ArmWay.end`: the tip, so that it is there to the last bit ever after."""
        return arm.joints[-1]

    def reach(self) -> None:
        """See `ArmWay.reach`: joints are on the curve wherever it goes."""

    def cut(self, depth: float) -> None:
        """See `ArmWay.cut`: nothing is kept."""
