"""Reading E57, scans with the places of their scanners, with the package pye57."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError, MissingExtraError
from hognose.scene.imports.content import Content, Source

Floats = NDArray[np.float64]

#: More are not unpacked.
_MOST = 100_000_000
_CARTESIAN = ("cartesianX", "cartesianY", "cartesianZ", "cartesianInvalidState")
_SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation", "sphericalInvalidState")


def read(source: Source) -> Content:
    """Return the points of all scans of an E57 file, in metres where their poses put them; NaN where marked invalid.

    Raises
    ------
    MissingExtraError
        Without the extra `e57`.
    InputError
        It is cut or damaged, or a scan has no coordinates.
    """
    try:
        import pye57
    except ImportError:
        raise MissingExtraError(
            "E57 files need the package pye57; install it with: pip install 'hognose[e57]' (or export the scan as PLY, "
            "PCD or XYZ, which need nothing more)"
        ) from None
    if source.scan.columns:
        raise InputError("an E57 file says which of its columns are x, y and z; leave `columns` out")
    if source.data[:8] != b"ASTM-E57":
        raise InputError("not an E57 file: it does not begin with `ASTM-E57`")
    if (said := int.from_bytes(source.data[16:24], "little")) != len(source.data):
        raise InputError(f"cut or damaged: it says it is {said:,} bytes long, but it is {len(source.data):,}")
    with tempfile.TemporaryDirectory() as folder:  # the library reads from a file only
        file = Path(folder) / "scan.e57"
        file.write_bytes(source.data)
        try:
            found = pye57.E57(str(file))
            try:
                points = [_scan(found, number) for number in range(found.scan_count)]
            finally:
                found.close()
        except InputError:
            raise
        except Exception as error:  # whatever the library trips over in a damaged file
            words = str(error).strip().splitlines() or [type(error).__name__]
            raise InputError(f"cut or damaged, or not an E57 file: {words[0][:200]}") from None
    return Content(points=np.concatenate(points) if points else np.empty((0, 3)), metres=1.0)


def _scan(found: Any, number: int) -> Floats:
    """The points (p, 3) of one scan, m."""
    header = found.get_header(number)
    if header.point_count > _MOST:
        raise InputError(
            f"says it has {header.point_count:,} points in a scan, at most {_MOST:,} are read; thin it out"
        )
    fields = set(header.point_fields)
    kind = next((kind for kind in (_CARTESIAN, _SPHERICAL) if fields.issuperset(kind[:3])), None)
    if kind is None:
        raise InputError(f"scan {number + 1} has no coordinates; its fields are {', '.join(sorted(fields)) or 'none'}")
    x, y, z, invalid = kind
    data = _columns(found, header, [name for name in (x, y, z, invalid) if name in fields])
    a, b, c = (np.asarray(data[name], np.float64) for name in (x, y, z))
    if x == _SPHERICAL[0]:
        a, b, c = a * np.cos(c) * np.cos(b), a * np.cos(c) * np.sin(b), a * np.sin(c)
    points = np.stack([a, b, c], axis=1)
    if invalid in fields:
        points[np.asarray(data[invalid]) != 0] = np.nan
    elif header.has_pose():
        points[~points.any(axis=1)] = np.nan  # the pose would take 0 0 0, for no return, to the scanner
    if header.has_pose():
        points = points @ np.asarray(header.rotation_matrix, np.float64).T + np.asarray(header.translation, np.float64)
    return points


def _columns(found: Any, header: Any, names: list[str]) -> dict[str, NDArray[Any]]:
    """Some of the fields of all points of a scan."""
    from pye57 import libe57  # pyright: ignore[reportAttributeAccessIssue] # compiled, without types

    data, buffers = {}, libe57.VectorSourceDestBuffer()
    for name in names:
        data[name], buffer = found.make_buffer(name, header.point_count)
        buffers.append(buffer)
    there = header.points.reader(buffers).read()
    if there != header.point_count:
        raise InputError(f"cut: a scan says it has {header.point_count:,} points, but has {there:,}")
    return data
