"""Run as a process of its own: a LAS, LAZ or E57 file becomes an array of points.

The packages that read these are compiled, and some damaged files end the process; here that ends nothing else. Only the
standard library, NumPy and the package are imported. Arguments: `las` or `e57`, the folder that the package is in, the
file. On the standard output: a line of JSON, {"points": how many, "notes": sentences}, and x y z of each (float64).
"""

from __future__ import annotations

import json
import os
import sys
from contextlib import suppress
from typing import Any

#: Exit code of a file that cannot be taken; the standard error says why.
REFUSED = 3
#: More are not unpacked.
_MOST = 100_000_000
#: Points in a byte of a LAZ file; more cannot be.
_MOST_PACKED = 100
_CARTESIAN = ("cartesianX", "cartesianY", "cartesianZ", "cartesianInvalidState")
_SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation", "sphericalInvalidState")


class RefusedError(Exception):
    """The file cannot be taken; says why."""


def main() -> int:
    """Read; return the exit code."""
    kind, folder, file = sys.argv[1:]
    _bound()
    answer = os.dup(1)
    os.dup2(2, 1)  # whatever else the package writes
    sys.path.append(folder)
    try:
        points, notes = {"las": _las, "e57": _e57}[kind](file)
    except RefusedError as error:
        return _refuse(str(error))
    except BaseException as error:  # whatever the package trips over in a damaged file, panics too
        said = str(error).strip().splitlines() or [type(error).__name__]
        return _refuse(f"cut or damaged: {said[0][:200]}")
    with os.fdopen(answer, "wb") as stream:
        stream.write(json.dumps({"points": len(points), "notes": notes}).encode() + b"\n")
        stream.write(points.astype("<f8").tobytes())
    return 0


def _refuse(words: str) -> int:
    with suppress(OSError):
        os.write(2, b"\n" + words.encode())
    return REFUSED


def _bound() -> None:
    """Take no more memory than there is, and leave no dump behind."""
    with suppress(ImportError, OSError, ValueError):
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        there = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
        hardest = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (there if hardest < 0 else min(there, hardest), hardest))


def _refuse_many(count: int) -> None:
    if count > _MOST:
        raise RefusedError(f"says it has {count:,} points, at most {_MOST:,} are read; thin it out")


def _las(file: str) -> tuple[Any, list[str]]:
    import laspy
    import numpy as np

    with laspy.open(file) as reader:
        header = reader.header
        count = header.point_count
        _refuse_many(count)
        if count > _MOST_PACKED * os.path.getsize(file):
            raise RefusedError(f"damaged: its header says {count:,} points, which is more than can be packed in it")
        if not header.are_points_compressed:
            there = _held(header, os.path.getsize(file))
            if there != count:
                wrong = "cut" if there < count else "damaged"
                raise RefusedError(f"{wrong}: its header says {count:,} points, but there are {there:,}")
        points = np.asarray(reader.read().xyz, np.float64).reshape(-1, 3)
    if len(points) != count:
        raise RefusedError(f"cut: its header says {count:,} points, but there are {len(points):,}")
    if (returned := int(np.sum(header.number_of_points_by_return))) > count:
        raise RefusedError(f"damaged: its header says {count:,} points, but {returned:,} returns")
    if not count:
        return points, []
    box, there = np.array([header.mins, header.maxs]), np.array([points.min(axis=0), points.max(axis=0)])
    off = ~(np.abs(there - box) <= 2 * np.abs(np.asarray(header.scales)) + 1e-9 * np.abs(box))
    return points, ["its header says that its points reach elsewhere than they do; is it whole?"] if off.any() else []


def _held(header: Any, size: int) -> int:
    """How many points an unpacked file of a size has room for, before what may follow them."""
    begin, end = header.offset_to_point_data, size
    for key in ("start_of_first_evlr", "start_of_waveform_data_packet_record"):
        other = getattr(header, key, 0) or 0
        end = other if begin < other < end else end
    return (end - begin) // header.point_format.size


def _e57(file: str) -> tuple[Any, list[str]]:
    import numpy as np
    import pye57

    found = pye57.E57(file)
    points = [_scan(found, number) for number in range(found.scan_count)]
    return (np.concatenate(points) if points else np.empty((0, 3))), []


def _scan(found: Any, number: int) -> Any:
    """The points (p, 3) of one scan, m, where its pose puts them; NaN where they are marked invalid."""
    import numpy as np

    header = found.get_header(number)
    _refuse_many(header.point_count)
    fields = set(header.point_fields)
    kind = next((kind for kind in (_CARTESIAN, _SPHERICAL) if fields.issuperset(kind[:3])), None)
    if kind is None:
        raise RefusedError(
            f"scan {number + 1} has no coordinates; its fields are {', '.join(sorted(fields)) or 'none'}"
        )
    data = _columns(found, header, [name for name in kind if name in fields])
    a, b, c = (np.asarray(data[name], np.float64) for name in kind[:3])
    if kind is _SPHERICAL:
        a, b, c = a * np.cos(c) * np.cos(b), a * np.cos(c) * np.sin(b), a * np.sin(c)
    points = np.stack([a, b, c], axis=1)
    if kind[3] in fields:
        points[np.asarray(data[kind[3]]) != 0] = np.nan
    elif header.has_pose():
        points[~points.any(axis=1)] = np.nan  # the pose would take 0 0 0, for no return, to the scanner
    if header.has_pose():
        points = points @ np.asarray(header.rotation_matrix, np.float64).T + np.asarray(header.translation, np.float64)
    return points


def _columns(found: Any, header: Any, names: list[str]) -> dict[str, Any]:
    """Some of the fields of all points of a scan."""
    from pye57 import libe57  # pyright: ignore[reportAttributeAccessIssue] # compiled, without types

    data, buffers = {}, libe57.VectorSourceDestBuffer()
    for name in names:
        data[name], buffer = found.make_buffer(name, header.point_count)
        buffers.append(buffer)
    there = header.points.reader(buffers).read()
    if there != header.point_count:
        raise RefusedError(f"cut: a scan says it has {header.point_count:,} points, but has {there:,}")
    return data


if __name__ == "__main__":
    sys.exit(main())
