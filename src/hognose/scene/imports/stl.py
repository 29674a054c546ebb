"""Reading STL, binary and text."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.scene.imports.content import Content, RawBody, Source
from hognose.scene.imports.integrity import is_binary_stl
from hognose.scene.imports.third_party import read_by_trimesh


def read(source: Source) -> Content:
    """Return the content of an STL file."""
    if not is_binary_stl(source.data):
        return read_by_trimesh(source, "stl")
    vertices, faces = _binary(source.data)
    return Content((RawBody("", vertices, faces),) if len(faces) else ())


def _binary(data: bytes) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    row = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    count = int.from_bytes(data[80:84], "little")
    corners = np.frombuffer(data, row, count, 84)["corners"].astype(np.float64).reshape(-1, 3)
    return corners, np.arange(3 * count).reshape(-1, 3)
