"""Reading LAS and LAZ, scans from the air and from the ground, with the package laspy."""

from __future__ import annotations

import io

import numpy as np

from hognose.errors import InputError, MissingExtraError
from hognose.scene.imports.content import Content, Source

#: More are not unpacked.
_MOST = 100_000_000


def read(source: Source) -> Content:
    """Return all points of a LAS or LAZ file, of every class and flag.

    Raises
    ------
    MissingExtraError
        Without the extra `las`.
    InputError
        It is cut or damaged, or holds more points than it says.
    """
    try:
        import laspy
    except ImportError:
        raise MissingExtraError(
            "LAS and LAZ files need the package laspy; install it with: pip install 'hognose[las]' (or export the scan "
            "as PLY, PCD or XYZ, which need nothing more)"
        ) from None
    if source.scan.columns:
        raise InputError("a LAS file has its columns in a fixed order; leave `columns` out")
    if source.data[:4] != b"LASF":
        raise InputError("not a LAS file: it does not begin with `LASF`")
    try:
        with laspy.open(io.BytesIO(source.data)) as reader:
            header = reader.header
            count = header.point_count
            if count > _MOST:
                raise InputError(f"says it has {count:,} points, at most {_MOST:,} are read; thin it out")
            if not header.are_points_compressed:
                _refuse_more(source.data, header)
            points = np.asarray(reader.read().xyz, np.float64)
    except InputError:
        raise
    except BaseException as error:  # of laspy, and panics of its unpacker
        if isinstance(error, KeyboardInterrupt | SystemExit):
            raise
        said = str(error).strip().splitlines() or [type(error).__name__]
        raise InputError(f"cut or damaged, or not a LAS file: {said[0][:200]}") from None
    if len(points) != count:
        raise InputError(f"cut: its header says {count:,} points, but there are {len(points):,}")
    box = np.array([header.mins, header.maxs], np.float64)
    there = np.array([points.min(axis=0), points.max(axis=0)]) if count else box
    off = np.abs(there - box) > np.abs(np.asarray(header.scales)) + 1e-9 * np.abs(box)
    notes = ("its header says that its points reach elsewhere than they do; is it whole?",) if off.any() else ()
    return Content(points=points, notes=notes)


def _refuse_more(data: bytes, header) -> None:
    """Raise an InputError if points follow those that the header counts, or are missing."""
    size = header.point_format.size
    begin, end = header.offset_to_point_data, len(data)
    for other in (
        getattr(header, "start_of_first_evlr", 0),
        getattr(header, "start_of_waveform_data_packet_record", 0),
    ):
        end = other if begin < (other or 0) < end else end
    there = (end - begin) // size
    if there != header.point_count:
        wrong = "cut" if there < header.point_count else "damaged"
        raise InputError(f"{wrong}: its header says {header.point_count:,} points, but there are {there:,}")
