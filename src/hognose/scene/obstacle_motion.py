"""What a file says of an obstacle that moves, and the motion it means."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from hognose.rotations import rotation_of_degrees, rotations_of_vectors, vector_of_rotation
from hognose.scene.rigid_motion import RigidMotion
from hognose.units import Angle, FileModel, Point

#: Two poses given as rotations are less than half a turn apart by so much (deg): else the axis is lost in rounding.
_LESS = 0.1
#: The last pose of a motion that repeats is the first one, to so much (m, and without unit).
_ALIKE = 1e-9
#: The latest time of a pose (s), and the largest angle (deg).
LATEST, MOST_TURNED = 1e6, 3.6e6


class MotionPose(FileModel):
    """An obstacle at a time: how far it is moved and turned from where it is placed.

    It is turned about its pivot, by R = R_z R_y R_x or by an angle about the obstacle's `motion_axis`.
    """

    time_s: Annotated[float, Field(ge=-LATEST, le=LATEST, allow_inf_nan=False)]
    position: Point = (0.0, 0.0, 0.0)
    rotation_deg: tuple[Angle, Angle, Angle] | None = None
    angle_deg: Annotated[float, Field(ge=-MOST_TURNED, le=MOST_TURNED, allow_inf_nan=False)] | None = None

    @model_validator(mode="after")
    def _turns_one_way(self) -> MotionPose:
        if self.rotation_deg is not None and self.angle_deg is not None:
            raise ValueError("give either `rotation_deg` or `angle_deg` about the obstacle's `motion_axis`, not both")
        return self

    @property
    def turns(self) -> bool:
        """Whether it says how the obstacle is turned."""
        return self.rotation_deg is not None or self.angle_deg is not None


@dataclass(frozen=True)
class ObstacleMotion:
    """All that an obstacle's keys say of its motion, in SI."""

    poses: tuple[MotionPose, ...]
    pivot: tuple[float, float, float] | None
    axis: tuple[float, float, float] | None
    timing_s: float | None
    repeats: bool

    def refuse_nonsense(self) -> None:
        """Raise a ValueError that says what is wrong with it."""
        if not self.poses:
            if self.pivot or self.axis or self.timing_s or self.repeats:
                raise ValueError("it has no `[[obstacle.motion]]`: give two poses or more, or leave out the other keys")
            return
        if len(self.poses) < 2:
            raise ValueError("one pose is no motion: give a second `[[obstacle.motion]]`, or place it there")
        for number, (one, next_) in enumerate(pairwise(self.poses), 2):
            if not next_.time_s > one.time_s:
                raise ValueError(
                    f"the times of its poses must increase: pose {number} is at {next_.time_s:g} s, the one before it "
                    f"at {one.time_s:g} s"
                )
        if any(pose.turns for pose in self.poses) and self.pivot is None:
            raise ValueError("it turns, so give the `motion_pivot`, the point about which it does, such as a hinge")
        self._refuse_mixed_turns()
        self._refuse_jump()

    def _refuse_mixed_turns(self) -> None:
        angles = [pose.angle_deg is not None for pose in self.poses]
        if any(angles) != (self.axis is not None):
            raise ValueError("`angle_deg` of its poses and its `motion_axis` go together: give both or neither")
        if any(angles) and any(pose.rotation_deg is not None for pose in self.poses):
            raise ValueError("some of its poses have `rotation_deg`, others `angle_deg`; use one of them in all")
        if any(angles):
            return
        for number, (one, next_) in enumerate(pairwise(self.poses), 2):
            before, after = one.rotation_deg or (0.0, 0.0, 0.0), next_.rotation_deg or (0.0, 0.0, 0.0)
            between = vector_of_rotation(rotation_of_degrees(after) @ rotation_of_degrees(before).T)
            turned = max(float(np.degrees(np.linalg.norm(between))), *np.abs(np.subtract(after, before)).tolist())
            if turned >= 180.0 - _LESS:
                raise ValueError(
                    f"from pose {number - 1} to pose {number} it turns by {turned:g} deg: half a turn or more has no "
                    "shortest way; put poses in between, or give `angle_deg` about a `motion_axis`"
                )

    def _refuse_jump(self) -> None:
        if not self.repeats:
            return
        made = self.made()
        jump = float(np.linalg.norm(made.places[-1] - made.places[0]))
        between = made.R_task_placed[-1] @ made.R_task_placed[0].T
        if max(jump, np.abs(between - np.eye(3)).max()) > _ALIKE:
            turned = np.degrees(np.linalg.norm(vector_of_rotation(between)))
            raise ValueError(
                "with `motion_repeats` its last pose must be like the first, or it would jump there, by "
                f"{1e3 * jump:.3g} mm and {turned:.3g} deg; add a pose like the first"
            )

    def made(self) -> RigidMotion:
        """The motion."""
        pivot = np.array(self.pivot or (0.0, 0.0, 0.0))
        times = np.array([pose.time_s for pose in self.poses])
        places = pivot + np.array([pose.position for pose in self.poses])
        if self.axis is not None:
            axis = np.array(self.axis) / np.linalg.norm(self.axis)
            angles = np.radians([pose.angle_deg or 0.0 for pose in self.poses])
            turned, spins = rotations_of_vectors(angles[:, None] * axis), np.diff(angles)[:, None] * axis
        else:
            turned = np.stack([rotation_of_degrees(pose.rotation_deg or (0.0, 0.0, 0.0)) for pose in self.poses])
            spins = np.stack([vector_of_rotation(after @ before.T) for before, after in pairwise(turned)])
        return RigidMotion(times, pivot, places, turned, spins, self.repeats)
