"""The base on which an arm is steered: one on which it starts straight, with its nose at the entrance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.arguments import instance
from hognose.errors import InputError
from hognose.robot import Robot
from hognose.robot.base import SAME_PLACE, Base, Slider
from hognose.wording import point

Array = NDArray[np.float64]


def base_at(entrance: Array, robot: Robot, base: Base | None) -> Base:
    """The base given, or a slider along +z, that has the straight arm's nose at the entrance; an InputError if not."""
    if not robot.straight_links:
        raise InputError(
            f"robot: {robot.name}: sections of several chords cannot be steered: how far their parts go while a path "
            "grows is not proven. Expected sections of kind link; plan the motion with way-points instead"
        )
    if base is None:
        return Slider.before(entrance, robot)
    given = instance("base", base, Base, "a base such as hognose.robot.Slider, or None")
    if not given.straight:
        raise InputError(
            "base: an arm on a drum cannot be steered, as it does not start straight; expected a slider, a cart or a "
            "carrier. Plan the motion with way-points, or take another `kind` for steering"
        )
    nose = given.start + robot.length * given.direction
    if np.linalg.norm(nose - entrance) > SAME_PLACE:
        raise InputError(
            f"base: the straight arm on it has its nose at {point(nose)}, the entrance is at {point(entrance)}; "
            "expected the same place. `Slider.before(entrance, robot)` makes such a base"
        )
    return given
