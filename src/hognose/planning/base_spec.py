"""What a task file says of the base: what the arm stands on, where, and which way it points."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import model_validator

from hognose.robot import Robot
from hognose.robot.base import FORWARD, Base, Slider
from hognose.scene.meshing import rotation
from hognose.units import Angle, Direction, FileModel, Point

Array = NDArray[np.float64]


class BaseSpec(FileModel):
    """What the arm stands on, in the frame of the task.

    `direction` is that of the feed; `rotation_deg` says it together with the turn about it, as the angles (rx, ry, rz)
    of Rz Ry Rx that turns the arm's own axes, in which it lies along +z. `position` is the first joint at feed 0; unless
    given, the straight arm's nose is at the entrance then. A cart stands where it is, so that its position is required,
    and the path leads from the nose to the entrance.
    """

    kind: Literal["slider", "cart"] = "slider"
    position: Point | None = None
    direction: Direction | None = None
    rotation_deg: tuple[Angle, Angle, Angle] | None = None

    @model_validator(mode="after")
    def _says_one_thing(self) -> BaseSpec:
        if self.direction is not None and self.rotation_deg is not None:
            raise ValueError("give either `direction` or `rotation_deg`, not both")
        if self.kind == "cart" and self.position is None:
            raise ValueError("a cart stands somewhere: give its `position`, that of the first joint at feed 0")
        if self.kind == "slider" and self.position is not None:
            raise ValueError(
                '`position` goes with `kind = "cart"`; a slider stands as far before the entrance as the arm is long'
            )
        return self

    @property
    def R_task_base(self) -> Array | None:
        """Rotation (3, 3) of the arm's own axes, its third column the direction; None where they are the task's."""
        if self.rotation_deg is not None:
            turned = rotation(self.rotation_deg)
        else:
            turned = shortest_turn(np.array(self.direction or FORWARD))
        return None if np.array_equal(turned, np.eye(3)) else turned

    @property
    def along(self) -> tuple[float, float, float]:
        """Unit vector of the feed."""
        turned = self.R_task_base
        if turned is None:
            return FORWARD
        x, y, z = turned[:, 2].tolist()
        return x, y, z

    def nose(self, robot: Robot) -> Array | None:
        """Where (3,) m the straight arm has its nose at feed 0; None for the entrance."""
        if self.position is None:
            return None
        return np.array(self.position) + robot.length * np.array(self.along)

    def base(self, entrance: Array, robot: Robot) -> Base:
        """The base of an arm whose path begins at the entrance (3,) m, or at the nose."""
        return Slider.before(entrance, robot, self.R_task_base)


def shortest_turn(direction: Array) -> Array:
    """The rotation (3, 3) that turns +z to a direction (3,) the shortest way; half a turn about x for -z."""
    x, y, z = (direction / np.linalg.norm(direction)).tolist()
    across = math.hypot(x, y)
    if across < 1e-12:
        return np.eye(3) if z > 0 else np.diag([1.0, -1.0, -1.0])
    part = (1.0 - z) / across**2
    return np.array(
        [
            [1.0 - part * x * x, -part * x * y, x],
            [-part * x * y, 1.0 - part * y * y, y],
            [-x, -y, z],
        ]
    )
