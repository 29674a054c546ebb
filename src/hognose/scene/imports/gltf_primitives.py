"""The meshes of a glTF file: primitives of every mode, put together to one body a mesh.

Source: "glTF 2.0 Specification", sections 3.7.2 (meshes: modes, morph targets).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hognose.errors import InputError
from hognose.scene.imports.content import Floats, Ints
from hognose.scene.imports.gltf_accessors import Accessors, Values
from hognose.scene.imports.gltf_document import Primitive

_POINTS, _LINES, _TRIANGLES, _STRIP, _FAN = 0, (1, 2, 3), 4, 5, 6


@dataclass(frozen=True, eq=False)
class Shape:
    """One mesh: vertices (v, 3), faces (m, 3), points (p, 3), and what it has that is neither, by its name."""

    vertices: Floats
    faces: Ints
    points: Floats
    others: tuple[str, ...] = ()


@dataclass(frozen=True)
class Meshes:
    """The meshes of a file, each made once for each set of weights of its morph targets."""

    accessors: Accessors
    _made: dict[tuple[int, tuple[float, ...]], Shape] = field(default_factory=dict)

    def shape(self, number: int, weights: list[float] | None) -> Shape:
        """Return a mesh; `weights` are those of its node, if it has any of its own."""
        meshes = self.accessors.document.meshes
        if number >= len(meshes):
            raise InputError(f"damaged: a node places mesh {number}, but it has {len(meshes)}")
        key = number, tuple(meshes[number].weights if weights is None else weights)
        if key not in self._made:
            self._made[key] = self._shape(*key)
        return self._made[key]

    def _shape(self, number: int, weights: tuple[float, ...]) -> Shape:
        vertices, faces, points = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], [np.empty((0, 3))]
        others: list[str] = []
        first = 0
        for order, primitive in enumerate(self.accessors.document.meshes[number].primitives):
            where = f"primitive {order} of mesh {number}"
            if primitive.mode in _LINES:
                others.append("of lines")
            elif "POSITION" not in primitive.attributes:
                others.append("without positions")
            else:
                places, corners = self._corners(primitive, weights, where)
                if primitive.mode == _POINTS:
                    points.append(places[corners])
                else:
                    vertices.append(places)
                    faces.append(_triangles(primitive.mode, corners, where) + first)
                    first += len(places)
        return Shape(np.concatenate(vertices), np.concatenate(faces), np.concatenate(points), tuple(others))

    def _corners(self, primitive: Primitive, weights: tuple[float, ...], where: str) -> tuple[Floats, Ints]:
        """The places that a primitive uses, (v, 3), and for each of its corners which of these it is."""
        positions = self.accessors.rows(primitive.attributes["POSITION"], "VEC3", "positions")
        rows: Ints | slice = slice(None)
        if primitive.indices is None:
            corners = np.arange(len(positions))
        else:
            corners = self.accessors.indices(primitive.indices)
            if len(corners) and int(corners.max()) >= len(positions):
                raise InputError(
                    f"damaged: {where} names the vertex {int(corners.max()):,}, but there are {len(positions):,}"
                )
            # Many primitives may use one large accessor, each a little of it.
            if len(corners) < len(positions):
                rows, corners = np.unique(corners, return_inverse=True)
        places = positions.decoded(rows)
        for values, weight in self._morphs(primitive, weights, len(positions), where):
            places = places + weight * values.decoded(rows)
        return places, corners

    def _morphs(
        self, primitive: Primitive, weights: tuple[float, ...], count: int, where: str
    ) -> list[tuple[Values, float]]:
        if any(weights) and len(weights) != len(primitive.targets):
            raise InputError(f"damaged: {where} has {len(primitive.targets)} morph targets, but {len(weights)} weights")
        found: list[tuple[Values, float]] = []
        for target, weight in zip(primitive.targets, weights, strict=False):
            if weight and "POSITION" in target:
                values = self.accessors.rows(target["POSITION"], "VEC3", "morph targets")
                if len(values) != count:
                    raise InputError(f"damaged: a morph target of {where} has {len(values):,} rows, expected {count:,}")
                found.append((values, weight))
        return found


def _triangles(mode: int, corners: Ints, where: str) -> Ints:
    """Triangles (m, 3) of the corners of a primitive, all wound as its first."""
    if mode == _TRIANGLES:
        if len(corners) % 3:
            raise InputError(f"cut or damaged: {where} has {len(corners):,} corners, no whole number of triangles")
        return corners.reshape(-1, 3)
    if mode not in (_STRIP, _FAN):
        raise InputError(f"damaged: {where} has the mode {mode}, expected 0 to 6")
    if 0 < len(corners) < 3:
        raise InputError(f"cut or damaged: {where} has {len(corners)} corners, too few for a triangle")
    count = np.arange(max(len(corners) - 2, 0))
    if mode == _STRIP:
        made = corners[np.stack([count, count + 1 + count % 2, count + 2 - count % 2], axis=1)]
    else:
        made = corners[np.stack([count + 1, count + 2, np.zeros_like(count)], axis=1)]
    # A strip repeats corners to go on elsewhere: such triangles are no surface, and would be walls between its parts.
    return made[(made != np.roll(made, 1, axis=1)).all(axis=1)]
