"""A task file's text with other values in it: comments, order, unit and layout stay as they are."""

from __future__ import annotations

import math
import tomllib
from collections.abc import MutableMapping
from dataclasses import dataclass
from typing import Any, get_args

from pydantic.fields import FieldInfo

from hognose.errors import InputError, MissingExtraError
from hognose.files.toml_arrays import array_of_rows
from hognose.files.toml_source import validate
from hognose.planning import TaskSpec
from hognose.planning.base_spec import BaseSpec, WorkspaceSpec
from hognose.planning.task import PathSpec
from hognose.units import LENGTH_UNITS, FileModel, Length

#: Coordinates are rounded to this (m); other lengths too, where that is little.
ROUNDED = 1e-6
_LITTLE = 1e-4
#: What marks a number as a length in the unit the file declares.
_IS_LENGTH = get_args(Length)[-1]
#: Where the base stands decides whether a cart's nose is at the entrance: its numbers are not rounded.
_EXACT = (BaseSpec, WorkspaceSpec)
#: Keys of a path along way-points only, and of one that is searched only.
_ALONG = {"way_points"}
_SEARCHED = {"target", "entrance"}


def revised(text: str, spec: TaskSpec) -> str:
    """The text of a task file that says what a spec says: only values that differ are replaced.

    Parameters
    ----------
    text
        Of a task file without faults.
    spec
        In SI, as everywhere; coordinates are rounded to 0.001 mm, but for those of the base.

    Raises
    ------
    InputError
        The text is laid out in a way that cannot be changed in place.
    MissingExtraError
        tomlkit is not installed.
    """
    try:
        import tomlkit
        from tomlkit.exceptions import TOMLKitError
    except ImportError:
        raise MissingExtraError(
            "writing task files needs the package tomlkit; install it with: pip install 'hognose[view]'"
        ) from None
    try:
        windows = "\r\n" in text and text.count("\n") == text.count("\r\n")
        document = tomlkit.parse(text.replace("\r\n", "\n") if windows else text)
        _Revision(LENGTH_UNITS[str(document["units"])]).merge(document, spec)
        made = tomlkit.dumps(document)
        made = made.replace("\n", "\r\n") if windows else made
        said = validate(tomllib.loads(made), TaskSpec, "what was to be written")
    except (TOMLKitError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"the task file cannot be changed in place: {error}. Save under a new name.") from None
    if not agrees(said.model_dump(), spec.model_dump()):
        raise InputError("the task file is laid out in a way that cannot be changed in place. Save under a new name.")
    return made


def written(spec: TaskSpec) -> str:
    """A complete task file, in mm."""
    return revised('schema = 1\nname = ""\nunits = "mm"\n', spec)


def agrees(one: Any, other: Any) -> bool:
    """Whether two dumps of models say the same, but for the rounding of numbers."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(agrees(one[key], other[key]) for key in one)
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(agrees, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=1e-9, abs_tol=ROUNDED)
    return one == other


@dataclass(frozen=True)
class _Revision:
    """Values on their way into a file of one unit (m)."""

    unit: float

    def merge(self, table: MutableMapping[str, Any], model: FileModel) -> None:
        """Let a table of the file say what a model says."""
        unknown = set(table) - {field.alias or name for name, field in type(model).model_fields.items()} - {"units"}
        for key in unknown:  # of another kind of obstacle that stood in this place
            del table[key]
        for name, field in sorted(
            type(model).model_fields.items(), key=lambda item: _is_tables(getattr(model, item[0]))
        ):
            key, value = field.alias or name, getattr(model, name)
            if value is None or value == () or name in _foreign(model):
                if key in table:
                    del table[key]
            elif key in table or value != field.get_default():
                self._set(table, key, value, field, exact=isinstance(model, _EXACT))

    def _set(self, table: MutableMapping[str, Any], key: str, value: Any, field: FieldInfo, exact: bool) -> None:
        import tomlkit

        if isinstance(value, FileModel):
            if key not in table:
                table[key] = tomlkit.table()
            self.merge(table[key], value)
        elif _is_tables(value):
            self._set_tables(table, key, value)
        elif isinstance(value, str | bool):
            if key not in table or table[key] != value:
                table[key] = value
        elif _is_texts(value):
            if key not in table or list(table[key]) != list(value):
                table[key] = list(value)
        else:
            self._set_numbers(table, key, value, field, exact)

    def _set_tables(self, table: MutableMapping[str, Any], key: str, models: tuple[FileModel, ...]) -> None:
        import tomlkit

        if key not in table:
            table[key] = tomlkit.aot()
        there = table[key]
        while len(there) > len(models):
            del there[-1]
        for number, model in enumerate(models):
            if number == len(there):
                there.append(self._new_table(there, model))
            self.merge(there[number], model)

    def _new_table(self, there: Any, model: FileModel) -> Any:
        import tomlkit
        from tomlkit.items import AoT

        made = tomlkit.table() if isinstance(there, AoT) else tomlkit.inline_table()
        if isinstance(there, AoT):
            made.trivia.indent = "\n"
        if "kind" in type(model).model_fields:
            made["kind"] = dict(model)["kind"]
        return made

    def _set_numbers(
        self, table: MutableMapping[str, Any], key: str, value: Any, field: FieldInfo, exact: bool
    ) -> None:
        import tomlkit

        unit = self.unit if _is_length(field) else None
        before = table[key].unwrap() if key in table else None
        if _same(before, value, unit):
            return
        text = table[key].as_string() if before is not None else ""
        whole = bool(text) and not set(text.partition("#")[0]) & set(".eEn")
        several = isinstance(value, tuple)

        def literal(number: float) -> str:
            if unit is not None and not isinstance(number, int):
                number = _shortest(number, unit) if exact else _rounded(number / unit, unit, several)
            return _literal(number, whole)

        if several and isinstance(value[0], tuple):
            made = array_of_rows(text, [[literal(c) for c in row] for row in value])
        elif several:
            made = f"[{', '.join(map(literal, value))}]"
        else:
            made = literal(value)
        table[key] = tomlkit.value(made)


def _is_tables(value: Any) -> bool:
    """Whether a value is written as tables, which must come after all other keys of theirs."""
    return isinstance(value, tuple) and bool(value) and isinstance(value[0], FileModel)


def _is_texts(value: Any) -> bool:
    return isinstance(value, tuple) and bool(value) and isinstance(value[0], str)


def _foreign(model: FileModel) -> set[str]:
    """Keys that must not stand in the file, though the model has values for them."""
    if not isinstance(model, PathSpec):
        return set()
    return _SEARCHED if model.target is None else _ALONG


def _is_length(field: FieldInfo) -> bool:
    """Whether a field holds lengths, alone or in tuples."""
    return _IS_LENGTH in field.metadata or _holds_length(field.annotation)


def _holds_length(annotation: Any) -> bool:
    inner = (*get_args(annotation), *getattr(annotation, "__metadata__", ()))
    return _IS_LENGTH in inner or any(map(_holds_length, get_args(annotation)))


def _same(before: Any, value: Any, unit: float | None) -> bool:
    """Whether what stands in the file means a value, exactly or as it would be written."""
    if isinstance(value, tuple):
        alike = isinstance(before, list) and len(before) == len(value)
        return alike and all(_same(*pair, unit) for pair in zip(before, value, strict=True))
    if not isinstance(before, int | float):
        return False
    return before * (1.0 if unit is None else unit) == value


def _shortest(value: float, unit: float) -> float:
    """The number with the fewest digits that means a length (m), but for its last bit, when it is read in a unit."""
    for digits in range(1, 17):
        number = float(f"{value / unit:.{digits}g}")
        if abs(number * unit - value) <= math.ulp(value):
            return number
    return value / unit


def _rounded(number: float, unit: float, coordinate: bool) -> float:
    """A length in the file's unit, rounded: a coordinate, and what is not changed much by that."""
    rounded = round(number, math.ceil(-math.log10(ROUNDED / unit) - 1e-9))
    little = coordinate or abs(rounded - number) <= _LITTLE * abs(number)
    return rounded if little else float(f"{number:.6g}")


def _literal(value: float, whole: bool) -> str:
    """A number as TOML; whole if all others are and it can be."""
    if isinstance(value, int):
        return str(value)
    if whole and value == int(value):
        return str(int(value))
    return repr(value + 0.0)  # no minus zero
