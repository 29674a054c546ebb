"""Reading LAS and LAZ, scans from the air and from the ground, with the package laspy."""

from __future__ import annotations

from hognose.errors import InputError
from hognose.scene.imports.content import Content, Source
from hognose.scene.imports.scan_packages import read_by

#: Bytes of a record before the points.
_SMALLEST = 54


def read(source: Source) -> Content:
    """Return all points of a LAS or LAZ file, of every class and flag; errors as of `read_by`."""
    if source.data[:4] != b"LASF":
        raise InputError("not a LAS file: it does not begin with `LASF`")
    records, begin = (int.from_bytes(source.data[k : k + 4], "little") for k in (100, 96))
    if len(source.data) < 227 or _SMALLEST * records > begin:
        raise InputError(
            f"cut or damaged: it says it has {records:,} records before its points, for which there is no room"
        )
    return read_by("laspy", "las", source)
