"""Reading Wavefront OBJ: vertices, faces and the names of objects and groups."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.scene.imports.content import Content, RawBody, Source


def read(source: Source) -> Content:
    """Return the content of an OBJ file: one body an object or group that has faces of its own.

    Polygons are cut into fans of triangles: of one that is not convex these cover it, and perhaps more.

    Raises
    ------
    InputError
        A line that is not what it says; tells its number.
    """
    return _content(source.data)


def _content(data: bytes) -> Content:
    vertices: list[bytes] = []
    faces: list[bytes] = []
    known: list[int] = []  # vertices before each face
    heads: list[tuple[bytes, int]] = [(b"", 0)]
    for line in data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").splitlines():
        kind = line[:2]
        if kind == b"v " or kind == b"v\t":
            vertices.append(line[2:])
        elif kind == b"f " or kind == b"f\t":
            faces.append(line[2:])
            known.append(len(vertices))
        elif kind in (b"o ", b"g "):
            heads.append((line[2:].strip(), len(faces)))
        elif line[:1] in (b" ", b"\t") and line.strip()[:2] in (b"v ", b"f ", b"o ", b"g "):
            return _content(b"\n".join(each.strip() for each in data.splitlines()))
    if not faces:
        return Content(points=_numbers(vertices))
    places = _numbers(vertices)
    triangles, counts = _triangles(faces, np.array(known), len(places))
    ends = np.append(0, np.cumsum(counts))
    bodies: list[RawBody] = []
    for (name, begin), (_, end) in zip(heads, [*heads[1:], (b"", len(faces))], strict=True):
        if end > begin:
            bodies.append(RawBody(name.decode("utf-8", "replace"), places, triangles[ends[begin] : ends[end]]))
    return Content(_joined(bodies))


def _joined(bodies: list[RawBody]) -> tuple[RawBody, ...]:
    """Bodies with parts of one name, as exporters write them for each material, put together."""
    by_name: dict[str, list[NDArray[np.int64]]] = {}
    for body in bodies:
        by_name.setdefault(body.name, []).append(body.faces)
    return tuple(RawBody(name, bodies[0].vertices, np.concatenate(parts)) for name, parts in by_name.items())


def _numbers(lines: list[bytes]) -> NDArray[np.float64]:
    """Coordinates (v, 3); more numbers on a line are weights or colours."""
    try:
        values = np.array(b" ".join(lines).split()).astype(np.float64)
        if values.size == 3 * len(lines) and all(len(line.split()) == 3 for line in lines[:: max(1, len(lines) // 99)]):
            return values.reshape(-1, 3)
        return np.array([line.split()[:3] for line in lines]).astype(np.float64).reshape(-1, 3)
    except ValueError:
        for number, line in enumerate(lines, 1):
            parts = line.split()[:3]
            if len(parts) < 3 or not all(_is_number(part) for part in parts):
                raise InputError(f"vertex {number} is {_shown(line)}, expected three numbers") from None
        raise


def _triangles(lines: list[bytes], known: NDArray[np.int64], vertices: int) -> tuple[NDArray, NDArray[np.int64]]:
    """Return triangles (m, 3) of 0-based indices, and how many each face gave."""
    text = re.sub(rb"/[^\s]*", b"", b"\n".join(lines))
    corners = np.array([len(line.split()) for line in text.split(b"\n")])
    if corners.min() < 3:
        worst = int(corners.argmin())
        raise InputError(f"face {worst + 1} is {_shown(lines[worst])}, expected three vertices or more")
    try:
        index = np.array(text.split()).astype(np.int64)
    except ValueError:
        for number, line in enumerate(text.split(b"\n"), 1):
            if not re.fullmatch(rb"\s*([+-]?\d+\s*)+", line):
                raise InputError(f"face {number} is {_shown(line)}, expected numbers of vertices") from None
        raise
    before = np.repeat(known, corners)
    index = np.where(index < 0, before + index, index - 1)
    wrong = np.flatnonzero((index < 0) | (index >= vertices))
    if wrong.size:
        number = int(np.searchsorted(np.cumsum(corners), wrong[0], side="right")) + 1
        raise InputError(
            f"face {number} names the vertex {int(index[wrong[0]]) + 1}, but there are {vertices:,}; is the file cut?"
        )
    return fans(index, corners), corners - 2


def fans(index: NDArray[np.int64], corners: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return polygons cut into triangles (m, 3), given the vertices of all and the number of corners of each."""
    first = np.repeat(np.append(0, np.cumsum(corners))[:-1], corners - 2)
    turn = np.arange(len(first)) - np.repeat(np.append(0, np.cumsum(corners - 2))[:-1], corners - 2)
    return index[np.stack([first, first + turn + 1, first + turn + 2], axis=1)]


def _is_number(text: bytes) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _shown(line: bytes) -> str:
    return repr(line.strip()[:40].decode("utf-8", "replace"))
