"""Reading OFF: counts, vertices, and faces of any number of corners."""

from __future__ import annotations

import re

import numpy as np

from hognose.errors import InputError
from hognose.scene.imports.content import Content, RawBody, Source
from hognose.scene.imports.obj import fans


def read(source: Source) -> Content:
    """Return the content of an OFF file; normals and colours are left out.

    Raises
    ------
    InputError
        It is cut, or a line is not what it should be.
    """
    lines = [line for line in (raw.split(b"#")[0].strip() for raw in source.data.splitlines()) if line]
    head = re.match(rb"[A-Z]*OFF\b\s*(.*)", lines[0]) if lines else None
    if head is None:
        raise InputError("not an OFF file: it does not begin with `OFF`")
    if not head[1]:
        lines = lines[1:]
    try:
        vertices, faces = (int(number) for number in (head[1] or lines[0]).split()[:2])
    except (ValueError, IndexError):
        raise InputError("cut, or not an OFF file: it does not say how many vertices and faces it has") from None
    rows = lines[1:]
    if min(vertices, faces) < 0 or len(rows) < vertices + faces:
        raise InputError(
            f"cut: it says it has {vertices:,} vertices and {faces:,} faces, but there are {len(rows):,} lines"
        )
    try:
        places = np.array([row.split()[:3] for row in rows[:vertices]]).astype(np.float64).reshape(-1, 3)
        corners, index = [], []
        for row in rows[vertices : vertices + faces]:
            numbers = row.split()
            count = int(numbers[0])
            if count < 3 or len(numbers) <= count:
                raise ValueError
            corners.append(count)
            index += numbers[1 : count + 1]
        named = np.array(index).astype(np.int64) if index else np.empty(0, np.int64)
    except (ValueError, IndexError):
        raise InputError("damaged: a line is not three coordinates, or the number of corners and that many") from None
    if named.size and (named.min() < 0 or named.max() >= vertices):
        raise InputError(f"damaged: a face names the vertex {named.max()}, but there are {vertices:,}")
    if not faces:
        return Content(points=places)
    return Content((RawBody("", places, fans(named, np.array(corners, np.int64))),))
