"""Reading a TOML file into a validated model, with errors that name file, line and key."""

from __future__ import annotations

import difflib
import re
import tomllib
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from hognose.errors import InputError
from hognose.files.toml_words import OF_TYPE, expectation, shown
from hognose.plain_text import plain
from hognose.read_whole import read_whole
from hognose.units import LENGTH_UNITS, FileModel

Model = TypeVar("Model", bound=FileModel)

#: No robot or task file that people write is larger (bytes).
LARGEST_FILE = 8_000_000
#: What pydantic puts into the location of a fault for a member of a union.
_BRANCHES = ("float", "int", "constrained-float", "constrained-int", "constrained-str")
#: The unit at the end of a key.
_UNIT = re.compile(r"_(s|deg|deg_s|deg_s2|m|mm)$")
#: What keys are called elsewhere, without their units, in no way like what they are called here.
_OTHER_NAMES = {"jerk_time": "smoothing_s", "jerk": "smoothing_s", "dt": "period_s", "cycle_time": "period_s"}
_HEADER = re.compile(r"^\s*(\[\[?)\s*([^\[\]#]+?)\s*\]\]?\s*(?:#.*)?$")
_KEY = re.compile(r"""^\s*((?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*'))*)\s*=""")


def read_model(path: Path, model: type[Model]) -> Model:
    """The validated content of a TOML file; its lengths are converted from the unit it declares.

    Raises
    ------
    InputError
        One message that lists every fault, each with line and key.
    """
    text = _read_text(path)
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not valid TOML: {error}") from None
    if not data:
        raise InputError(f"{path}: the file is empty; see `hognose robot` and the examples for what it may hold")
    return validate(data, model, str(path), _lines_of_keys(text), path.parent)


def validate(
    data: dict[str, Any],
    model: type[Model],
    source: str,
    lines: dict[tuple[str | int, ...], int] | None = None,
    folder: Path | None = None,
) -> Model:
    """The validated model of parsed data.

    `lines` maps key paths to lines for the messages; files that the data names are read if there is a `folder` they are
    relative to.
    """
    data = dict(data)
    units = data.pop("units", None)
    if not isinstance(units, str) or units not in LENGTH_UNITS:
        said = "is missing" if units is None else f"is {shown(units)}"
        raise InputError(
            f"{_at(source, ('units',), lines or {})}: {said}; expected one of {', '.join(map(repr, LENGTH_UNITS))}, "
            "the unit of every length in the file"
        )
    try:
        return model.model_validate(data, context={"metres_per_unit": LENGTH_UNITS[units], "folder": folder})
    except ValidationError as error:
        found = error.errors(include_url=False)
        # A list that is too short because its items are wrong is not a fault of its own.
        wrong = {fault["loc"][:end] for fault in found for end in range(len(fault["loc"]))}
        real = [fault for fault in found if fault["type"] != "too_short" or fault["loc"] not in wrong]
        told = _without_other_kinds(model, [dict(fault) for fault in real])
        faults = [plain(_fault(model, fault, source, lines or {})) for fault in told]
        raise InputError("\n".join(dict.fromkeys(faults))) from None


def _without_other_kinds(model: type[BaseModel], faults: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Faults less those that ask for another type where the value is of one that is fine, but not what it must be."""
    places = [(_without_tags(model, tuple(fault["loc"])), fault["type"]) for fault in faults]

    def is_met(keys: tuple[str | int, ...]) -> bool:
        return any(
            place[: len(keys)] == keys and (len(place) > len(keys) or kind not in (*OF_TYPE, "too_short", "too_long"))
            for place, kind in places
        )

    pairs = zip(faults, places, strict=True)
    return [fault for fault, (keys, kind) in pairs if kind not in OF_TYPE or not is_met(keys)]


def _read_text(path: Path) -> str:
    data = read_whole(path, LARGEST_FILE, "a TOML file", "no robot or task file is that large")
    if data.startswith(b"PAR1"):
        raise InputError(f"{path}: is a plan file, expected a robot or task file; see `hognose check` and `report`")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file (expected TOML in UTF-8)") from None


def _fault(model: type[BaseModel], fault: dict[str, Any], source: str, lines: dict[tuple[str | int, ...], int]) -> str:
    keys = _without_tags(model, tuple(fault["loc"]))
    place = _at(source, keys, lines)
    kind, message = fault["type"], str(fault["msg"]).removeprefix("Value error, ")
    if kind == "extra_forbidden":
        known = _known_keys(model, keys[:-1])
        near = _nearest(str(keys[-1]), known)
        hint = f"; did you mean {near!r}?" if near else "."
        return f"{place}: unknown key{hint} Known here: {', '.join(known)}" if known else f"{place}: unknown key"
    if kind == "missing":
        return f"{place}: is missing"
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        kinds, given = sorted(_kinds()), dict(fault["input"]).get("kind")
        near = difflib.get_close_matches(str(given), kinds, 1)
        hint = f"; did you mean {near[0]!r}?" if near else "."
        said = "is missing." if given is None else f"{shown(given)} is unknown{hint}"
        return f"{_at(source, (*keys, 'kind'), lines)}: {said} Kinds: {', '.join(kinds)}"
    value = fault.get("input")
    if (expected := expectation(model, fault)) is not None:
        return f"{place}: expected {expected}, got {shown(value)}"
    got = "" if isinstance(value, dict) or kind == "value_error" else f", got {shown(value)}"
    return f"{place}: {message[:1].lower()}{message[1:]}{got}"


def _nearest(key: str, known: list[str]) -> str | None:
    """The known key that was probably meant: by what it means if the table knows, or else by its letters.

    Units at the end say nothing about that.
    """
    stem, stems = _UNIT.sub("", key), [_UNIT.sub("", name) for name in known]
    meant = _OTHER_NAMES.get(stem)
    if meant in known:
        return meant
    near = difflib.get_close_matches(stem, stems, 1, 0.5)
    alike = [name for name, its in zip(known, stems, strict=True) if its in near]
    return next(iter(difflib.get_close_matches(key, alike, 1, 0.0)), None)


def _at(source: str, keys: tuple[str | int, ...], lines: dict[tuple[str | int, ...], int]) -> str:
    for end in range(len(keys), 0, -1):
        if keys[:end] in lines:
            return f"{source}:{lines[keys[:end]]}: {_dotted(keys)}"
    return f"{source}: {_dotted(keys)}" if keys else source


def _dotted(keys: tuple[str | int, ...]) -> str:
    """A key path as people count: `section[1].pitch` is the first section."""
    text = ""
    for key in keys:
        text += f"[{key + 1}]" if isinstance(key, int) else f".{key}" if text else str(key)
    return text


def _without_tags(model: Any, loc: tuple[str | int, ...]) -> tuple[str | int, ...]:
    """The keys of an error's location less what pydantic adds for members of unions."""
    keys: list[str | int] = []
    for part in loc:
        if isinstance(part, str) and keys and isinstance(keys[-1], int) and part in _kinds():
            continue
        if isinstance(part, str) and not re.fullmatch(r"[^\[\](),]*", part):
            continue
        if part in _BRANCHES and keys:
            continue
        keys.append(part)
    return tuple(keys)


def _kinds() -> set[str]:
    from hognose.scene import Obstacle

    return {kind for _, kind in _members(Obstacle)}


def _members(union: Any) -> list[tuple[type[BaseModel], str]]:
    members = [m for arg in get_args(union) for m in (arg, *get_args(arg)) if isinstance(m, type)]
    return [
        (m, m.model_fields["kind"].default) for m in members if issubclass(m, BaseModel) and "kind" in m.model_fields
    ]


def _known_keys(model: type[BaseModel], keys: tuple[str | int, ...]) -> list[str]:
    """Keys that may stand in the table at this key path."""
    models: list[type[BaseModel]] = [model]
    for key in (k for k in keys if isinstance(k, str)):
        inner = [m.model_fields[key].annotation for m in models if key in m.model_fields]
        models = [found for annotation in inner for found in _models_within(annotation)]
    known = {field.alias or name for m in models for name, field in m.model_fields.items()}
    return sorted(known | ({"units"} if not keys else set()))


def _models_within(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [found for arg in get_args(annotation) for found in _models_within(arg)]


def _lines_of_keys(text: str) -> dict[tuple[str | int, ...], int]:
    """The line on which each key or table header of a TOML file stands.

    The TOML parser gives no lines for keys, so headers and keys at the start of lines are read here; a key this
    reading misses falls back to the line of its table.
    """
    lines: dict[tuple[str | int, ...], int] = {}
    counts: dict[tuple[str | int, ...], int] = {}
    table: tuple[str | int, ...] = ()
    for number, line in enumerate(text.splitlines(), 1):
        if header := _HEADER.match(line):
            table = _opened(_split(header[2]), header[1] == "[[", counts)
            lines.setdefault(table, number)
            lines.setdefault(table[:-1] if isinstance(table[-1], int) else table, number)
        elif key := _KEY.match(line):
            lines.setdefault((*table, *_split(key[1])), number)
    return lines


def _opened(names: list[str], is_array: bool, counts: dict[tuple[str | int, ...], int]) -> tuple[str | int, ...]:
    """The key path a table header opens; names of arrays are followed by the index of their latest element."""
    path: tuple[str | int, ...] = ()
    for position, name in enumerate(names):
        path = (*path, name)
        if is_array and position == len(names) - 1:
            counts[path] = counts.get(path, -1) + 1
        if path in counts:
            path = (*path, counts[path])
    return path


def _split(dotted: str) -> list[str]:
    return [part.strip().strip("\"'") for part in dotted.split(".")]
