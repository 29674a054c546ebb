"""A motion's figures as a table of Arrow, and back: every cell is looked at before it is believed."""

from __future__ import annotations

import hashlib
from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.planning import extra_columns
from hognose.planning.columns import Column, Quantity, cells_of, columns_of, differing
from hognose.planning.motion import Motion
from hognose.robot import Robot


def all_cells(motion: Motion) -> dict[str, NDArray[Any]]:
    """The cells (T,) of all columns of a motion, in the file's order; those that Hognose does not know come last.

    A further column that has become known, because a quantity of its name was declared since, is taken as known.

    Raises
    ------
    InputError
        A figure is not what its quantity declares, a further column cannot be kept, or one that is known by now has
        other figures.
    """
    cells, robot = cells_of(motion), motion.robot
    extra_columns.refuse_other_figures(motion.extra, robot, cells)
    further = extra_columns.unknown(motion.extra, robot)
    return cells | extra_columns.kept(further, robot, len(motion.time))


def to_table(cells: dict[str, NDArray[Any]]) -> pa.Table:
    """The columns as a table."""
    return pa.table({name: _to_arrow(values) for name, values in cells.items()})


def _to_arrow(values: NDArray[Any]) -> pa.Array:
    """A column for Arrow. Its own conversion would import pandas, which takes half a second."""
    if values.dtype == object:
        return pa.array(values.tolist(), pa.string())
    kind = pa.int64() if values.dtype == np.int64 else pa.float64()
    return pa.Array.from_buffers(kind, len(values), [None, pa.py_buffer(np.ascontiguousarray(values))])


def digest_of(values: NDArray[Any]) -> str:
    """SHA-256 of a column's cells in hexadecimal digits.

    A number is 8 bytes, the lowest first; a text is its length in bytes, as such a number, and its bytes in UTF-8.
    """
    if values.dtype == object:
        found = hashlib.sha256()
        for text in values:
            raw = text.encode()
            found.update(len(raw).to_bytes(8, "little") + raw)
        return found.hexdigest()
    return hashlib.sha256(np.ascontiguousarray(values, values.dtype.newbyteorder("<")).tobytes()).hexdigest()


@dataclass(frozen=True)
class Figures:
    """What the columns of a table hold.

    Attributes
    ----------
    cells
        By the column's name, (T,).
    stored
        By attribute of `Motion`, what it is made of; without optional ones that the table lacks.
    derived
        What follows from that, as it was read.
    lacking
        Quantities that a file of today has, and one of that schema need not have.
    extra
        By name, what Hognose does not know.
    """

    cells: dict[str, NDArray[Any]]
    stored: dict[str, NDArray[Any]]
    derived: list[tuple[Quantity, NDArray[Any]]]
    lacking: list[Quantity]
    extra: dict[str, NDArray[Any]]

    def differing(self, motion: Motion) -> tuple[Column, int, float] | None:
        """The first derived figure that is not what it follows from; see `columns.differing`."""
        found = (differing(quantity, read, motion) for quantity, read in self.derived)
        return next((place for place in found if place is not None), None)


def from_table(table: pa.Table, robot: Robot, schema: int) -> Figures:
    """The figures of a plan of a robot, as files of a schema version hold them.

    Raises
    ------
    InputError
        A column is missing, there twice, of another type, has cells that no plan has, or is unknown and cannot be
        kept; says which.
    """
    columns = columns_of(robot)
    _refuse_twice(table.column_names)
    known = {column.name for column in columns}
    further = [name for name in table.column_names if name not in known]
    extra_columns.refuse_names(further, robot)
    cells: dict[str, NDArray[Any]] = {}
    stored: dict[str, NDArray[Any]] = {}
    derived: list[tuple[Quantity, NDArray[Any]]] = []
    lacking: list[Quantity] = []
    for quantity, own in _by_quantity(columns):
        if not _is_there(quantity, own, table, schema):
            lacking += [] if quantity.since is None else [quantity]
            continue
        values = np.empty((table.num_rows, *quantity.shape(robot)), quantity.type)
        for column in own:
            cells[column.name] = values[(slice(None), *column.place)] = _cells(table, column)
        if quantity.stored:
            stored[str(quantity.of)] = values
        else:
            derived.append((quantity, values))
    extra = {name: extra_columns.from_arrow(name, table.column(name)) for name in further}
    extra = extra_columns.kept(extra, robot, table.num_rows)
    return Figures(cells | extra, stored, derived, lacking, extra)


def _by_quantity(columns: tuple[Column, ...]) -> list[tuple[Quantity, list[Column]]]:
    found: dict[int, tuple[Quantity, list[Column]]] = {}
    for column in columns:
        found.setdefault(id(column.quantity), (column.quantity, []))[1].append(column)
    return list(found.values())


def _is_there(quantity: Quantity, columns: list[Column], table: pa.Table, schema: int) -> bool:
    """Whether a table has all columns of a quantity; False if it has none and may lack them."""
    given = set(table.column_names)
    missing = next((column.name for column in columns if column.name not in given), None)
    if missing is None:
        return True
    may_lack = quantity.since is None or quantity.since > schema
    if may_lack and not any(column.name in given for column in columns):
        return False
    raise InputError(f"column {missing!r} is missing, which every plan of this robot has")


def _refuse_twice(given: list[str]) -> None:
    for name, count in Counter(given).items():
        if count > 1:
            raise InputError(f"column {name!r} appears {count} times, expected once")


def _cells(table: pa.Table, column: Column) -> NDArray[Any]:
    name, cells, kind = column.name, table.column(column.name), pa.from_numpy_dtype(column.quantity.type)
    if cells.type != kind:
        raise InputError(f"column {name!r} holds {cells.type}, expected {kind}")
    if cells.null_count:
        raise InputError(f"column {name!r} has {cells.null_count} empty cells, expected none")
    values = cells.to_numpy()
    if not np.isfinite(values).all():
        raise InputError(f"column {name!r} has values that are not finite numbers")
    if not column.quantity.whole and np.abs(values).max(initial=0.0) > column.quantity.largest:
        most, unit = column.quantity.largest, column.quantity.unit
        raise InputError(
            f"column {name!r} holds {np.abs(values).max():g} {unit}, more than any plan can; at most {most:g} {unit}"
        )
    return values
