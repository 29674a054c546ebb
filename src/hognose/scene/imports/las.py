"""Reading LAS and LAZ, scans from the air and from the ground, with the package laspy."""

from __future__ import annotations

from hognose.errors import InputError
from hognose.scene.imports.content import Content, Source
from hognose.scene.imports.scan_packages import read_by


def read(source: Source) -> Content:
    """Return all points of a LAS or LAZ file, of every class and flag; errors as of `read_by`."""
    if source.data[:4] != b"LASF":
        raise InputError("not a LAS file: it does not begin with `LASF`")
    return read_by("laspy", "las", source)
