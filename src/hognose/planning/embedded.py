"""The content of mesh and point files inside a plan file, so that the plan needs them no more."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.planning.damage import ALTERED, REMEDY
from hognose.planning.task import TaskSpec
from hognose.scene.imports.geometry import Body, Geometry
from hognose.scene.imports.imported import Imported

#: An entry of the Parquet metadata is called this and the geometry's digest.
PREFIX = "hognose.geometry."
#: No geometry unpacks to more than this (bytes).
_LARGEST = 4_000_000_000
_KINDS = {"<f4": np.dtype("<f4"), "<f8": np.dtype("<f8"), "<i4": np.dtype("<i4")}


def digests(spec: TaskSpec) -> list[str | None]:
    """The digest of each obstacle's geometry; None for those that come from no file."""
    return [item.geometry.digest if isinstance(item, Imported) else None for item in spec.obstacle]


def entries(spec: TaskSpec) -> dict[str, str]:
    """Metadata entries that hold every geometry of a task once."""
    found = {item.geometry.digest: item.geometry for item in spec.obstacle if isinstance(item, Imported)}
    return {PREFIX + digest: packed(geometry) for digest, geometry in found.items()}


def restored(spec: TaskSpec, said: Iterable[str | None], held: Mapping[str, str]) -> TaskSpec:
    """The spec with the geometry of its obstacles, from the metadata entries of a plan file.

    Raises
    ------
    InputError
        An entry is missing, damaged, not what its digest says, or for an obstacle that needs none.
    """
    unpacked: dict[str, Geometry] = {}
    obstacles = []
    for item, digest in zip(spec.obstacle, said, strict=True):
        if isinstance(item, Imported):
            if digest is None or PREFIX + digest not in held:
                raise InputError(f"the plan file does not hold the geometry of {item.file!r}: {ALTERED}")
            if digest not in unpacked:
                unpacked[digest] = _checked(held[PREFIX + digest], digest, item.file)
            item = item.with_geometry(unpacked[digest])
        elif digest is not None:
            raise InputError(
                f"the plan file names the geometry {digest[:16]} for an obstacle that comes from no file: {ALTERED}"
            )
        obstacles.append(item)
    return spec.model_copy(update={"obstacle": tuple(obstacles)})


def packed(geometry: Geometry) -> str:
    """A geometry as text: a line of JSON that says what follows, and base 64 of arrays compressed by Zstandard."""
    single = geometry.vertices.astype("<f4")
    vertices = single if np.array_equal(single.astype(np.float64), geometry.vertices) else geometry.vertices
    arrays = {"vertices": np.ascontiguousarray(vertices), "faces": np.ascontiguousarray(geometry.faces)}
    # Numbers alike lie together when their bytes do: the first bytes of all, then the second ones.
    raw = b"".join(array.reshape(-1, 1).view(np.uint8).T.tobytes() for array in arrays.values())
    head = {
        "arrays": {name: [array.dtype.newbyteorder("<").str, list(array.shape)] for name, array in arrays.items()},
        "bytes": len(raw),
        "bodies": [asdict(body) for body in geometry.bodies],
        "metres": geometry.metres,
        "notes": geometry.notes,
    }
    packed = pa.compress(raw, codec="zstd", asbytes=True)
    return json.dumps(head) + "\n" + base64.b64encode(packed).decode()


def _checked(text: str, digest: str, file: str) -> Geometry:
    try:
        geometry = _unpacked(text)
    except (ValueError, KeyError, TypeError, OSError, pa.ArrowException, MemoryError):
        raise InputError(f"the geometry of {file!r} in the plan file is damaged. {REMEDY}") from None
    if geometry.digest != digest:
        raise InputError(f"the geometry of {file!r} in the plan file is not the one it was made with: {ALTERED}")
    return geometry


def _unpacked(text: str) -> Geometry:
    said, _, body = text.partition("\n")
    head: dict[str, Any] = json.loads(said)
    if not 0 <= head["bytes"] <= _LARGEST:
        raise ValueError
    raw = pa.decompress(base64.b64decode(body, validate=True), head["bytes"], codec="zstd", asbytes=True)
    arrays: dict[str, NDArray[Any]] = {}
    begin = 0
    for name, (kind, shape) in head["arrays"].items():
        size = int(np.prod(shape)) * _KINDS[kind].itemsize
        bytes_ = np.frombuffer(raw[begin : begin + size], np.uint8).reshape(_KINDS[kind].itemsize, -1)
        arrays[name] = np.ascontiguousarray(bytes_.T).view(_KINDS[kind]).reshape(shape)
        begin += size
    vertices, faces = arrays["vertices"].astype(np.float64), arrays["faces"].astype(np.int32)
    if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise ValueError
    bodies = tuple(Body(**{**body, "repairs": tuple(body["repairs"])}) for body in head["bodies"])
    begins, ends = [body.first for body in bodies], [body.last for body in bodies]
    if bodies and (begins != [0, *ends[:-1]] or ends[-1] != len(faces) or begins >= ends):
        raise ValueError
    return Geometry(vertices, faces, bodies, head["metres"], tuple(head["notes"]))
