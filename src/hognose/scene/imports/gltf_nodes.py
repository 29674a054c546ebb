"""Where the nodes of a glTF file put its meshes.

Source: "glTF 2.0 Specification", section 3.5 (scenes, node hierarchy, transformations); EXT_mesh_gpu_instancing.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from hognose.errors import InputError
from hognose.scene.imports.content import MOST_ELEMENTS, Floats
from hognose.scene.imports.gltf_accessors import Accessors
from hognose.scene.imports.gltf_document import Document

_INSTANCING = "EXT_mesh_gpu_instancing"
#: How far from 1 the length of a rotation's quaternion may be: what is more is no rounding.
_ROUNDING = 0.01


def called(document: Document, number: int) -> str:
    """Return what a message calls a node."""
    name = document.nodes[number].name
    return f"node {number} ({name[:40]!r})" if name else f"node {number}"


def roots(document: Document) -> list[int]:
    """Return the nodes that no other has as its child.

    Raises
    ------
    InputError
        Nodes are no trees: one is a child of itself, or of several others; or a child or a root that is not there.
    """
    parent: dict[int, int] = {}
    for number, node in enumerate(document.nodes):
        for child in node.children:
            if child >= len(document.nodes):
                raise InputError(f"damaged: {called(document, number)} has the child {child}, which is not there")
            if child in parent:
                raise InputError(
                    f"damaged: {called(document, child)} is a child of {called(document, parent[child])} and again of "
                    f"{called(document, number)}"
                )
            parent[child] = number
    found = [number for number in range(len(document.nodes)) if number not in parent]
    reached = {number for number, _ in placed(document, found)}
    if len(reached) < len(document.nodes):
        lost = next(number for number in range(len(document.nodes)) if number not in reached)
        raise InputError(f"damaged: {called(document, lost)} is a child of itself, directly or through others")
    return found


def placed(document: Document, tops: list[int]) -> Iterator[tuple[int, Floats]]:
    """Yield the nodes below some roots, in the file's order, each with its T_scene_node (4, 4)."""
    waiting = [(number, np.eye(4)) for number in reversed(tops)]
    while waiting:
        number, above = waiting.pop()
        matrix = above @ _local(document, number)
        yield number, matrix
        waiting += [(child, matrix) for child in reversed(document.nodes[number].children)]


def _local(document: Document, number: int) -> Floats:
    node = document.nodes[number]
    shifts = node.translation, node.rotation, node.scale
    if node.matrix is not None:
        if any(given is not None for given in shifts):
            raise InputError(f"damaged: {called(document, number)} has a matrix, and a translation, rotation or scale")
        made = np.array(node.matrix).reshape(4, 4).T
        if not np.array_equal(made[3], [0, 0, 0, 1]):
            raise InputError(f"damaged: the matrix of {called(document, number)} does not end in 0, 0, 0, 1")
        return made
    if shifts == (None, None, None):
        return np.eye(4)
    translation, rotation, scale = (
        np.array([default if given is None else given])
        for given, default in zip(shifts, ([0.0, 0, 0], [0.0, 0, 0, 1], [1.0, 1, 1]), strict=True)
    )
    return _matrices(translation, rotation, scale, called(document, number))[0]


def _matrices(translation: Floats, rotation: Floats, scale: Floats, where: str) -> Floats:
    """Return T R S (k, 4, 4) of translations (k, 3), quaternions x, y, z, w (k, 4) and scales (k, 3)."""
    length = np.linalg.norm(rotation, axis=1)
    if not (np.abs(length - 1) < _ROUNDING).all():  # NaN too
        raise InputError(f"damaged: the rotation of {where} is no unit quaternion")
    x, y, z, w = (rotation / length[:, None]).T
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    made = np.zeros((len(translation), 4, 4))
    made[:, :3, :3] = np.moveaxis(turn, 2, 0) * scale[:, None, :]
    made[:, :3, 3] = translation
    made[:, 3, 3] = 1
    return made


def instances(accessors: Accessors, number: int, most: int) -> Floats:
    """Return T_node_instance (k, 4, 4) of the instances of a node's mesh: one, the identity, unless it has several.

    Raises
    ------
    InputError
        There are more than `most`, or it does not say where they are.
    """
    document = accessors.document
    said: Any = document.nodes[number].extensions.get(_INSTANCING)
    if said is None:
        _refuse_more(1, most)
        return np.eye(4)[None]
    where = f"{_INSTANCING} of {called(document, number)}"
    attributes = said.get("attributes") if isinstance(said, dict) else None
    if not isinstance(attributes, dict) or not all(type(k) is int and k >= 0 for k in attributes.values()):
        raise InputError(f"damaged: {where} has no attributes")
    kinds = {"TRANSLATION": "VEC3", "ROTATION": "VEC4", "SCALE": "VEC3"}
    found = {
        name: accessors.rows(attributes[name], kind, "instances") for name, kind in kinds.items() if name in attributes
    }
    counts = {len(values) for values in found.values()}
    if not counts:
        raise InputError(f"damaged: {where} does not say where its instances are")
    if len(counts) > 1:
        raise InputError(f"damaged: {where} has attributes of different lengths")
    (count,) = counts
    _refuse_more(count, most)
    default = {"TRANSLATION": [0.0, 0, 0], "ROTATION": [0.0, 0, 0, 1], "SCALE": [1.0, 1, 1]}
    rows = [found[name].decoded(slice(None)) if name in found else np.tile(default[name], (count, 1)) for name in kinds]
    return _matrices(rows[0], rows[1], rows[2], f"an instance of {called(document, number)}")


def _refuse_more(count: int, most: int) -> None:
    if count > most:
        raise InputError(f"holds more than {MOST_ELEMENTS:,} triangles or points; make it coarser")
