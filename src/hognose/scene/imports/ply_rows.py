"""The rows of a PLY file, text or binary, element after element."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.scene.imports.numeric_text import plain, rows, whole
from hognose.scene.imports.ply_header import Element, Header
from hognose.scene.imports.polygons import gathered

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Columns:
    """Some of the columns of an element.

    Attributes
    ----------
    single
        The numbers (rows,) of each property asked for that is no list, by its place.
    lists
        The items of each list asked for, one row after the other, and how many each row has.
    """

    single: dict[int, Floats]
    lists: dict[int, tuple[Floats, Ints]]


def read_rows(data: bytes, head: Header, wanted: Callable[[Element], list[int]]) -> list[Columns]:
    """Return, for each element of a file, the columns of the properties that `wanted` names by their places.

    Raises
    ------
    InputError
        The file ends before all rows, or goes on behind them; a row is not what its header says.
    """
    take = _text if not head.order else _binary
    return take(data, head, [wanted(element) for element in head.elements])


def _text(data: bytes, head: Header, wanted: list[list[int]]) -> list[Columns]:
    table = rows(plain(data[head.begin :]), head.lines + 1)
    said, there = sum(element.rows for element in head.elements if element.properties), len(table.ends)
    if there != said:
        raise InputError(
            f"{'cut' if there < said else 'damaged'}: its header says {said:,} rows (vertices, faces and others), but "
            f"there are {there:,}"
        )
    found, first = [], 0
    for element, places in zip(head.elements, wanted, strict=True):
        last = first + (element.rows if element.properties else 0)
        at, end = table.begins[first:last].copy(), table.ends[first:last]
        columns = Columns({}, {})
        for k, column in enumerate(element.properties):
            _refuse_short(element, table.lines[first:last], at < end)
            value = table.numbers[np.minimum(at, len(table.numbers) - 1)] if len(at) else np.empty(0)
            at += 1
            if column.count:
                counts = whole(value)
                if counts is None or (counts < 0).any():
                    raise InputError(
                        f"damaged: a list `{column.name}` of `{element.name}` has no whole number of items"
                    )
                _refuse_short(element, table.lines[first:last], counts <= end - at)
                if k in places:
                    columns.lists[k] = table.numbers[gathered(at, counts)], counts
                at += counts
            elif k in places:
                columns.single[k] = value
        _refuse_short(element, table.lines[first:last], at == end)
        found.append(columns)
        first = last
    return found


def _refuse_short(element: Element, lines: Ints, good: NDArray[np.bool_]) -> None:
    if not good.all():
        line = lines[int(np.argmin(good))]
        raise InputError(f"damaged: line {line} has more or fewer numbers than its header says of `{element.name}`")


def _binary(data: bytes, head: Header, wanted: list[list[int]]) -> list[Columns]:
    found, at = [], head.begin
    for element, places in zip(head.elements, wanted, strict=True):
        columns, at = _element(data, at, element, places, head.order)
        found.append(columns)
    left = data[at:]
    if left.strip(b"\r\n") or len(left) > 2:
        raise InputError(f"damaged: it goes on for {len(left):,} bytes after all that its header names")
    return found


def _element(data: bytes, at: int, element: Element, places: list[int], order: str) -> tuple[Columns, int]:
    columns = Columns({}, {})
    if not element.rows or not element.properties:
        return Columns(*_empty(element, places)), at
    if not any(each.count for each in element.properties):
        table = _table(data, at, element, _row(element, order, {}))
        for k in places:
            columns.single[k] = table[f"p{k}"].astype(np.float64)
        return columns, at + table.nbytes
    regular = _regular(data, at, element, order)
    if regular is not None:
        for k in places:
            values = regular[f"p{k}"].astype(np.float64)
            if element.properties[k].count:
                columns.lists[k] = values.reshape(-1), np.full(element.rows, values[0].size, np.int64)
            else:
                columns.single[k] = values
        return columns, at + regular.nbytes
    return _walk(data, at, element, places, order)


def _empty(element: Element, places: list[int]) -> tuple[dict[int, Floats], dict[int, tuple[Floats, Ints]]]:
    none, no = np.empty(0), np.empty(0, np.int64)
    lists = [k for k in places if element.properties[k].count]
    return {k: none for k in places if k not in lists}, dict.fromkeys(lists, (none, no))


def _row(element: Element, order: str, counts: dict[int, int]) -> np.dtype:
    """A row whose lists have these numbers of items, by the place of the property."""
    fields: list[tuple] = []
    for k, each in enumerate(element.properties):
        if each.count:
            fields += [(f"n{k}", order + each.count), (f"p{k}", order + each.type, (counts[k],))]
        else:
            fields.append((f"p{k}", order + each.type))
    return np.dtype(fields)


def _table(data: bytes, at: int, element: Element, row: np.dtype) -> NDArray:
    there = (len(data) - at) // row.itemsize
    if there < element.rows:
        raise _cut(element, there)
    return np.frombuffer(data, row, element.rows, at)


def _cut(element: Element, there: int) -> InputError:
    return InputError(f"cut: its header says {element.rows:,} rows of `{element.name}`, but it ends after {there:,}")


def _regular(data: bytes, at: int, element: Element, order: str) -> NDArray | None:
    """All rows at once, if each list has as many items in every row as in the first one; otherwise None."""
    counts, place = {}, at
    for k, each in enumerate(element.properties):
        size = int(each.type[1])
        if each.count:
            width = int(each.count[1])
            number = np.frombuffer(data[place : place + width].ljust(width, b"\0"), order + each.count)[0]
            if not 0 <= number <= (len(data) - place) // size or number != int(number):
                return None
            counts[k] = int(number)
            place += width + counts[k] * size
        else:
            place += size
    row = _row(element, order, counts)
    if (len(data) - at) // row.itemsize < element.rows:
        return None  # said by whoever goes through row after row
    table = np.frombuffer(data, row, element.rows, at)
    return table if all((table[f"n{k}"] == number).all() for k, number in counts.items()) else None


def _walk(data: bytes, at: int, element: Element, places: list[int], order: str) -> tuple[Columns, int]:
    """Rows whose lists differ in length: each tells where the next one begins."""
    steps = [
        (k, struct.Struct((order or "=") + _LETTERS[each.count]).unpack_from if each.count else None, int(each.type[1]),
         int(each.count[1]) if each.count else 0, k in places)
        for k, each in enumerate(element.properties)
    ]  # fmt: skip
    begins: dict[int, list[int]] = {k: [] for k in places}
    counts: dict[int, list[int]] = {k: [] for k in places if element.properties[k].count}
    for number in range(element.rows):
        try:
            for k, unpack, size, width, kept in steps:
                if unpack is None:
                    if kept:
                        begins[k].append(at)
                    at += size
                    continue
                (count,) = unpack(data, at)
                if count < 0 or count != int(count):
                    raise InputError(f"damaged: row {number + 1:,} of `{element.name}` has a list of {count} items")
                at += width
                if kept:
                    begins[k].append(at)
                    counts[k].append(int(count))
                at += int(count) * size
        except (struct.error, ValueError, OverflowError) as error:
            if isinstance(error, InputError):
                raise
            raise _cut(element, number) from None
        if at > len(data):
            raise _cut(element, number)
    columns = Columns({}, {})
    raw = np.frombuffer(data, np.uint8)
    for k in places:
        kind = np.dtype(order + element.properties[k].type)
        starts = np.array(begins[k], np.int64)
        if k not in counts:
            columns.single[k] = (
                raw[starts[:, None] + np.arange(kind.itemsize)].reshape(-1).view(kind).astype(np.float64)
            )
            continue
        many = np.array(counts[k], np.int64)
        items = raw[gathered(starts, many * kind.itemsize)].view(kind).astype(np.float64)
        columns.lists[k] = items, many
    return columns, at


_LETTERS = {
    "i1": "b",
    "u1": "B",
    "i2": "h",
    "u2": "H",
    "i4": "i",
    "u4": "I",
    "i8": "q",
    "u8": "Q",
    "f4": "f",
    "f8": "d",
}
