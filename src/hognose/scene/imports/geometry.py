"""What a file of triangles or points holds, as the file has it: not yet placed, in the file's own unit."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.cached import cached_property

Floats = NDArray[np.float64]
Faces = NDArray[np.int32]


@dataclass(frozen=True)
class Body:
    """One body of a file.

    Attributes
    ----------
    name
        As in the file; empty if it has none.
    first, last
        Its faces are `first` … `last - 1` of the geometry.
    open_edges
        Edges of holes: not shared by two triangles.
    twisted_edges
        Edges on which two triangles are wound against each other.
    volume
        Enclosed volume, in the file's unit cubed; meaningful for a watertight body.
    repairs
        What was done to it, in words.
    """

    name: str
    first: int
    last: int
    open_edges: int
    twisted_edges: int
    volume: float
    repairs: tuple[str, ...] = ()

    @property
    def watertight(self) -> bool:
        """Whether it encloses a volume: no hole, and wound one way."""
        return not (self.open_edges or self.twisted_edges)


@dataclass(frozen=True, eq=False)
class Geometry:
    """The content of a file.

    Attributes
    ----------
    vertices : (v, 3)
        In the file's unit.
    faces : (m, 3) int32
        Corners of the triangles, body after body; none for a point cloud.
    bodies
        Of a mesh; none for a point cloud.
    metres
        Metres in the file's unit, or None if its format does not say.
    notes
        What was done to a point cloud, in words.
    """

    vertices: Floats
    faces: Faces
    bodies: tuple[Body, ...]
    metres: float | None
    notes: tuple[str, ...] = ()

    @property
    def is_cloud(self) -> bool:
        """Whether it holds points instead of triangles."""
        return not len(self.faces)

    @property
    def watertight(self) -> bool:
        """Whether all bodies are."""
        return all(body.watertight for body in self.bodies)

    @property
    def repairs(self) -> tuple[str, ...]:
        """What was done to it, in words; with the body's name where there are several."""
        several = len(self.bodies) > 1
        told = [f"{body.name}: {words}" if several else words for body in self.bodies for words in body.repairs]
        return (*told, *self.notes)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of vertices, faces and bodies, in hexadecimal."""
        found = hashlib.sha256(repr([(b.name, b.first, b.last) for b in self.bodies]).encode())
        found.update(repr((self.metres, self.vertices.shape, self.faces.shape)).encode())
        found.update(np.ascontiguousarray(self.vertices, "<f8").data)
        found.update(np.ascontiguousarray(self.faces, "<i4").data)
        return found.hexdigest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Geometry) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)
