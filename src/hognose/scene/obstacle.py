"""What every obstacle has."""

from __future__ import annotations

from abc import abstractmethod
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from hognose.errors import InputError
from hognose.scene.obstacle_motion import LATEST, MotionPose, ObstacleMotion
from hognose.scene.part import Part
from hognose.units import Direction, FileModel, Point

#: Largest distance, in metres, between a round obstacle and its mesh, unless asked otherwise.
TOLERANCE = 1e-4


class ObstacleModel(FileModel):
    """What all obstacles have: a `kind`, a name if it was given one, and a mesh.

    A new kind is a subclass with a literal `kind` and `triangles`, or `parts` if it has several, added to the union
    `Obstacle`.
    """

    #: Whether unnamed ones are numbered from the first on.
    numbered: ClassVar[bool] = True

    kind: Any  # a literal string in each subclass
    name: Annotated[str, Field(min_length=1)] | None = None
    motion: Annotated[tuple[MotionPose, ...], Field(max_length=10_000)] = ()
    motion_pivot: Point | None = None
    motion_axis: Direction | None = None
    motion_repeats: bool = False
    timing_s: Annotated[float, Field(ge=0, le=LATEST, allow_inf_nan=False)] | None = None

    @model_validator(mode="after")
    def _moves_sensibly(self) -> ObstacleModel:
        self.said_motion.refuse_nonsense()
        return self

    @property
    def said_motion(self) -> ObstacleMotion:
        """What its keys say of how it moves."""
        return ObstacleMotion(self.motion, self.motion_pivot, self.motion_axis, self.timing_s, self.motion_repeats)

    @property
    def title(self) -> str:
        """What an unnamed one is called, but for its number."""
        return self.kind

    def parts(self, tolerance: float = TOLERANCE) -> list[Part]:
        """Return the parts it is made of; of most kinds one, without a name."""
        return [Part("", self.triangles(tolerance))]

    @abstractmethod
    def triangles(self, tolerance: float = TOLERANCE) -> NDArray[np.float64]:
        """Return a closed mesh that contains the solid.

        Parameters
        ----------
        tolerance
            Largest distance, m, by which round parts of the mesh may stick out of the solid.

        Returns
        -------
        (m, 3, 3) array
            Corners of the triangles, m, in the world, anticlockwise seen from outside.
        """


def titles(obstacles: Iterable[ObstacleModel]) -> list[str]:
    """Return what obstacles are called: as they say, or by their kind and a running number."""
    seen: Counter[str] = Counter()
    names = []
    for item in obstacles:
        seen[item.title] += 1
        number = seen[item.title]
        names.append(item.name or (item.title if number == 1 and not item.numbered else f"{item.title} {number}"))
    return names


def named_parts(obstacles: Iterable[ObstacleModel], tolerance: float = TOLERANCE) -> list[Part]:
    """Return the parts of all obstacles, with names that differ; those of one of several are called "obstacle: part".

    Raises
    ------
    InputError
        Two are called the same.
    """
    items, parts = list(obstacles), []
    for place, (item, name) in enumerate(zip(items, titles(items), strict=True)):
        for part in item.parts(tolerance):
            called, shell = f"{name}: {part.name}" if part.name else name, place if part.shell >= 0 else -1
            parts.append(replace(part, name=called, shell=shell))
    for name, times in Counter(part.name for part in parts).items():
        if times > 1:
            raise InputError(f'{times} obstacles are called "{name}"; give each its own name')
    return parts
