"""Reading meshes and point clouds from files: whole or not at all, repaired only where that is safe."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError, MissingExtraError
from hognose.read_whole import read_whole
from hognose.scene import disk_cache
from hognose.scene.imports.content import MOST_ELEMENTS, Content, ScanOptions, Source
from hognose.scene.imports.formats import BY_SUFFIX, MESH_SUFFIXES, POINT_SUFFIXES, STEP_SUFFIXES
from hognose.scene.imports.geometry import Body, Geometry
from hognose.scene.imports.integrity import refuse_cut
from hognose.scene.imports.other_formats import foreign
from hognose.scene.imports.repair import merged_vertices, repaired
from hognose.scene.imports.scan import thinned, without_invalid
from hognose.version import __version__

#: Larger files are refused (bytes).
LARGEST_FILE = 1_000_000_000
#: Smaller files are read anew each time.
_WORTH_KEEPING = 1_000_000
_PLAIN = ScanOptions()


def read_mesh(path: Path, tolerance: float) -> Geometry:
    """Return the bodies of a mesh file or a STEP file.

    Parameters
    ----------
    path
        Its suffix says the format.
    tolerance
        How far triangles may lie off the surfaces of a STEP file, m.

    Raises
    ------
    InputError
        The file is missing, of an unknown format, cut, garbage, empty, or has coordinates that are not finite.
    MissingExtraError
        A STEP file, without the extra `step`.
    """
    suffix = _suffix(path, MESH_SUFFIXES, "a mesh:")
    data = _content(path)
    try:
        refuse_cut(data, suffix)
        kind = f"mesh {suffix} {tolerance if suffix in STEP_SUFFIXES else 0}"
        with np.errstate(invalid="ignore"):  # what is not finite is refused in words, not warned of
            return _kept(kind, data, suffix, lambda: _mesh(Source(path, data, tolerance), suffix))
    except MissingExtraError as error:
        raise MissingExtraError(f"{path}: {error}") from None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def read_points(path: Path, scan: ScanOptions = _PLAIN, metres: float | None = None) -> Geometry:
    """Return the points of a point cloud; errors as of `read_mesh`.

    Parameters
    ----------
    path
        Its suffix says the format.
    scan
        What is asked of it.
    metres
        Metres in the unit of its numbers, with which `scan.thin` is to be compared; None for what the file says.
    """
    suffix = _suffix(path, POINT_SUFFIXES, "a point cloud:")
    data = _content(path)
    try:
        refuse_cut(data, suffix)
        with np.errstate(invalid="ignore"):  # what is not finite is refused in words, not warned of
            kind = f"points {suffix} {scan} {metres if scan.thin else None}"
            return _kept(kind, data, suffix, lambda: _points(Source(path, data, scan=scan), suffix, metres))
    except MissingExtraError as error:
        raise MissingExtraError(f"{path}: {error}") from None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _suffix(path: Path, known: tuple[str, ...], what: str) -> str:
    suffix = path.suffix.lower()
    with suppress(OSError):  # a name that no file can have is said when it is read
        if path.is_dir():
            raise InputError(f"{path}: is a folder, expected a file ({', '.join(known)})")
    if suffix not in known:
        raise InputError(f"{path}: {foreign(path.suffix)} Expected {what} {', '.join(known)}.")
    return suffix


def _content(path: Path) -> bytes:
    data = read_whole(path, LARGEST_FILE, too_large="make it coarser")
    if not data.strip(b"\0 \r\n\t"):
        raise InputError(f"{path}: the file is empty; export it again")
    return data


def _mesh(source: Source, suffix: str) -> Geometry:
    content = BY_SUFFIX[suffix].read(source)
    if not content.bodies:
        if len(content.points):
            raise InputError(
                f"holds {len(content.points):,} points but no triangles: as a point cloud it is an obstacle of "
                'kind = "points"'
            )
        raise InputError("holds no triangles; is it another format, or was nothing selected when it was exported?")
    if sum(len(body.faces) for body in content.bodies) > MOST_ELEMENTS:
        raise InputError(f"holds more than {MOST_ELEMENTS:,} triangles; make it coarser")
    return _assembled(content)


def _assembled(content: Content) -> Geometry:
    vertices, faces, bodies = [], [], []
    first, offset = 0, 0
    for name, body in zip(_names([body.name for body in content.bodies]), content.bodies, strict=True):
        _refuse_infinite(body.vertices[body.faces.reshape(-1)], f"body {name!r}: " if name else "")
        made = repaired(body.vertices, body.faces)
        last = first + len(made.faces)
        called = _clean(body.name)
        told = Body(name, first, last, made.open_edges, made.twisted_edges, made.volume, made.repairs)
        bodies.append(told if called == name else replace(told, called=called))
        vertices.append(made.vertices)
        faces.append(made.faces + np.int32(offset))
        first, offset = last, offset + len(made.vertices)
    loose = len(content.points)
    notes = (f"{loose:,} points that belong to no triangle left out",) if loose else ()
    return Geometry(
        np.concatenate(vertices), np.concatenate(faces), tuple(bodies), content.metres, (*content.notes, *notes)
    )


def _names(given: list[str]) -> list[str]:
    """Names that differ; a single body without one needs none."""
    if len(given) == 1:
        return [_clean(given[0])]
    seen: Counter[str] = Counter()
    names: dict[str, None] = {}
    for number, raw in enumerate(given, 1):
        stem = _clean(raw) or "body"
        name = stem if _clean(raw) else f"body {number}"
        while name in names:
            seen[stem] += 1
            name = f"{stem} {seen[stem] + 1}"
        names[name] = None
    return list(names)


def _clean(name: str) -> str:
    return " ".join("".join(c if c.isprintable() else " " for c in name).split())[:60]


def _refuse_infinite(coordinates: NDArray[np.float64], where: str = "") -> None:
    wrong = int((~np.isfinite(coordinates)).any(axis=1).sum())
    if wrong:
        raise InputError(
            f"{where}{wrong:,} of {len(coordinates):,} corners or points have coordinates that are not finite numbers "
            "(NaN or infinity); remove them, or export it again"
        )


def _points(source: Source, suffix: str, metres: float | None) -> Geometry:
    content, scan = BY_SUFFIX[suffix].read(source), source.scan
    if content.bodies:
        raise InputError('holds triangles, not only points: it is an obstacle of kind = "mesh"')
    if not len(content.points):
        raise InputError("holds no points")
    points, dropped = without_invalid(content.points, scan.drop_invalid)
    notes = [*content.notes, *dropped]
    places, _, twice = merged_vertices(points, np.arange(len(points), dtype=np.int64).repeat(3).reshape(-1, 3))
    if twice:
        notes.append(f"{twice:,} points that were there twice dropped")
    if scan.thin:
        before, places = len(places), thinned(places, scan.thin / (metres or content.metres or 1.0))
        notes.append(f"thinned from {before:,} to {len(places):,} points")
    if len(places) > MOST_ELEMENTS:
        raise InputError(f"holds {len(places):,} points, more than {MOST_ELEMENTS:,}; make them fewer with `thin`")
    return Geometry(places, np.empty((0, 3), np.int32), (), content.metres, tuple(notes))


def _kept(kind: str, data: bytes, suffix: str, make) -> Geometry:
    """What `make` returns, from disk if it was made of the same content before."""
    if (len(data) < _WORTH_KEEPING and suffix not in STEP_SUFFIXES) or suffix == ".gltf":  # which has other files
        return make()
    key = hashlib.sha256(f"{kind} {disk_cache.LAYOUT} {__version__}".encode() + data).hexdigest()
    held = disk_cache.recall(key)
    if held is not None:
        said = json.loads(held["said"].tobytes())
        bodies = tuple(Body(**{**body, "repairs": tuple(body["repairs"])}) for body in said["bodies"])
        return Geometry(held["vertices"], held["faces"], bodies, said["metres"], tuple(said["notes"]))
    made = make()
    said = {"bodies": [asdict(body) for body in made.bodies], "metres": made.metres, "notes": made.notes}
    text = np.frombuffer(json.dumps(said).encode(), np.uint8)
    disk_cache.remember(key, {"vertices": made.vertices, "faces": made.faces, "said": text})
    return made
