"""Which columns of a scan hold x, y and z."""

from __future__ import annotations

import re
from collections.abc import Sequence

from hognose.errors import InputError
from hognose.units import LENGTH_UNITS

#: Columns that are asked for, by name or by number from 1; None to find them.
Asked = Sequence[str | int] | None
#: What may stand before or after the letter: "Points:0", "pos_x", "X coordinate".
_WORDS = r"points?|pts?|p|pos|position|coords?|coordinates?|xyz|point_xyz|points_m_xyz|location|cartesian"
_UNIT = re.compile(r"[\s_]*[\[(<{/]?\s*(mm|cm|m|in|inch|inches|meters?|metres?|millimeters?|millimetres?)\s*[\])>}]?$")
_UNITS = {"inch": "in", "inches": "in", "meter": "m", "metre": "m", "millimeter": "mm", "millimetre": "mm"}


def axes(headings: Sequence[str], asked: Asked, what: str = "columns") -> tuple[int, int, int]:
    """Return the places of x, y and z among columns, from 0.

    Parameters
    ----------
    headings
        The names of the columns; empty where they have none.
    asked
        Names or numbers, from 1, of the columns that hold x, y and z; None if they are to be found by their names.
    what
        What messages call the columns.

    Raises
    ------
    InputError
        They are not there, or cannot be told apart; names those there are, and the key that chooses.
    """
    there = ", ".join(f"{k} {name!r}" if name else str(k) for k, name in enumerate(headings, 1))
    if asked is not None:
        found = tuple(_asked(each, headings, there, what) for each in asked)
    else:
        found = tuple(_by_name(axis, headings, there, what) for axis in range(3))
    if len(set(found)) < 3:
        raise InputError(f"x, y and z would be in the same column; its {what} are {there}: choose three with `columns`")
    return found[0], found[1], found[2]


def names_axes(headings: Sequence[str]) -> bool:
    """Return whether some heading seems to name x, y or z."""
    return any(_is_axis(axis, name) for axis in range(3) for name in headings)


def unit_of(headings: Sequence[str]) -> float | None:
    """Return the metres in the unit that these headings name, or None if they name none, or different ones."""
    units = {_unit(name) for name in headings}
    unit = units.pop()
    return LENGTH_UNITS[unit] if unit and not units else None


def _asked(asked: str | int, headings: Sequence[str], there: str, what: str) -> int:
    if isinstance(asked, int):
        if not 1 <= asked <= len(headings):
            raise InputError(f"`columns` names the number {asked}, but there are {len(headings)} {what}: {there}")
        return asked - 1
    found = [k for k, name in enumerate(headings) if name == asked]
    found = found or [k for k, name in enumerate(headings) if name.lower() == asked.strip().lower()]
    if len(found) != 1:
        times = "none" if not found else f"{len(found)}"
        raise InputError(f"`columns` names {asked!r}, but {times} of the {what} is called so: {there}")
    return found[0]


def _by_name(axis: int, headings: Sequence[str], there: str, what: str) -> int:
    plain = [k for k, name in enumerate(headings) if _bare(name) == "xyz"[axis]]
    found = plain or [k for k, name in enumerate(headings) if _is_axis(axis, name)]
    if len(found) != 1:
        trouble = f"none seems to be {'xyz'[axis]}" if not found else f"{len(found)} seem to be {'xyz'[axis]}"
        raise InputError(
            f"its {what} are {there}: {trouble}; say which hold x, y and z, by name or number: `columns = [1, 2, 3]`"
        )
    return found[0]


def _is_axis(axis: int, name: str) -> bool:
    letter = f"(?:{'xyz'[axis]}|{axis})"
    bare = _bare(name)
    between = r"[\s_.:\-\[(]*"
    return bool(
        bare == "xyz"[axis]
        or re.fullmatch(rf"(?:{_WORDS}){between}{letter}[\])]?", bare)
        or re.fullmatch(rf"{'xyz'[axis]}[\s_.:\-]*(?:{_WORDS})", bare)
    )


def _bare(name: str) -> str:
    """A heading without its unit, in lower case."""
    name = name.strip().lower()
    return _UNIT.sub("", name).strip() or name


def _unit(name: str) -> str | None:
    name = name.strip().lower()
    if re.match(r"points_m_xyz", name):
        return "m"
    found = _UNIT.search(name)
    if found is None or found.start() == 0:
        return None
    return _UNITS.get(found[1].rstrip("s") if found[1] != "inches" else "inches", found[1])
