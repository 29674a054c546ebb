"""The obstacles a person can write down, and the mesh each becomes.

In a task file an obstacle is one `[[obstacle]]` table whose `kind` says which of these models it is. Lengths
are in the file's unit there and in metres here.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from hognose.rotations import rotation_of_degrees
from hognose.scene import meshing
from hognose.scene.imports.imported import Mesh, Points
from hognose.scene.obstacle import TOLERANCE, ObstacleModel
from hognose.units import SMALLEST_SIZE, Angle, Direction, FileModel, Length, Point, PositiveLength

# Sine of the angle under which two directions count as parallel.
_PARALLEL = 1e-6


class Sphere(ObstacleModel):
    """A ball. Large ones stick out by up to 0.12 % of the radius: their triangle count is capped."""

    kind: Literal["sphere"] = "sphere"
    center: Point
    diameter: PositiveLength

    def triangles(self, tolerance: float = TOLERANCE) -> NDArray[np.float64]:
        """Return a closed mesh (m, 3, 3) that contains the sphere."""
        return meshing.sphere(self.diameter / 2, tolerance) + np.array(self.center)


class _Straight(ObstacleModel):
    """What cylinder and pipe share: an axis between two points."""

    start: Point
    end: Point
    diameter: PositiveLength

    @model_validator(mode="after")
    def _has_an_axis(self) -> _Straight:
        if math.dist(self.start, self.end) < SMALLEST_SIZE:
            raise ValueError(f"start and end of the {self.kind} are the same point; it needs a length")
        return self

    def _placed(self, local: NDArray[np.float64]) -> NDArray[np.float64]:
        return meshing.placed(local, meshing.frame_along(np.subtract(self.end, self.start)), self.start)


class Cylinder(_Straight):
    """A solid cylinder with flat ends."""

    kind: Literal["cylinder"] = "cylinder"

    def triangles(self, tolerance: float = TOLERANCE) -> NDArray[np.float64]:
        """Return a closed mesh (m, 3, 3) that contains the cylinder."""
        length = math.dist(self.start, self.end)
        return self._placed(meshing.cylinder(self.diameter / 2, length, tolerance))


class Pipe(_Straight):
    """A straight pipe with open ends; `diameter` is the outer one."""

    kind: Literal["pipe"] = "pipe"
    wall: PositiveLength

    @model_validator(mode="after")
    def _has_a_bore(self) -> Pipe:
        if self.wall >= self.diameter / 2:
            raise ValueError(
                f"the pipe's wall of {_mm(self.wall)} must be less than half its outer diameter of "
                f"{_mm(self.diameter)}; a solid one is a cylinder"
            )
        return self

    def triangles(self, tolerance: float = TOLERANCE) -> NDArray[np.float64]:
        """Return a closed mesh (m, 3, 3) that contains the pipe's wall."""
        radius, length = self.diameter / 2, math.dist(self.start, self.end)
        return self._placed(meshing.pipe(radius, radius - self.wall, length, tolerance))


class Box(ObstacleModel):
    """A box turned about its centre by R = Rz Ry Rx."""

    kind: Literal["box"] = "box"
    center: Point
    size: tuple[PositiveLength, PositiveLength, PositiveLength]
    rotation_deg: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)

    def triangles(self, tolerance: float = TOLERANCE) -> NDArray[np.float64]:
        """Return the box's twelve triangles (12, 3, 3)."""
        del tolerance  # a box is met exactly
        return meshing.placed(meshing.box(self.size), rotation_of_degrees(self.rotation_deg), self.center)


class Hole(FileModel):
    """A round or elliptic hole in a plane.

    `center` is in the plane's two coordinates. Either `diameter` or the two `diameters` of an ellipse are
    given; `angle_deg` turns the first of them from the plane's first axis towards its second.
    """

    center: tuple[Length, Length]
    diameter: PositiveLength | None = None
    diameters: tuple[PositiveLength, PositiveLength] | None = None
    angle_deg: Angle = 0.0

    @model_validator(mode="after")
    def _has_one_size(self) -> Hole:
        if (self.diameter is None) == (self.diameters is None):
            found = "neither" if self.diameter is None else "both"
            raise ValueError(f"a hole has either diameter or, for an ellipse, diameters = [a, b]; here it has {found}")
        return self

    @property
    def semi_axes(self) -> tuple[float, float]:
        """Half the diameters, m."""
        a, b = self.diameters or (self.diameter or 0.0, self.diameter or 0.0)
        return a / 2, b / 2

    @property
    def reach(self) -> tuple[float, float]:
        """How far the hole reaches from its centre along the plane's two axes, m."""
        (a, b), turn = self.semi_axes, math.radians(self.angle_deg)
        c, s = math.cos(turn), math.sin(turn)
        return math.hypot(a * c, b * s), math.hypot(a * s, b * c)

    def polygon(self, tolerance: float = TOLERANCE) -> NDArray[np.float64]:
        """Return the corners (k, 2) of a polygon inside the hole, within `tolerance` of it."""
        return meshing.ellipse(self.center, self.semi_axes, math.radians(self.angle_deg), tolerance)

    def check_inside(self, what: str, width: float, height: float) -> None:
        """Raise a ValueError if the hole does not lie inside a centred width × height rectangle (m)."""
        (x, y), (across, up) = self.center, self.reach
        if abs(x) + across >= width / 2 or abs(y) + up >= height / 2:
            raise ValueError(
                f"{what} does not lie inside {_mm(width)} × {_mm(height)}: it spans {_mm(x - across)} to "
                f"{_mm(x + across)} by {_mm(y - up)} to {_mm(y + up)}, measured from the middle"
            )


class Board(ObstacleModel):
    """A flat rectangular board with holes.

    Its frame has z along `normal`, y along `up` made perpendicular to it, and x = y × z; `size` is along x
    and y, and holes are placed in x and y from the board's centre.
    """

    kind: Literal["board"] = "board"
    center: Point
    normal: Direction = (0.0, 0.0, 1.0)
    up: Direction = (0.0, 1.0, 0.0)
    size: tuple[PositiveLength, PositiveLength]
    thickness: PositiveLength
    hole: tuple[Hole, ...] = ()

    @model_validator(mode="after")
    def _holds_together(self) -> Board:
        across = np.cross(self.up, self.normal) / (np.linalg.norm(self.up) * np.linalg.norm(self.normal))
        if np.linalg.norm(across) < _PARALLEL:
            raise ValueError(
                f"the board's up {list(self.up)} is parallel to its normal {list(self.normal)}; "
                "give an up that lies in the board"
            )
        for number, hole in enumerate(self.hole, start=1):
            hole.check_inside(f"hole {number} of the board", *self.size)
        return self

    @property
    def frame(self) -> NDArray[np.float64]:
        """The board's axes x, y and z as the columns of a rotation matrix (3, 3)."""
        x, z = np.cross(self.up, self.normal), np.array(self.normal)
        x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
        return np.column_stack([x, np.cross(z, x), z])

    def triangles(self, tolerance: float = TOLERANCE) -> NDArray[np.float64]:
        """Return a closed mesh (m, 3, 3) that contains the board."""
        polygons = [hole.polygon(tolerance) for hole in self.hole]
        return meshing.placed(meshing.plate((*self.size, self.thickness), polygons), self.frame, self.center)


class FaceHole(Hole):
    """A hole in one face of a tank, named by the axis the face looks along.

    `center` is measured from the face's middle along the two other axes of the tank, in the order x, y, z.
    """

    face: Literal["-x", "+x", "-y", "+y", "-z", "+z"]

    @property
    def axis(self) -> int:
        """The axis the face is normal to: 0, 1 or 2."""
        return "xyz".index(self.face[1])

    @property
    def side(self) -> int:
        """Which of the two faces: -1 or +1."""
        return -1 if self.face[0] == "-" else 1


class Tank(ObstacleModel):
    """A closed hollow box with holes through its walls; `size` is the outside.

    A hole must lie inside the face as seen from within, so that it leaves the neighbouring walls whole.
    """

    kind: Literal["tank"] = "tank"
    center: Point
    size: tuple[PositiveLength, PositiveLength, PositiveLength]
    wall: PositiveLength
    rotation_deg: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)
    hole: tuple[FaceHole, ...] = ()

    @model_validator(mode="after")
    def _holds_together(self) -> Tank:
        if self.wall >= min(self.size) / 2:
            raise ValueError(
                f"the tank's wall of {_mm(self.wall)} must be less than half its smallest size of "
                f"{_mm(min(self.size))}; a solid one is a box"
            )
        inner = [edge - 2 * self.wall for edge in self.size]
        for number, hole in enumerate(self.hole, start=1):
            width, height = (inner[i] for i in range(3) if i != hole.axis)
            hole.check_inside(f"hole {number} of the tank, seen from within face {hole.face},", width, height)
        return self

    def triangles(self, tolerance: float = TOLERANCE) -> NDArray[np.float64]:
        """Return a closed mesh (m, 3, 3) that contains the tank's walls."""
        holes = [(hole.axis, hole.side, hole.polygon(tolerance)) for hole in self.hole]
        local = meshing.hollow_box(self.size, self.wall, holes)
        return meshing.placed(local, rotation_of_degrees(self.rotation_deg), self.center)


#: Any obstacle; `kind` tells which.
Obstacle = Annotated[Sphere | Cylinder | Pipe | Box | Board | Tank | Mesh | Points, Field(discriminator="kind")]


def _mm(length: float) -> str:
    return f"{length * 1e3:g} mm"
