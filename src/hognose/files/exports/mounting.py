"""How the arm stands in the space: the frame of its first joint at feed 0, and what moves it from there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.robot import Robot
from hognose.robot.base import Base, Slider, axes_of
from hognose.robot.carrier import Carrier
from hognose.robot.drum import Drum

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Mounting:
    """The frame in which the arm lies along +z at feed 0, and the joint that moves this frame.

    Attributes
    ----------
    kind
        A slide along z by the feed (m); a turn about y (rad), about an axis `radius` away along x; or any pose.
    joint
        What the joint is called.
    start : (3,) m
    R_task_base : (3, 3)
    low, high
        Travel, m or rad.
    speed
        The fastest, m/s or rad/s.
    radius : m
        From the first joint to the axis of a drum.
    length_behind, radius_behind : m
        Of the mount behind the first joint; 0 where there is none.
    """

    kind: Literal["slide", "turn", "pose"]
    joint: str
    start: Array
    R_task_base: Array
    low: float
    high: float
    speed: float
    radius: float = 0.0
    length_behind: float = 0.0
    radius_behind: float = 0.0

    @classmethod
    def of(cls, base: Base, robot: Robot) -> Mounting:
        """The mounting of an arm on a base.

        Raises
        ------
        InputError
            A kind of base that is not known here.
        """
        feed = robot.spec.feed
        if isinstance(base, Slider):
            turned = np.eye(3) if base.R_task_base is None else base.R_task_base
            travel = (feed.min, feed.max, feed.speed)
            return cls("slide", "feed", base.start, turned, *travel, 0.0, base.length_behind, base.radius_behind)
        if isinstance(base, Drum):
            low, high, speed = (x / base.radius for x in (feed.min, min(feed.max, base.farthest), feed.speed))
            return cls("turn", "drum", base.start, axes_of(base, np.zeros((1, 1)))[0], low, high, speed, base.radius)
        if isinstance(base, Carrier):
            behind = (base.length_behind, base.radius_behind)
            return cls("pose", "base", base.start, base.R_task_start, -np.inf, np.inf, feed.speed, 0.0, *behind)
        raise InputError(f"base: a {type(base).__name__} cannot be exported; expected a slider, a drum or a carrier")

    def values(self, at: Array) -> Array:
        """Values (T, 1) of the joint at coordinates (T, k) of the base; (T, 0) for a pose, which is no joint."""
        return at[:, :0] if self.kind == "pose" else at / (self.radius or 1.0)
