"""Reading PLY."""

from __future__ import annotations

from hognose.scene.imports.content import Content, Source
from hognose.scene.imports.third_party import read_by_trimesh


def read(source: Source) -> Content:
    """Return the content of a PLY file."""
    return read_by_trimesh(source, "ply")
