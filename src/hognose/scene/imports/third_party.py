"""Files read by trimesh, which is imported when a file needs it."""

from __future__ import annotations

import io
import logging
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from hognose.errors import InputError
from hognose.scene.imports.content import Content, RawBody, Source

#: Metres in the units that 3MF and GLB files can say, as trimesh calls them.
_METRES = {
    "micron": 1e-6, "microns": 1e-6, "millimeter": 1e-3, "millimeters": 1e-3, "centimeter": 1e-2, "centimeters": 1e-2,
    "inch": 0.0254, "inches": 0.0254, "foot": 0.3048, "feet": 0.3048, "meter": 1.0, "meters": 1.0,
}  # fmt: skip


def read_by_trimesh(source: Source, kind: str) -> Content:
    """Return the content of a file as trimesh reads it; `kind` is its name of the format.

    Raises
    ------
    InputError
        What the library found wrong, without the file's name.
    """
    import trimesh

    with _quiet():
        try:
            more: dict[str, Any] = {"process": False, "skip_materials": True}
            if kind == "gltf":
                loaded = trimesh.load_scene(str(source.path), file_type="gltf", **more)
            else:
                loaded = trimesh.load_scene(io.BytesIO(source.data), file_type=kind, **more)
            return _content(loaded)
        except InputError:
            raise
        except Exception as error:  # whatever a reader trips over in a damaged file
            said = str(error).strip().splitlines() or [type(error).__name__]
            raise InputError(f"cut, damaged, or not a {kind.upper()} file: {said[0][:200]}") from None


def _content(loaded: Any) -> Content:
    bodies: list[RawBody] = []
    points = [np.empty((0, 3))]
    left_out = 0
    for node in sorted(loaded.graph.nodes_geometry, key=str):
        matrix, called = loaded.graph[node]
        shape = loaded.geometry[called]
        vertices, faces = np.asarray(shape.vertices, np.float64), getattr(shape, "faces", None)
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            left_out += 1
            continue
        vertices = vertices @ matrix[:3, :3].T + matrix[:3, 3]
        if faces is None:
            points.append(vertices)
            continue
        faces = np.asarray(faces, np.int64)
        if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
            raise InputError(
                f"a face names the vertex {int(faces.max())}, but there are {len(vertices):,}; is it cut or damaged?"
            )
        # A mirrored instance would be inside out.
        faces = faces[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0 else faces
        if len(faces):
            bodies.append(RawBody(_name(str(node), str(called)), vertices, faces))
    notes = (f"{left_out} without triangles (curves) left out",) if left_out else ()
    return Content(tuple(bodies), np.concatenate(points), _METRES.get(str(loaded.units)), notes)


def _name(node: str, shape: str) -> str:
    """The name of a node, or of its shape where the node has none but what a library made up; empty if neither has."""
    for name in (node, shape):
        if not re.match(r"geometry(_\d+)?$|=>\[", name):
            return name
    return ""


@contextmanager
def _quiet() -> Iterator[None]:
    """Let trimesh not warn: what it finds wrong is in our message."""
    logger = logging.getLogger("trimesh")
    was = logger.disabled
    logger.disabled = True
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logger.disabled = was
