"""What a task file says of the base: what the arm stands on, where, and which way it points."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from hognose.robot import Robot
from hognose.robot.base import FORWARD, Base, Slider
from hognose.robot.carrier import Carrier
from hognose.robot.drum import Drum
from hognose.rotations import degrees_of_rotation, rotation_of_degrees, shortest_turn
from hognose.units import Angle, Direction, FileModel, NonNegativeLength, Point, PositiveLength
from hognose.wording import point

Array = NDArray[np.float64]

#: Keys that only some kinds of base have, and what such a base is called in a message.
OWN_KEYS = {
    "slider": ((), "the slider"),
    "cart": (("position",), "the cart's slider"),
    "drum": (("radius", "nozzle"), "the drum"),
    "arm": (
        ("workspace", "speed", "acceleration", "turn_speed_deg_s", "turn_acceleration_deg_s2"),
        "the carrier's workspace",
    ),
}
#: What takes the first joint along, beside the arm.
_MOVERS = {"slider": "slider", "cart": "slider", "drum": "drum", "arm": "carrier"}
#: On what the arm lies at feed 0, before the entrance.
_RUNS = {
    "slider": "the slider's run",
    "cart": "the slider's run",
    "drum": "the coil and the nozzle of the drum",
    "arm": "the straight run before the entrance",
}
#: Where each kind of base is said to be, and how it gets out of an obstacle.
_WAYS_OUT = {
    "slider": (
        "base",
        "move the entrance or turn `direction`, so that the straight arm has space before the entrance, or take, "
        "for an arm of links, the kind drum, which needs less of it",
    ),
    "cart": ("base.position", "move it into free space"),
    "drum": ("base", "move the entrance, or turn the drum about the nozzle with `rotation_deg`"),
    "arm": ("base", "move the entrance or turn `direction`, so that the straight arm has space before the entrance"),
}


_Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class WorkspaceSpec(FileModel):
    """A box that the first joint of a carried arm stays in."""

    low: Point
    high: Point

    @model_validator(mode="after")
    def _holds_something(self) -> WorkspaceSpec:
        if not all(low < high for low, high in zip(self.low, self.high, strict=True)):
            raise ValueError(
                f"`low` must be below `high` along x, y and z; got {point(self.low)} and {point(self.high)}"
            )
        return self


class BaseSpec(FileModel):
    """What the arm stands on, in the frame of the task.

    `direction` is that of the feed at the entrance; `rotation_deg` says it together with the turn about it, as the
    angles (rx, ry, rz) of Rz Ry Rx that turns the arm's own axes, in which it lies along +z. A slider ends where the
    straight arm has its nose at the entrance. A cart stands where its `position` says, that of the first joint at feed
    0, and the path leads from the nose to the entrance. A drum has a `radius`, that of the arm's centre line, its
    centre at +x of the arm's axes, and a straight `nozzle` up to the entrance. An arm is a carrier of six axes that
    takes the first joint along the path, which stays in the `workspace`, with `speed` and `acceleration` at most; it
    turns with `turn_speed_deg_s` and `turn_acceleration_deg_s2` at most.
    """

    kind: Literal["slider", "cart", "drum", "arm"] = "slider"
    direction: Direction | None = None
    rotation_deg: tuple[Angle, Angle, Angle] | None = None
    position: Point | None = None
    radius: PositiveLength | None = None
    nozzle: NonNegativeLength | None = None
    workspace: WorkspaceSpec | None = None
    speed: PositiveLength | None = None
    acceleration: PositiveLength | None = None
    turn_speed_deg_s: _Positive | None = None
    turn_acceleration_deg_s2: _Positive | None = None

    @model_validator(mode="after")
    def _says_one_thing(self) -> BaseSpec:
        if self.direction is not None and self.rotation_deg is not None:
            raise ValueError("give either `direction` or `rotation_deg`, not both")
        for kind, (keys, _) in OWN_KEYS.items():
            for key in keys:
                if kind != self.kind and getattr(self, key) is not None:
                    raise ValueError(f'`{key}` goes with `kind = "{kind}"`, not with "{self.kind}"')
        if self.kind == "cart" and self.position is None:
            raise ValueError("a cart stands somewhere: give its `position`, that of the first joint at feed 0")
        if self.kind == "drum" and self.radius is None:
            raise ValueError("a drum has a `radius`, that of the centre line of the arm on it")
        return self

    @property
    def R_task_base(self) -> Array | None:
        """Rotation (3, 3) of the arm's own axes, its third column the direction; None where they are the task's."""
        if self.rotation_deg is not None:
            turned = rotation_of_degrees(self.rotation_deg)
        else:
            turned = shortest_turn(np.array(self.direction or FORWARD))
        return None if np.array_equal(turned, np.eye(3)) else turned

    @property
    def along(self) -> tuple[float, float, float]:
        """Unit vector of the feed at the entrance."""
        turned = self.R_task_base
        if turned is None:
            return FORWARD
        x, y, z = turned[:, 2].tolist()
        return x, y, z

    @property
    def mover(self) -> str:
        """What takes the first joint along: a slider, a drum or a carrier."""
        return _MOVERS[self.kind]

    @property
    def run(self) -> str:
        """On what the arm lies at feed 0, for a message."""
        return _RUNS[self.kind]

    @property
    def slides(self) -> bool:
        """Whether the first joint is on a slider, whose travel and speed the robot file gives."""
        return self.mover == "slider"

    def words(self, base: Base) -> str:
        """What the first joint of this base cannot leave, for a message."""
        what = OWN_KEYS[self.kind][1]
        if self.kind != "drum":
            return what
        return f"{what}, which feeds its coil of {1e3 * base.farthest:.3f} mm and no more"

    @property
    def way_out(self) -> tuple[str, str]:
        """The key that says where the first joint is, and what to try if it is inside an obstacle."""
        return _WAYS_OUT[self.kind]

    def as_it_stands(self, axes: Array) -> BaseSpec:
        """The same kind of base, with the arm's own axes turned by a rotation (3, 3) in the frame of the task."""
        told = self.R_task_base
        if np.allclose(np.eye(3) if told is None else told, axes, rtol=0, atol=1e-12):
            return self
        return self.model_copy(update={"direction": None, "rotation_deg": degrees_of_rotation(axes)})

    def nose(self, robot: Robot) -> Array | None:
        """Where (3,) m the straight arm has its nose at feed 0; None for the entrance."""
        if self.position is None:
            return None
        return np.array(self.position) + robot.length * np.array(self.along)

    def base(self, entrance: Array, robot: Robot) -> Base:
        """The base of an arm whose path begins at the entrance (3,) m, or at the nose.

        Raises
        ------
        InputError
            A drum that the arm cannot be coiled on.
        """
        turned = self.R_task_base
        axes = np.eye(3) if turned is None else turned
        if self.kind == "drum":
            assert self.radius is not None, "the file's validation has seen to it"
            return Drum.before(entrance, robot, self.radius, self.nozzle or 0.0, axes)
        if self.kind == "arm":
            box = self.workspace
            return Carrier.before(entrance, robot, axes, None if box is None else np.array([box.low, box.high]))
        return Slider.before(entrance, robot, turned)
