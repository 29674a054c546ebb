"""Columns of a plan file that Hognose does not know: another program's notes to the steps, kept as they are."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from hognose.errors import InputError
from hognose.plain_text import is_plain
from hognose.planning.columns import LABELS, Column, columns_of, quantities
from hognose.robot import Robot

#: A plan keeps so many of them, and so many letters of a name and of a cell.
MOST_EXTRA, LONGEST_NAME, LONGEST_TEXT = 256, 80, 1000
#: So many are named in a message.
_NAMED = 5
_EXPECTED = "expected 64-bit whole numbers, numbers in double precision, or text"


def kept(extra: Mapping[str, Any], robot: Robot, rows: int) -> dict[str, NDArray[Any]]:
    """The columns, if a plan file can hold them.

    Parameters
    ----------
    extra
        By name the cells (T,), or what NumPy makes such an array of: int64, float64, or text.
    robot
        Of the plan.
    rows
        Number of steps T.

    Raises
    ------
    InputError
        Too many; a name that is too long, not plain, or that looks like that of a known column; cells that are of
        another number or type, not finite, or too long.
    """
    if len(extra) > MOST_EXTRA:
        raise InputError(f"{len(extra)} columns that Hognose does not know; it keeps {MOST_EXTRA} at most")
    refuse_names(list(extra), robot)
    return {name: _checked(name, cells, rows) for name, cells in extra.items()}


def unknown(extra: Mapping[str, Any], robot: Robot) -> dict[str, Any]:
    """Those of some further columns that are still unknown: a package or script may have declared others since."""
    known = {column.name for column in columns_of(robot)} if extra else set()
    return {name: cells for name, cells in extra.items() if name not in known}


def refuse_other_figures(extra: Mapping[str, Any], robot: Robot, cells: Mapping[str, NDArray[Any]]) -> None:
    """Raise an InputError for further columns that are known by now, if their figures are not those of the plan.

    Parameters
    ----------
    extra
        Further columns, by name.
    robot
        Of the plan.
    cells
        The cells (T,) of the known columns that the plan has.
    """
    for column in columns_of(robot) if extra else ():
        if column.name in extra:
            _refuse_others(column, extra[column.name], cells.get(column.name))


def _refuse_others(column: Column, given: Any, expected: NDArray[Any] | None) -> None:
    todo = "Leave it out of `extra`, or call it otherwise if it is something else."
    called = f"column {column.name!r} of `extra` is known as one of {column.quantity.pattern!r}"
    if expected is None:
        raise InputError(f"{called}, of which this plan has no figures. {todo}")
    found = np.asarray(given)
    if found.shape != expected.shape or found.dtype.kind not in "iuf":
        raise InputError(f"{called}, but holds {found.dtype} {found.shape}: expected {expected.dtype} {expected.shape}")
    off = np.abs(found.astype(float) - expected)
    wrong = ~(off <= column.quantity.tolerance)  # what is no number is wrong, too
    if wrong.any():
        step, unit = int(np.argmax(wrong)), column.quantity.unit
        raise InputError(f"{called}, but is {off[step]:.3g} {unit} off at step {step} from what the plan gives. {todo}")


def refuse_names(names: Sequence[str], robot: Robot) -> None:
    """Raise an InputError for the first name that no further column may have."""
    if not names:
        return
    likenesses = [(quantity.pattern, _likeness(quantity.pattern, robot)) for quantity in quantities()]
    for name in names:
        if not isinstance(name, str) or not name.strip() or len(name) > LONGEST_NAME or not is_plain(name):
            raise InputError(
                f"column {name!r:.100} is unknown, and its name cannot be kept: expected 1 to {LONGEST_NAME} letters, "
                "without control characters"
            )
        plain = _plainer(name)
        alike = next((pattern for pattern, like in likenesses if like.fullmatch(plain)), None)
        if alike is not None:
            raise InputError(
                f"column {name!r} is unknown: a plan of this robot has none of that name, but it looks like "
                f"{alike!r}. Call it otherwise if it is something else."
            )


def from_arrow(name: str, cells: pa.ChunkedArray) -> NDArray[Any]:
    """The cells (T,) of a column of a table.

    Raises
    ------
    InputError
        They are of a type that is not kept, or empty.
    """
    kind = cells.type
    text = pa.types.is_string(kind) or pa.types.is_large_string(kind)
    if not text and kind not in (pa.int64(), pa.float64()):
        raise InputError(f"column {name!r} is unknown and holds {kind}, which cannot be kept: {_EXPECTED}")
    if cells.null_count:
        raise InputError(f"column {name!r} is unknown and has {cells.null_count} empty cells, which cannot be kept")
    if not text:
        return cells.to_numpy()
    try:
        return np.array([*cells.to_pylist(), None], dtype=object)[:-1]  # never an array of characters
    except UnicodeDecodeError:
        raise InputError(f"column {name!r} is unknown and holds text that is not UTF-8") from None


def note(extra: Mapping[str, Any]) -> str:
    """A sentence for people about them."""
    names = ", ".join(list(extra)[:_NAMED]) + (f" and {len(extra) - _NAMED} more" if len(extra) > _NAMED else "")
    columns, are = ("column", "is") if len(extra) == 1 else ("columns", "are")
    return f"{len(extra)} {columns} that Hognose does not know {are} kept: {names}"


def _checked(name: str, given: Any, rows: int) -> NDArray[Any]:
    cells = given if isinstance(given, np.ndarray) else np.array(given)
    if cells.shape != (rows,):
        raise InputError(f"column {name!r} has cells of shape {cells.shape}, expected {(rows,)}: one for each step")
    if cells.dtype.kind in "UO":
        cells = cells.astype(object)
        if not all(isinstance(cell, str) for cell in cells):
            raise InputError(f"column {name!r} holds cells of several types: {_EXPECTED}")
        if max(map(len, cells), default=0) > LONGEST_TEXT:
            raise InputError(f"column {name!r} has a text of more than {LONGEST_TEXT:,} letters, too long to be kept")
        if not all(is_plain(cell, lines=True) for cell in cells):
            raise InputError(f"column {name!r} has a text with control characters, which cannot be kept")
    elif cells.dtype not in (np.int64, np.float64):
        raise InputError(f"column {name!r} holds {cells.dtype}, which cannot be kept: {_EXPECTED}")
    elif not np.isfinite(cells).all():
        raise InputError(f"column {name!r} has values that are not finite, which cannot be kept")
    return cells


def _plainer(name: str) -> str:
    """A name without what makes no difference to people: case, width, and what stands between words."""
    return re.sub(r"[\W_]+", "_", unicodedata.normalize("NFKC", name).casefold()).strip("_")


def _likeness(pattern: str, robot: Robot) -> re.Pattern[str]:
    """What names look like those of a quantity: its words, with any number where it has numbers."""

    def label(axis: str) -> str:
        labels = [re.escape(label.casefold()) for label in LABELS[axis](robot)]
        return r"\d+" if all(label.isdigit() for label in labels) else f"(?:{'|'.join(labels)})"

    parts = re.split(r"\{(\w+)\}", pattern)
    return re.compile("".join(label(part) if k % 2 else re.escape(part.casefold()) for k, part in enumerate(parts)))
