"""Files read by other people's libraries, which are imported here and only when they are used."""

from __future__ import annotations

import io
import logging
import os
import re
import sys
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from hognose.errors import InputError, MissingExtraError
from hognose.scene.obj_file import RawBody

#: Metres in the units that 3MF and GLB files can say, as trimesh calls them.
_METRES = {
    "micron": 1e-6, "microns": 1e-6, "millimeter": 1e-3, "millimeters": 1e-3, "centimeter": 1e-2, "centimeters": 1e-2,
    "inch": 0.0254, "inches": 0.0254, "foot": 0.3048, "feet": 0.3048, "meter": 1.0, "meters": 1.0,
}  # fmt: skip
_COMPRESSIONS = (b"KHR_draco_mesh_compression", b"EXT_meshopt_compression")
#: Steps round bends of STEP surfaces, rad, if the tolerance allows larger ones.
_LARGEST_TURN = 0.35

Found = tuple[list[RawBody], float | None, tuple[str, ...]]


def read_foreign(path: Path, data: bytes, suffix: str) -> Found:
    """Return the bodies of a file, metres in its unit if it says so, and what was left out.

    Raises
    ------
    InputError
        What the library found wrong, without the file's name.
    """
    if suffix in (".glb", ".gltf"):
        for name in _COMPRESSIONS:
            if name in data[:200_000]:
                raise InputError(f"is compressed ({name.decode()}), which is not read; export it uncompressed")
    import trimesh

    with _quiet():
        try:
            more: dict[str, Any] = {"process": False, "skip_materials": True}
            if suffix == ".gltf":
                loaded = trimesh.load_scene(str(path), file_type="gltf", **more)
            else:
                loaded = trimesh.load_scene(io.BytesIO(data), file_type=suffix[1:], **more)
            return _bodies(loaded)
        except InputError:
            raise
        except Exception as error:  # whatever a reader trips over in a damaged file
            said = str(error).strip().splitlines() or [type(error).__name__]
            raise InputError(f"cut, damaged, or not a {suffix[1:].upper()} file: {said[0][:200]}") from None


def read_step(path: Path, tolerance: float) -> Found:
    """Return the bodies of a STEP file as triangles within `tolerance` (m) of its surfaces; errors as above.

    Raises
    ------
    MissingExtraError
        Without the extra `step`.
    """
    try:
        import cascadio
    except ImportError:
        raise MissingExtraError(
            "STEP files need the package cascadio; install it with: pip install 'hognose[step]' "
            "(or export the model as 3MF, which needs nothing more)"
        ) from None
    with tempfile.TemporaryDirectory() as folder, _silent():
        made = Path(folder) / "made.glb"
        # In mm; a little less than asked, for the rounding to single precision.
        done = cascadio.step_to_glb(str(path), str(made), 0.9e3 * tolerance, _LARGEST_TURN)
        data = made.read_bytes() if made.is_file() else b""
    if done != 0 or not data:
        raise InputError("damaged, or not a STEP file that OpenCASCADE can read; export it again, as AP214 or AP242")
    return read_foreign(path, data, ".glb")


def _bodies(loaded: Any) -> Found:
    bodies: list[RawBody] = []
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
            left_out += 1
            bodies.append(("", vertices, np.empty((0, 3), np.int64)))
            continue
        faces = np.asarray(faces, np.int64)
        if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
            raise InputError(
                f"a face names the vertex {int(faces.max())}, but there are {len(vertices):,}; is it cut or damaged?"
            )
        # A mirrored instance would be inside out.
        faces = faces[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0 else faces
        bodies.append((_name(str(node), str(called)), vertices, faces))
    notes = (f"{left_out} without triangles (curves, points) left out",) if left_out else ()
    return bodies, _METRES.get(str(loaded.units)), notes


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


@contextmanager
def _silent() -> Iterator[None]:
    """Let OpenCASCADE, which writes what it finds wrong to the standard output by itself, write nowhere."""
    if sys.stdout is not None:
        sys.stdout.flush()
    try:
        saved, sink = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    except OSError:  # there is no standard output
        yield
        return
    try:
        os.dup2(sink, 1)
        yield
    finally:
        os.dup2(saved, 1)
        os.close(saved)
        os.close(sink)
