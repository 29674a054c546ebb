"""Reading E57, scans with the places of their scanners, with the package pye57."""

from __future__ import annotations

from hognose.errors import InputError
from hognose.scene.imports.content import Content, Source
from hognose.scene.imports.scan_packages import read_by


def read(source: Source) -> Content:
    """Return the points of all scans of an E57 file, in metres where their poses put them; errors as of `read_by`."""
    if source.data[:8] != b"ASTM-E57":
        raise InputError("not an E57 file: it does not begin with `ASTM-E57`")
    if (said := int.from_bytes(source.data[16:24], "little")) != len(source.data):
        raise InputError(f"cut or damaged: it says it is {said:,} bytes long, but it is {len(source.data):,}")
    return read_by("pye57", "e57", source, metres=1.0)
