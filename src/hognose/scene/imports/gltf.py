"""Reading glTF and GLB."""

from __future__ import annotations

from hognose.errors import InputError
from hognose.scene.imports.content import Content, Source
from hognose.scene.imports.third_party import read_by_trimesh

_COMPRESSIONS = (b"KHR_draco_mesh_compression", b"EXT_meshopt_compression")


def read(source: Source) -> Content:
    """Return the content of a glTF or GLB file."""
    for name in _COMPRESSIONS:
        if name in source.data[:200_000]:
            raise InputError(f"is compressed ({name.decode()}), which is not read; export it uncompressed")
    return read_by_trimesh(source, "glb" if source.data[:4] == b"glTF" else "gltf")
