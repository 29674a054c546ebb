"""What an arm is steered on and by: a base on which it starts straight, and a method that places it on the path."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.arguments import instance
from hognose.errors import InputError
from hognose.following import OF_SECTIONS, known_method
from hognose.robot import Robot
from hognose.robot.base import SAME_PLACE, Base, Slider
from hognose.robot.sections import MixedSections
from hognose.steering.grown_curve import GrownCurve
from hognose.steering.section_way import SectionWay
from hognose.steering.way import ArmWay, LinkWay
from hognose.wording import point

Array = NDArray[np.float64]


def base_at(entrance: Array, robot: Robot, base: Base | None) -> Base:
    """The base given, or a slider along +z, that has the straight arm's nose at the entrance; an InputError if not."""
    if base is None:
        return Slider.before(entrance, robot)
    given = instance("base", base, Base, "a base such as hognose.robot.Slider, or None")
    if not given.straight:
        raise InputError(
            "base: an arm on a drum cannot be steered, as it does not start straight; expected a slider, a cart or a "
            "carrier. Plan the motion with way-points, or take another `kind` for steering"
        )
    if not (robot.straight_links or isinstance(given, Slider)):
        raise InputError(
            f"base: {robot.name} has sections that are no rigid links, which are followed from a slider or a cart so "
            f"far; expected one of these, got a {type(given).__name__}"
        )
    nose = given.start + robot.length * given.direction
    if np.linalg.norm(nose - entrance) > SAME_PLACE:
        raise InputError(
            f"base: the straight arm on it has its nose at {point(nose)}, the entrance is at {point(entrance)}; "
            "expected the same place. `Slider.before(entrance, robot)` makes such a base"
        )
    return given


def steering_method(robot: Robot, method: str | None) -> str:
    """The method given, or the one that keeps the arm closest to its path; an InputError if it does not steer."""
    if method is not None:
        known_method(method)
    if robot.straight_links:
        if method not in (None, "exact"):
            raise InputError(f"method: links are steered with their joints on the path, by exact; got {method!r}")
        return "exact"
    if not isinstance(robot.model, MixedSections):
        raise InputError(
            f"robot: {robot.name}: links of several chords cannot be steered: how far their parts go while "
            "a path grows is not proven. Expected links of one chord, or sections of other kinds"
        )
    if method is None:
        return "aim"
    if method not in OF_SECTIONS or not OF_SECTIONS[method].grows:
        able = " or ".join(name for name, each in OF_SECTIONS.items() if each.grows)
        why = "is for rigid links"
        if method in OF_SECTIONS:
            why = "finds each pose from those before it, on a path that is known to its end"
        raise InputError(
            f"method: {method} {why}; {robot.name} is steered with {able}, while the path grows. Give one of them: "
            "SteeredPath.of(task, method='aim'), or motion.method in the task"
        )
    return method


def nearest_method(robot: Robot, method: str) -> str:
    """The method if the robot is steered by it, else the one with which it is unless another one is given."""
    able = method in OF_SECTIONS and OF_SECTIONS[method].grows and not robot.straight_links
    return method if able else steering_method(robot, None)


def way_of(robot: Robot, base: Base, curve: GrownCurve, method: str) -> ArmWay:
    """The way of an arm on a curve, by a method that steers it."""
    if isinstance(robot.model, MixedSections):
        return SectionWay(robot, robot.model, base, curve, method)
    return LinkWay(robot, base, curve)
