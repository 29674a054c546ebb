"""The GLB that OpenCASCADE makes of a STEP file, face by face."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from hognose.scene.imports.content import RawBody, body_at

_TYPES = {5126: np.dtype("<f4"), 5125: np.dtype("<u4"), 5123: np.dtype("<u2"), 5121: np.dtype("u1")}
_POINTS, _TRIANGLES = 0, 4


@dataclass(frozen=True, eq=False)
class Made:
    """What OpenCASCADE made of a STEP file.

    Attributes
    ----------
    bodies
        One for each place a part is at, called after the product; in m.
    faces
        Of how many faces there are triangles; those of a part that is used often counted once.
    curves, points
        How many that belong to no face.
    places
        How many parts of others there are, with geometry or without.
    without
        Names of parts that came out without any geometry.
    """

    bodies: tuple[RawBody, ...]
    faces: int
    curves: int
    points: int
    places: int
    without: tuple[str, ...]


def read_made(data: bytes) -> Made:
    """Return what is in a GLB of OpenCASCADE's."""
    length = int.from_bytes(data[12:16], "little")
    tree: dict[str, Any] = json.loads(data[20 : 20 + length])
    glb = _Glb(tree, data[20 + length + 8 :])
    without: list[str] = []
    for number in tree["scenes"][tree.get("scene", 0)].get("nodes", ()):
        glb.visit(number, np.eye(4), without)
    places = sum(len(node.get("children", ())) for node in tree.get("nodes", ()))
    kinds = list(glb.primitives.values())
    faces, points = kinds.count(_TRIANGLES), kinds.count(_POINTS)
    return Made(tuple(glb.bodies), faces, len(kinds) - faces - points, points, places, tuple(without))


class _Glb:
    def __init__(self, tree: dict[str, Any], binary: bytes) -> None:
        self.tree, self.binary = tree, binary
        self.bodies: list[RawBody] = []
        #: Kind of each primitive, by where its numbers are.
        self.primitives: dict[tuple[int, ...], int] = {}

    def visit(self, number: int, parent: np.ndarray, without: list[str]) -> None:
        """Take a node and all below it."""
        node = self.tree["nodes"][number]
        matrix = parent @ np.reshape(node.get("matrix", np.eye(4)), (4, 4)).T
        if "mesh" in node:
            self.take(self.tree["meshes"][node["mesh"]], str(node.get("name", "")), matrix)
        elif not node.get("children"):
            without.append(str(node.get("name", "")))
        for child in node.get("children", ()):
            self.visit(child, matrix, without)

    def take(self, mesh: dict[str, Any], instance: str, matrix: np.ndarray) -> None:
        """One body of all faces of a mesh; a mirrored one is turned right side out."""
        vertices, faces, offset = [], [], 0
        for primitive in mesh["primitives"]:
            kind = primitive.get("mode", _TRIANGLES)
            self.primitives[primitive["attributes"]["POSITION"], primitive.get("indices", -1)] = kind
            if kind == _TRIANGLES:
                points = self.numbers(primitive["attributes"]["POSITION"]).reshape(-1, 3).astype(np.float64)
                faces.append(self.numbers(primitive["indices"]).reshape(-1, 3).astype(np.int64) + offset)
                vertices.append(points)
                offset += len(points)
        if offset:
            called = str(mesh.get("name", "")) or instance
            parts = np.concatenate(vertices), np.concatenate(faces)
            self.bodies.append(body_at(called, *parts, matrix[:3, :3], matrix[:3, 3]))

    def numbers(self, number: int) -> np.ndarray:
        """The numbers of an accessor, in a row."""
        accessor = self.tree["accessors"][number]
        view = self.tree["bufferViews"][accessor["bufferView"]]
        kind = _TYPES[accessor["componentType"]]
        width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
        begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        return np.frombuffer(self.binary, kind, accessor["count"] * width, begin)
