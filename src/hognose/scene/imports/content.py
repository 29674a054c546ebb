"""What a reader of one format is given, and what it gives back: the content of a file, before any repair."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: How many triangles or points a file may hold, counting what it places several times as often as that.
MOST_ELEMENTS = 20_000_000
#: How long what a file brings besides its own bytes may be: files beside it, its own parts unpacked (bytes).
LARGEST_PART = 2_000_000_000


@dataclass(frozen=True)
class ScanOptions:
    """What a task says of a scan.

    Attributes
    ----------
    columns
        Which columns hold x, y and z, by heading or by number from 1; None to find them.
    drop_invalid
        Whether points that are not finite, or all zero, are dropped.
    thin
        How far, in metres, points may lie from the one that stands for them; 0 to keep all.
    """

    columns: tuple[str | int, str | int, str | int] | None = None
    drop_invalid: bool = False
    thin: float = 0.0


@dataclass(frozen=True, eq=False)
class Source:
    """A file to read.

    Attributes
    ----------
    path
        Where it is, for the files beside it that it refers to; never read again.
    data
        All of its bytes, read once.
    tolerance
        How far triangles may lie off curved surfaces, m, where a reader makes them.
    scan
        What is asked of a scan.
    """

    path: Path
    data: bytes
    tolerance: float = 0.0
    scan: ScanOptions = ScanOptions()


#: A transformation whose determinant is this part of the product of its columns' sizes flattens what it places.
_FLAT = 1e-12


@dataclass(frozen=True, eq=False)
class RawBody:
    """One body: its name as in the file, or empty; vertices (v, 3) in the file's unit; faces (m, 3), 0-based."""

    name: str
    vertices: Floats
    faces: Ints


def body_at(name: str, vertices: Floats, faces: Ints, turn: Floats, shift: Floats) -> RawBody:
    """Return a body where a file places it, each vertex x at turn x + shift; a mirrored one stays right side out.

    Raises
    ------
    InputError
        It is placed without volume: `turn` (3, 3) makes a plane, a line or a point of everything.
    """
    sizes = np.linalg.norm(turn, axis=0)
    volume = np.linalg.det(turn)
    if np.isfinite(turn).all() and abs(volume) <= _FLAT * sizes.prod():
        raise InputError(
            f"the body {name!r} is placed by a transformation that flattens it (a scale of zero); export it as it is"
        )
    return RawBody(name, vertices @ turn.T + shift, faces[:, ::-1] if volume < 0 else faces)


@dataclass(frozen=True, eq=False)
class Content:
    """All that a file holds.

    Attributes
    ----------
    bodies
        With at least one triangle each.
    points : (p, 3)
        Points that belong to no triangle.
    metres
        Metres in the file's unit, or None if the file does not say.
    notes
        What the file holds that is not taken and cannot matter, or may, in sentences. What does matter is refused.
    """

    bodies: tuple[RawBody, ...] = ()
    points: Floats = field(default_factory=lambda: np.empty((0, 3)))
    metres: float | None = None
    notes: tuple[str, ...] = ()


#: So many names are told in one row.
MOST_LISTED = 6


def listed(names: Sequence[str], most: int = MOST_LISTED) -> str:
    """Return names in a row, the first ones if there are many: "a, b, c and 9 more"."""
    shown = ", ".join(names[:most])
    return f"{shown} and {len(names) - most:,} more" if len(names) > most else shown
