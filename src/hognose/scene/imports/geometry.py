"""What a file of triangles or points holds, as the file has it: not yet placed, in the file's own unit."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

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
        As in the file, with a number behind it if another body has it too; empty if it has none.
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
    called
        What the file calls it, where that is not its name.
    """

    name: str
    first: int
    last: int
    open_edges: int
    twisted_edges: int
    volume: float
    repairs: tuple[str, ...] = ()
    called: str = ""

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
        What was done to it as a whole, and what of the file is not in it, in words.
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

    def only(self, kept: Sequence[int], note: str) -> Geometry:
        """Return it with some of its bodies, by number, and a note more."""
        first, bodies = 0, []
        for body in (self.bodies[k] for k in kept):
            bodies.append(replace(body, first=first, last=first + body.last - body.first))
            first = bodies[-1].last
        faces = np.concatenate([self.faces[self.bodies[k].first : self.bodies[k].last] for k in kept])
        used, corners = np.unique(faces, return_inverse=True)
        corners = corners.reshape(faces.shape).astype(np.int32)
        return Geometry(self.vertices[used], corners, tuple(bodies), self.metres, (*self.notes, note))

    @cached_property
    def digest(self) -> str:
        """SHA-256 of all it holds, in hexadecimal; of volumes only their sign, for the last bits are the machine's."""
        said = [(b.name, b.first, b.last, b.open_edges, b.twisted_edges, b.volume < 0, b.repairs) for b in self.bodies]
        found = hashlib.sha256(repr((said, self.notes)).encode())
        found.update(repr((self.metres, self.vertices.shape, self.faces.shape)).encode())
        found.update(np.ascontiguousarray(self.vertices, "<f8").data)
        found.update(np.ascontiguousarray(self.faces, "<i4").data)
        return found.hexdigest()

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Geometry) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)
