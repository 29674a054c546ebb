"""What a mesh, point or STEP file holds, or the obstacles of a task, for a person to judge before planning."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hognose.arguments import plain_name
from hognose.errors import InputError
from hognose.files.loading import load_task
from hognose.read_whole import read_whole
from hognose.scene import Mesh, ObstacleModel, Points
from hognose.scene.imports.formats import BY_SUFFIX, MESH_SUFFIXES, POINT_SUFFIXES, STEP_SUFFIXES, UNITLESS_SUFFIXES
from hognose.scene.imports.imported import Imported, defects
from hognose.scene.imports.other_formats import foreign
from hognose.scene.imports.ply_header import header
from hognose.scene.imports.reading import LARGEST_FILE
from hognose.scene.obstacle import named_parts
from hognose.scene.part import Part
from hognose.units import LENGTH_UNITS, SMALLEST_SIZE

Place = tuple[float, float, float]


@dataclass(frozen=True)
class Item:
    """One body, point cloud or obstacle.

    Attributes
    ----------
    name, kind
    low, high
        Lowest and highest coordinates, m.
    triangles, points
        How many; one of them is zero.
    watertight
        None for points.
    volume
        Enclosed, m³; None for what is not watertight.
    repairs
        What was done to it, in words.
    defects
        What it lacks to be the border of a solid, in words.
    moves
        Whether it is given a motion; the coordinates are those as placed.
    """

    name: str
    kind: str
    low: Place
    high: Place
    triangles: int
    points: int
    watertight: bool | None
    volume: float | None
    repairs: tuple[str, ...]
    defects: tuple[str, ...] = ()
    moves: bool = False

    @property
    def size(self) -> Place:
        """Its sides, m."""
        x, y, z = (top - bottom for bottom, top in zip(self.low, self.high, strict=True))
        return x, y, z


@dataclass(frozen=True)
class Inspection:
    """The content of a file.

    Attributes
    ----------
    source
    units
        The unit its numbers were read in, "mm" or another; None for a task.
    units_from
        Who says so: "file", "asked", or "guess" where nobody does.
    low, high
        Lowest and highest coordinates of all, m.
    items
    remarks
        What a person should know, in sentences.
    """

    source: str
    units: str | None
    units_from: str
    low: Place
    high: Place
    items: tuple[Item, ...]
    remarks: tuple[str, ...]


def inspect(source: str, units: str | None = None, every: bool = False) -> Inspection:
    """Look into a file.

    Parameters
    ----------
    source
        A mesh, STEP or point file, a task file, or a bundled task.
    units
        Unit of the numbers of a mesh or point file.
    every
        A remark for each body, instead of one for all that have the same defect.

    Raises
    ------
    InputError
        The file cannot be read, or an unknown unit.
    """
    plain_name(source)
    if units is not None and units not in LENGTH_UNITS:
        raise InputError(f"--units: {units!r} is unknown; expected one of {', '.join(LENGTH_UNITS)}")
    path = Path(source)
    if path.suffix.lower() in (*MESH_SUFFIXES, *POINT_SUFFIXES):
        return of_obstacle(opened(path, units), units, every)
    if units is not None:
        raise InputError(f"{source}: --units is for mesh and point files; a task file says its own")
    if path.suffix and path.suffix != ".toml" and path.exists():
        known = ", ".join(dict.fromkeys((*MESH_SUFFIXES, *POINT_SUFFIXES, ".toml")))
        raise InputError(f"{source}: {foreign(path.suffix)} Expected {known}.")
    obstacles = load_task(source).spec.obstacle
    remarks = [words for item in obstacles if isinstance(item, Imported) for words in item.remarks(every)]
    return _inspection(source, None, "file", obstacles, tuple(remarks))


def opened(path: Path, units: str | None) -> Imported:
    """The obstacle that a mesh, STEP or point file describes, where its coordinates put it; points are tiny balls.

    `units` is that of the numbers in the file; of files that do not say it, mm unless given.

    Raises
    ------
    InputError
        The file cannot be read, or a unit for a file that says its own.
    """
    suffix = path.suffix.lower()
    if units is not None and suffix in STEP_SUFFIXES:
        raise InputError(f"{path}: STEP files say their unit; leave --units out")
    taken = units or ("mm" if suffix in UNITLESS_SUFFIXES else None)
    row, said = BY_SUFFIX[suffix], {"file": str(path), "units": taken}
    cloud = Points.model_validate({**said, "diameter": SMALLEST_SIZE}) if row.points else None
    if cloud is not None and (not row.meshes or (suffix == ".ply" and not _has_faces(path))):
        return cloud
    mesh = Mesh.model_validate(said)
    fault = _fault(mesh)
    if fault is not None and cloud is not None and _fault(cloud) is None:
        return cloud
    if fault is not None:
        raise fault
    return mesh


def _fault(item: Imported) -> InputError | None:
    """Why the file of an obstacle cannot be read, if so."""
    try:
        item.geometry  # noqa: B018 - it is read here
    except InputError as error:
        return error
    return None


def of_obstacle(item: Imported, units: str | None, every: bool = False) -> Inspection:
    """What an obstacle that was `opened` holds; `units` is what was asked for."""
    silent = Path(item.file).suffix.lower() in UNITLESS_SUFFIXES
    remarks = item.remarks(every)
    said = item.units or next((name for name, size in LENGTH_UNITS.items() if size == item.metres), "m")
    if silent and units is None:
        remarks.insert(
            0,
            "the file does not say its unit, so mm is assumed (--units says another): its longest side is "
            f"{in_every_unit(item)}",
        )
    return _inspection(item.file, said, "asked" if units else "guess" if silent else "file", (item,), tuple(remarks))


def in_every_unit(item: Imported) -> str:
    """How long a file's longest side is if its numbers are in this unit or that."""
    points = item.geometry.vertices
    size = float((points.max(axis=0) - points.min(axis=0)).max())
    return ", ".join(f"{size * metres:.4g} m in {unit}" for unit, metres in LENGTH_UNITS.items())


def _has_faces(path: Path) -> bool:
    try:
        elements = header(read_whole(path, LARGEST_FILE)[:20_000]).elements
    except InputError:
        return True  # said by whoever reads all of it
    return any(element.rows for element in elements if element.name in ("face", "tristrips"))


def _inspection(
    source: str, units: str | None, units_from: str, obstacles: tuple[ObstacleModel, ...], remarks: tuple[str, ...]
) -> Inspection:
    parts = iter(named_parts(obstacles))
    items = tuple(item for obstacle in obstacles for item in _items(obstacle, parts))
    low = np.min([item.low for item in items], axis=0) if items else np.zeros(3)
    high = np.max([item.high for item in items], axis=0) if items else np.zeros(3)
    return Inspection(source, units, units_from, _place(low), _place(high), items, remarks)


def _items(obstacle: ObstacleModel, parts: Iterator[Part]) -> Iterator[Item]:
    """One item for each part of an obstacle; `parts` yields them all in turn."""
    bodies = obstacle.geometry.bodies if isinstance(obstacle, Mesh) else (None,)
    moves = bool(obstacle.motion)
    for body in bodies:
        part = next(parts)
        corners = part.triangles.reshape(-1, 3)
        low, high = _place(corners.min(axis=0)), _place(corners.max(axis=0))
        if isinstance(obstacle, Points):
            repairs = obstacle.geometry.notes
            yield Item(part.name, obstacle.kind, low, high, 0, len(part.triangles), None, None, repairs, moves=moves)
            continue
        watertight = body is None or body.watertight
        middle = corners.mean(axis=0)
        volume = float(np.linalg.det(part.triangles - middle).sum() / 6) if watertight else None
        repairs, faults = ((), ()) if body is None else (body.repairs, tuple(defects(body)))
        yield Item(
            part.name, obstacle.kind, low, high, len(part.triangles), 0, watertight, volume, repairs, faults, moves
        )


def _place(point: NDArray[np.float64]) -> Place:
    x, y, z = point.tolist()
    return x, y, z
