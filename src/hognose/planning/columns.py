"""The columns of a plan file, each declared once: its name, and the cells of the plan that it holds."""

from __future__ import annotations

import hashlib
from collections import Counter
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.planning.motion import Motion
from hognose.planning.task import LONGEST_MOTION

#: Figures of a plan (s, m, rad) beyond this are damage; no motion takes longer, and no length comes near it.
LARGEST_VALUE = LONGEST_MOTION


@dataclass(frozen=True)
class Column:
    """One column.

    Attributes
    ----------
    name
        In the file.
    attribute, place
        The cells `attribute[:, *place]` of the plan.
    """

    name: str
    attribute: str
    place: tuple[int, ...] = ()

    @property
    def type(self) -> pa.DataType:
        """What its cells are."""
        return pa.int64() if self.attribute == "motor_counts" else pa.float64()

    def of(self, motion: Motion) -> NDArray[Any]:
        """Its cells (T,)."""
        return getattr(motion, self.attribute)[(slice(None), *self.place)]


@cache
def columns_of(sections: int, cables: int) -> tuple[Column, ...]:
    """All columns of the plan of an arm, in the file's order; `docs/plan-file.md` says what they are."""
    joints = [
        Column(f"joint_{j:02d}_{x}_m", "joints", (j, k)) for j in range(sections + 1) for k, x in enumerate("xyz")
    ]
    angles = [
        Column(f"{name}_{i + 1:02d}_rad", "angles", (i, axis))
        for axis, name in enumerate(("alpha", "beta"))
        for i in range(sections)
    ]
    return (
        Column("time_s", "time"),
        Column("feed_m", "feed"),
        *joints,
        *angles,
        *(Column(f"cable_{k + 1:02d}_m", "cable_lengths", (k,)) for k in range(cables)),
        *(Column(f"motor_{k + 1:02d}_counts", "motor_counts", (k,)) for k in range(cables)),
        *(Column(f"clearance_{i + 1:02d}_m", "clearance", (i,)) for i in range(sections)),
        *(Column(f"deviation_{i + 1:02d}_m", "body_deviation", (i,)) for i in range(sections)),
    )


def to_arrow(values: NDArray[Any], kind: pa.DataType) -> pa.Array:
    """A column for Arrow. Its own conversion would import pandas, which takes half a second."""
    return pa.Array.from_buffers(kind, len(values), [None, pa.py_buffer(np.ascontiguousarray(values))])


def from_table(table: pa.Table, columns: tuple[Column, ...]) -> dict[str, NDArray[Any]]:
    """The arrays of a plan by attribute, from a table that holds these columns and no others.

    Raises
    ------
    InputError
        A column is missing, unknown, there twice, of another type, or has cells that no plan has; says which.
    """
    _refuse_other_columns(table.column_names, columns)
    shapes: dict[str, tuple[int, ...]] = {}
    for column in columns:
        before = shapes.get(column.attribute, (0,) * len(column.place))
        shapes[column.attribute] = tuple(max(size, k + 1) for size, k in zip(before, column.place, strict=True))
    kinds = {column.attribute: column.type.to_pandas_dtype() for column in columns}
    arrays = {name: np.empty((table.num_rows, *shape), kinds[name]) for name, shape in shapes.items()}
    for column in columns:
        arrays[column.attribute][(slice(None), *column.place)] = _cells(table, column)
    return arrays


def digest_of(values: NDArray[Any]) -> str:
    """SHA-256 of a column's cells, 8 bytes each with the lowest first, in hexadecimal digits."""
    return hashlib.sha256(np.ascontiguousarray(values, values.dtype.newbyteorder("<")).tobytes()).hexdigest()


def _refuse_other_columns(given: list[str], columns: tuple[Column, ...]) -> None:
    counts, wanted = Counter(given), {column.name for column in columns}
    for name in given:
        if name not in wanted:
            raise InputError(f"column {name!r} is unknown; a plan of this robot has none of that name")
        if counts[name] > 1:
            raise InputError(f"column {name!r} is there {counts[name]} times")
    for column in columns:
        if column.name not in counts:
            raise InputError(f"column {column.name!r} is missing; the plan's robot needs it")


def _cells(table: pa.Table, column: Column) -> NDArray[Any]:
    name, cells = column.name, table.column(column.name)
    if cells.type != column.type:
        raise InputError(f"column {name!r} holds {cells.type}, expected {column.type}")
    if cells.null_count:
        raise InputError(f"column {name!r} has {cells.null_count} empty cells")
    values = cells.to_numpy()
    if not np.isfinite(values).all():
        raise InputError(f"column {name!r} has values that are not finite")
    if column.type == pa.float64() and np.abs(values).max(initial=0.0) > LARGEST_VALUE:
        raise InputError(f"column {name!r} holds {np.abs(values).max():g}, more than any plan can")
    return values
