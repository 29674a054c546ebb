"""Obstacles that are read from files: meshes and point clouds."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, PrivateAttr, ValidationInfo, model_validator

from hognose.errors import InputError
from hognose.rotations import rotation_of_degrees
from hognose.scene import meshing
from hognose.scene.imports.content import MOST_LISTED, ScanOptions, listed
from hognose.scene.imports.formats import STEP_SUFFIXES, UNITLESS_SUFFIXES
from hognose.scene.imports.geometry import Body, Geometry
from hognose.scene.imports.reading import read_mesh, read_points
from hognose.scene.imports.selection import selected
from hognose.scene.obstacle import TOLERANCE, ObstacleModel
from hognose.scene.part import Part
from hognose.units import LARGEST_LENGTH, LENGTH_UNITS, Angle, NonNegativeLength, Point, PositiveLength

#: How far the triangles of a STEP file may lie off its surfaces, m, unless asked otherwise.
STEP_TOLERANCE = 5e-5

#: Longest sides (m) beyond these are taken for a wrong unit, and said so.
LARGEST_LIKELY, SMALLEST_LIKELY = 50.0, 0.005

Units = Literal["mm", "cm", "m", "in"]
#: A column of a scan: its heading, or its number from 1.
Column = Annotated[str, Field(min_length=1)] | Annotated[int, Field(ge=1)]
#: Names of bodies, or patterns of them.
Patterns = Annotated[tuple[Annotated[str, Field(min_length=1)], ...], Field(min_length=1)]


def doubtful_size(size: float, metres: float) -> list[str]:
    """What is to be said of something whose longest side is `size` (m), its numbers read in units of `metres`."""
    if SMALLEST_LIKELY <= size <= LARGEST_LIKELY:
        return []
    likely = [
        f"{size / metres * other:.3g} m in {unit}"
        for unit, other in LENGTH_UNITS.items()
        if 10 * SMALLEST_LIKELY <= size / metres * other <= LARGEST_LIKELY / 2
    ]
    shown = f"{size:.4g} m" if size > 1 else f"{1e3 * size:.3g} mm"
    read = next((f"read as {unit}" for unit, other in LENGTH_UNITS.items() if other == metres), "read as it says")
    return [
        f"{shown} long: is that so? Its numbers are {read}" + (f"; it would be {', '.join(likely)}" if likely else "")
    ]


@dataclass(frozen=True)
class _Defect:
    """What a body lacks to be the border of a solid: of one body, and of several, in words."""

    one: str
    many: str


def _defects(body: Body) -> dict[str, _Defect]:
    told: dict[str, _Defect] = {}
    if body.open_edges:
        told["open"] = _Defect(
            f"not watertight: {body.open_edges:,} open edges; what is inside it is judged by the rest. If it is a "
            "surface without an inside, say `solid = false`",
            "are not watertight: what is inside them is judged by the rest. If they are surfaces without an inside, "
            "say `solid = false`",
        )
    if body.twisted_edges:
        told["twisted"] = _Defect(
            f"normals disagree at {body.twisted_edges:,} edges; what is inside it may be judged wrongly",
            "have normals that disagree: what is inside them may be judged wrongly",
        )
    if body.volume < 0 and not body.watertight:
        told["inwards"] = _Defect(
            "normals seem to point inwards, so nothing counts as inside it; turn them round",
            "have normals that seem to point inwards, so nothing counts as inside them; turn them round",
        )
    return told


def defects(body: Body) -> list[str]:
    """What a body lacks to be the border of a solid, in words."""
    return [defect.one for defect in _defects(body).values()]


class _Imported(ObstacleModel):
    """What meshes and point clouds share: a file, its unit and where it is put.

    A coordinate x of the file becomes R (scale × x) + position, with R = Rz Ry Rx.
    """

    numbered: ClassVar[bool] = False
    file: Annotated[str, Field(min_length=1)]
    units: Units | None = None
    position: Point = (0.0, 0.0, 0.0)
    rotation_deg: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)
    scale: Annotated[float, Field(gt=0, allow_inf_nan=False)] = 1.0

    _geometry: Geometry | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _units_are_known(self, info: ValidationInfo) -> Self:
        suffix = Path(self.file).suffix.lower()
        if self.units is None and suffix in UNITLESS_SUFFIXES:
            raise ValueError(
                f"{self.file}: {suffix[1:].upper()} files do not say their unit; give `units`, one of "
                f"{', '.join(map(repr, LENGTH_UNITS))}"
            )
        if self.units is not None and suffix in STEP_SUFFIXES:
            raise ValueError(
                f"{self.file}: STEP files say their unit; leave `units` out (`scale` corrects a wrong one)"
            )
        folder = (info.context or {}).get("folder")
        if folder is not None:
            self._geometry = self._read(Path(folder))
            self._placed()  # so that what is too large is refused here
        return self

    @property
    def title(self) -> str:
        """The file's name without its ending."""
        return Path(self.file).stem or self.kind

    @property
    def geometry(self) -> Geometry:
        """What the file holds. One that came with a task file or a plan is not read again."""
        if self._geometry is None:
            self._geometry = self._read(Path())
        return self._geometry

    def with_geometry(self, geometry: Geometry) -> Self:
        """Return this obstacle with the content of its file, which need not be there then."""
        made = self.model_copy()
        made._geometry = geometry
        return made

    @property
    def metres(self) -> float:
        """Metres in the unit of the file's numbers, before `scale`."""
        return LENGTH_UNITS[self.units] if self.units else self.geometry.metres or 1.0

    def remarks(self, every: bool = False) -> list[str]:
        """What a person should know of the file before relying on it, in sentences.

        Parameters
        ----------
        every
            Each body in a sentence of its own, instead of all that have the same defect in one.
        """
        del every  # a cloud has no bodies
        told = [f"{self._called(note)}" for note in self.geometry.notes]
        placed = self._placed()
        size = float((placed.max(axis=0) - placed.min(axis=0)).max())
        return told + [self._called(words) for words in doubtful_size(size, self.metres)]

    def _called(self, words: str, body: str = "") -> str:
        return f"{self.name or self.title}: {body}: {words}" if body else f"{self.name or self.title}: {words}"

    @abstractmethod
    def _read(self, folder: Path) -> Geometry:
        """What the file in a folder holds."""

    def _placed(self) -> NDArray[np.float64]:
        """The file's vertices (v, 3) in the world, m."""
        local = self.geometry.vertices * (self.metres * self.scale)
        reach = float(np.abs(local).max()) + max(map(abs, self.position))
        if reach > LARGEST_LENGTH:
            raise InputError(
                f"{self.file}: reaches out to {reach:.4g} m (at most {LARGEST_LENGTH:,.0f} m): are `units`, `scale` "
                "and `position` right?"
            )
        return meshing.placed(local, rotation_of_degrees(self.rotation_deg), self.position)

    def triangles(self, tolerance: float = TOLERANCE) -> NDArray[np.float64]:
        """Return all triangles (m, 3, 3); not closed where the file is not."""
        return np.concatenate([part.triangles for part in self.parts(tolerance)])


class Mesh(_Imported):
    """Triangles from a file: STL, OBJ, PLY, OFF, GLB, DAE, 3MF; or STEP, with the extra `step`.

    Several bodies in one file are obstacles of their own, "tank: lid"; `bodies` and `without` choose among them. With
    `solid` false it is a surface without an inside: only the distance to it counts. All triangles are thickened by
    `tolerance`, by which the real surface may lie outside of them; those of a STEP file are made that close to its
    surfaces.
    """

    kind: Literal["mesh"] = "mesh"
    tolerance: NonNegativeLength | None = None
    solid: bool = True
    bodies: Patterns | None = None
    without: Patterns | None = None

    @property
    def growth(self) -> float:
        """How far the triangles are thickened, m."""
        if self.tolerance is not None:
            return self.tolerance
        return STEP_TOLERANCE if Path(self.file).suffix.lower() in STEP_SUFFIXES else 0.0

    @model_validator(mode="after")
    def _tolerance_is_possible(self) -> Self:
        if self.tolerance == 0 and Path(self.file).suffix.lower() in STEP_SUFFIXES:
            raise ValueError(
                f"{self.file}: triangles do not meet curved surfaces exactly; a STEP file needs a tolerance above 0"
            )
        return self

    def _read(self, folder: Path) -> Geometry:
        geometry = read_mesh(folder / self.file, self.growth / self.scale)
        try:
            return selected(geometry, self.bodies, self.without)
        except InputError as error:
            raise InputError(f"{self.file}: {error}") from None

    def remarks(self, every: bool = False) -> list[str]:
        """What a person should know of the file before relying on it, in sentences; see `_Imported`."""
        bodies = self.geometry.bodies
        if not self.solid:
            told = [self._called("taken as a surface: nothing counts as inside it (`solid = false`)")]
        elif len(bodies) == 1:
            told = [self._called(words) for words in defects(bodies[0])]
        else:
            told = self._of_bodies(every)
        return told + super().remarks()

    def _of_bodies(self, every: bool) -> list[str]:
        """What is wrong with which of several bodies."""
        bodies = self.geometry.bodies
        found: dict[str, list[tuple[str, _Defect]]] = {}
        for body in bodies:
            for kind, defect in _defects(body).items():
                found.setdefault(kind, []).append((body.name, defect))
        told = []
        for those in found.values():
            if every or len(those) == 1:
                told += [self._called(defect.one, name) for name, defect in those]
                continue
            names = listed([name for name, _ in those])
            all_of_them = f"; `hognose scene {self.file} --notes` lists all" if len(those) > MOST_LISTED else ""
            told.append(
                self._called(f"{len(those):,} of {len(bodies):,} bodies ({names}) {those[0][1].many}{all_of_them}")
            )
        return told

    def parts(self, tolerance: float = TOLERANCE) -> list[Part]:
        """Return one part for each body."""
        del tolerance  # what a file holds is taken as it is
        geometry, placed = self.geometry, self._placed()
        several = len(geometry.bodies) > 1
        return [
            Part(
                body.name if several else "",
                placed[geometry.faces[body.first : body.last]],
                self.growth,
                self.solid,
                0 if several and self.solid and body.open_edges else -1,
            )
            for body in geometry.bodies
        ]


class Points(_Imported):
    """A point cloud: every point is a ball.

    PLY, OBJ, OFF, GLB, PCD; text (XYZ, TXT, CSV, ASC, PTS, PTX); LAS and LAZ with the extra `las`; E57 with the
    extra `e57`.
    """

    kind: Literal["points"] = "points"
    diameter: PositiveLength
    columns: tuple[Column, Column, Column] | None = None
    drop_invalid: bool = False
    thin: NonNegativeLength = 0.0

    @property
    def growth(self) -> float:
        """Radius of the balls, m: of each point, and as much as it may lie off those that it stands for."""
        return self.diameter / 2 + self.thin

    def _read(self, folder: Path) -> Geometry:
        scan = ScanOptions(self.columns, self.drop_invalid, self.thin / self.scale)
        return read_points(folder / self.file, scan, LENGTH_UNITS[self.units] if self.units else None)

    def remarks(self, every: bool = False) -> list[str]:
        """What a person should know of the file before relying on it, in sentences; see `_Imported`."""
        told, said = super().remarks(every), self.geometry.metres
        if said is None or said == self.metres:
            return told
        unit = next((unit for unit, metres in LENGTH_UNITS.items() if metres == said), f"{said:g} m")
        return [self._called(f"its numbers are read as {self.units}, but the file says {unit}"), *told]

    def parts(self, tolerance: float = TOLERANCE) -> list[Part]:
        """Return the cloud: triangles whose corners are one, thickened to balls."""
        del tolerance  # balls are met exactly
        points = self._placed()
        return [Part("", np.repeat(points[:, None], 3, axis=1), self.growth)]


#: Obstacles that come from files.
Imported = Mesh | Points
