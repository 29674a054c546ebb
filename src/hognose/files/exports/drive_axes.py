"""The axes that motors move in a plan: cables, lengths of sections that extend, and what feeds the arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.files.exports.mounting import Mounting
from hognose.planning.columns import LABELS
from hognose.planning.plan import Plan

Array = NDArray[np.float64]

#: What is said of a plan whose arm is carried: no motor of ours does that.
CARRIED = "the pose of the carrier is not in it, which has a controller of its own: it is in the plan's columns (CSV)"


@dataclass(frozen=True, eq=False)
class Axis:
    """Set-points of a motor.

    Attributes
    ----------
    name
        `cable_01`, …; `length_01`, … of sections that extend; and `slider` or `drum`.
    unit
        Of its set-points: counts of cables; m of a length or a slider; rad of a drum.
    positions : (T,)
        Whole numbers if they are counts.
    scale
        m or rad in a unit.
    """

    name: str
    unit: str
    positions: NDArray[np.int64] | Array
    scale: float

    @property
    def values(self) -> Array:
        """Positions (T,) in m or rad; of a cable how far it is paid out, 0 at the straight arm."""
        return np.asarray(self.positions, np.float64) * self.scale

    def velocities(self, time: Array) -> Array:
        """Velocities (T,) in units/s at times (T,) s: means of the intervals before and behind, 0 at both ends."""
        found = np.zeros(len(time))
        found[1:-1] = (self.positions[2:] - self.positions[:-2]) / (time[2:] - time[:-2])
        return found


def axes_of_plan(plan: Plan) -> list[Axis]:
    """Cables in their order, lengths of sections that extend, and what feeds the arm, if that is a motor of ours."""
    robot = plan.robot
    travel = np.broadcast_to(robot.travel_per_count, robot.cables)
    axes = [
        Axis(f"cable_{label}", "counts", plan.motor_counts[:, cable], float(travel[cable]))
        for cable, label in enumerate(LABELS["cable"](robot))
    ]
    axes += [
        Axis(f"length_{label}", "m", plan.section_lengths[:, section], 1.0)
        for label, section in zip(LABELS["extending section"](robot), np.flatnonzero(robot.extending), strict=True)
    ]
    feed = feed_joint(plan)
    if feed is None:
        return axes
    mounting, positions = feed
    name, unit = ("slider", "m") if mounting.kind == "slide" else ("drum", "rad")
    return [*axes, Axis(name, unit, positions, 1.0)]


def feed_joint(plan: Plan) -> tuple[Mounting, Array] | None:
    """The joint that feeds the arm and its positions (T,), as in its URDF; None on a carrier."""
    mounting = Mounting.of(plan.task.base, plan.robot)
    return None if mounting.kind == "pose" else (mounting, mounting.values(plan.at)[:, 0])
