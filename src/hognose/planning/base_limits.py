"""How fast what the arm stands on can move it, and which of these limits nobody gave."""

from __future__ import annotations

import math
from dataclasses import dataclass

from hognose.planning.task import Task
from hognose.robot import Robot
from hognose.robot.spec import ASSUMED_ACCELERATION


@dataclass(frozen=True)
class BaseLimits:
    """Limits of the base; those of a carrier are in the task file, all others in the robot file.

    Attributes
    ----------
    speed, acceleration : m/s, m/s²
        Of the first joint: along the feed, or of a carrier on the way that it takes.
    turn_speed, turn_acceleration : rad/s, rad/s²
        Of the arm's axes on a carrier; infinite where there is no limit.
    speed_source, acceleration_source
        Where an assumed limit comes from, in words; empty if it was given.
    """

    speed: float
    acceleration: float
    turn_speed: float = math.inf
    turn_acceleration: float = math.inf
    speed_source: str = ""
    acceleration_source: str = ""

    @property
    def judged_speed(self) -> float:
        """The speed (m/s) that constant feed may have; infinite where a task does not give its carrier's."""
        return math.inf if self.speed_source else self.speed

    @classmethod
    def of_feed(cls, robot: Robot) -> BaseLimits:
        """The limits of what feeds a robot, as its file gives them: a slider, or a drum."""
        axis = robot.spec.feed
        missing = "the limit is assumed, as the robot file does not give feed.acceleration"
        return cls(
            axis.speed, axis.acceleration_limit, acceleration_source=missing if axis.acceleration is None else ""
        )

    @classmethod
    def of(cls, task: Task) -> BaseLimits:
        """The limits of the base of a task."""
        axis, said = task.robot.spec.feed, task.spec.base
        if not task.base.follows:
            return cls.of_feed(task.robot)
        slower, assumed = "the limit is feed.speed of the robot file, as", "the limit is assumed, as"
        return cls(
            speed=axis.speed if said.speed is None else said.speed,
            acceleration=ASSUMED_ACCELERATION if said.acceleration is None else said.acceleration,
            turn_speed=_radians(said.turn_speed_deg_s),
            turn_acceleration=_radians(said.turn_acceleration_deg_s2),
            speed_source=f"{slower} the task gives no base.speed" if said.speed is None else "",
            acceleration_source=f"{assumed} the task gives no base.acceleration" if said.acceleration is None else "",
        )


def _radians(degrees: float | None) -> float:
    return math.inf if degrees is None else math.radians(degrees)
