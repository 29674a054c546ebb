"""What a reader of one format is given, and what it gives back: the content of a file, before any repair."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


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
    """

    path: Path
    data: bytes
    tolerance: float = 0.0


@dataclass(frozen=True, eq=False)
class RawBody:
    """One body: its name as in the file, or empty; vertices (v, 3) in the file's unit; faces (m, 3), 0-based."""

    name: str
    vertices: Floats
    faces: Ints


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
