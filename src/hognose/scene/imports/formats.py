"""Every format that obstacles are read from: one row each. The readers are imported when a file needs them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module

from hognose.scene.imports.content import Content, Source

Reader = Callable[[Source], Content]


@dataclass(frozen=True)
class Format:
    """One file format.

    Attributes
    ----------
    suffixes
        With their dots, in lower case; the first names the format.
    module
        The module beside this one whose `read` takes a `Source` and returns its `Content`.
    meshes, points
        What such a file can hold.
    says_unit
        Whether the file says what unit its numbers have.
    curved
        Whether triangles are made of its surfaces, to a tolerance.
    """

    suffixes: tuple[str, ...]
    module: str
    meshes: bool = True
    points: bool = False
    says_unit: bool = False
    curved: bool = False

    @property
    def read(self) -> Reader:
        """The reader, imported now."""
        return import_module(f"hognose.scene.imports.{self.module}").read


FORMATS = (
    Format((".stl",), "stl"),
    Format((".obj",), "obj", points=True),
    Format((".ply",), "ply", points=True),
    Format((".off",), "off", points=True),
    Format((".glb", ".gltf"), "gltf", points=True, says_unit=True),
    Format((".dae",), "dae", says_unit=True),
    Format((".3mf",), "threemf", says_unit=True),
    Format((".step", ".stp"), "step", says_unit=True, curved=True),
    Format((".xyz", ".txt", ".csv", ".asc", ".pts", ".ptx"), "text_points", meshes=False, points=True),
    Format((".pcd",), "pcd", meshes=False, points=True),
    Format((".las", ".laz"), "las", meshes=False, points=True),
    Format((".e57",), "e57", meshes=False, points=True, says_unit=True),
)

#: The format of each ending.
BY_SUFFIX = {suffix: row for row in FORMATS for suffix in row.suffixes}
#: Endings of meshes; of point clouds; of files that do not say their unit; of those triangles are made of.
MESH_SUFFIXES = tuple(suffix for suffix, row in BY_SUFFIX.items() if row.meshes)
POINT_SUFFIXES = tuple(suffix for suffix, row in BY_SUFFIX.items() if row.points)
UNITLESS_SUFFIXES = tuple(suffix for suffix, row in BY_SUFFIX.items() if not row.says_unit)
STEP_SUFFIXES = tuple(suffix for suffix, row in BY_SUFFIX.items() if row.curved)
