"""The box of `import_makers` in every layout of the text formats, and how what was read is compared with it."""

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from import_makers import box

from hognose.errors import InputError
from hognose.scene.imports.content import Content, ScanOptions, Source
from hognose.scene.imports.formats import BY_SUFFIX

BOX = box()
VERTICES, FACES = np.asarray(BOX.vertices, float), np.asarray(BOX.faces)
#: The box as six polygons of four corners, wound as its triangles are.
QUADS = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
POINTS = [" ".join(f"{x:.9g}" for x in point) for point in VERTICES]


def read(ending: str, data: bytes | str, **scan) -> Content:
    """What the reader of an ending makes of a file."""
    data = data if isinstance(data, bytes) else data.encode()
    return BY_SUFFIX["." + ending].read(Source(Path("file." + ending), data, scan=ScanOptions(**scan)))


def refusal(ending: str, data: bytes | str, **scan) -> str:
    """Why a file is refused."""
    with pytest.raises(InputError) as caught:
        read(ending, data, **scan)
    return str(caught.value)


def canonical(corners) -> np.ndarray:
    """Triangles (m, 3, 3) in an order that does not depend on where each begins: equal for equal surfaces."""
    corners = np.round(np.asarray(corners, float), 4) + 0.0
    turns = np.stack([np.roll(corners, -k, axis=1).reshape(-1, 9) for k in range(3)], axis=1)
    first = [min(map(tuple, each)) for each in turns.tolist()]
    return np.array(sorted(first))


def surface(content: Content) -> np.ndarray:
    """All triangles (m, 3, 3) of a file."""
    return np.concatenate([body.vertices[body.faces] for body in content.bodies])


def as_trimesh_has_it(ending: str, data: bytes) -> np.ndarray:
    """The triangles (m, 3, 3) of a file as trimesh reads them."""
    mesh: Any = trimesh.load(io.BytesIO(data), file_type=ending, process=False)
    return mesh.vertices[mesh.faces]


def assert_box(content: Content, quads: bool = False) -> None:
    """The content is the box and nothing else, triangle for triangle; of quads, whose diagonals are free, by volume."""
    if quads:
        corners = surface(content) - VERTICES.mean(axis=0)
        assert len(corners) == 12
        assert np.linalg.det(corners).sum() / 6 == pytest.approx(BOX.volume)
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2
        assert area == pytest.approx(BOX.area)
    else:
        np.testing.assert_array_equal(canonical(surface(content)), canonical(VERTICES[FACES]))
    assert len(content.points) == 0
