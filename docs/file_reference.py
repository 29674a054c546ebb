"""Tables of what a file may say, made from the models that read it.

Types, units, bounds and defaults come from the models, the words from `reference/fields.toml`. A field without
words, and words without a field, are errors: the tables cannot fall behind.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt, MaxLen, MinLen
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from hognose.units import FileModel, Length

WORDS = Path(__file__).parent / "reference" / "fields.toml"
#: What marks a number as a length in the unit the file declares.
_IS_LENGTH = get_args(Length)[-1]
_BOUNDS = {Gt: ("gt", "above"), Ge: ("ge", "at least"), Lt: ("lt", "below"), Le: ("le", "at most")}
_NAMES = {float: "number", int: "whole number", str: "text", bool: "`true` or `false`"}
#: Units that the end of a key tells; the first that fits.
_ENDINGS = {
    "_m_s2": "m/s²",
    "_deg_s2": "deg/s²",
    "_deg_s": "deg/s",
    "_deg": "deg",
    "_s": "s",
    "_mass": "kg",
    "_N_m2": "N m²",
    "_N": "N",
}
#: What a box to be kept out of may not say, though an obstacle that is one may.
_STANDS, _OF_MOTION = "path.keep_out", ("motion", "motion_pivot", "motion_axis", "motion_repeats", "timing_s")


class Table(NamedTuple):
    """One table of a file: its place in the file, as a heading, and its model."""

    title: str
    model: type[FileModel]


def reference(model: type[FileModel]) -> str:
    """Markdown that describes every table of the files a model reads."""
    words, parts = tomllib.loads(WORDS.read_text()), []
    for title, part in tables(model):
        hidden = _OF_MOTION if title == f"`[[{_STANDS}]]`" else ()
        rows = [_row(part, key, field, words) for key, field in part.model_fields.items() if key not in hidden]
        head = "| key | value | unit | default | what |\n|---|---|---|---|---|\n"
        parts.append(f"## {title}\n\n{_said(part)}\n\n{head}" + "\n".join(rows) + "\n")
    return "\n".join(parts)


def tables(model: type[FileModel]) -> list[Table]:
    """Every table that files of a model have, the top level first; one that all kinds of a table have comes once."""
    return [Table("Top level", model), *_below(model, "", "")]


def key_of(name: str, field: FieldInfo) -> str:
    """The key by which a file calls a field."""
    return field.alias or name


def unknown_words(models: list[type[FileModel]]) -> list[str]:
    """Entries of `fields.toml` that describe no field of these models or of what they hold."""
    families = {base for model in models for _, part in tables(model) for base in part.__mro__}
    known = {f"{b.__name__}.{name}" for b in families if issubclass(b, FileModel) for name in b.model_fields}
    words = tomllib.loads(WORDS.read_text())
    return [f"{part}.{name}" for part, names in words.items() for name in names if f"{part}.{name}" not in known]


def _below(model: type[FileModel], above: str, of: str, hidden: tuple[str, ...] = ()) -> Iterator[Table]:
    for name, field in model.model_fields.items():
        if name in hidden:
            continue
        kinds = list(_models(field.annotation))
        many = get_origin(field.annotation) is tuple
        place = f"`[[{above}{name}]]`" if many else f"`[{above}{name}]`"
        shared = _shared(kinds)
        for kind in kinds:
            whose = kind.__name__.lower() if len(kinds) > 1 else of
            yield Table(f"{place}, {whose}" if whose else place, kind)
            left_out = (*shared, *(_OF_MOTION if f"{above}{name}" == _STANDS else ()))
            yield from _below(kind, f"{above}{name}.", whose, left_out)
        if shared:
            others = tuple(key for key in kinds[0].model_fields if key not in shared)
            yield from _below(kinds[0], f"{above}{name}.", "any kind", others)


def _shared(kinds: list[type[FileModel]]) -> list[str]:
    """The fields that hold the same tables in all of several kinds."""
    if len(kinds) < 2:
        return []
    first, *others = ({name: field.annotation for name, field in kind.model_fields.items()} for kind in kinds)
    held = [name for name, annotation in first.items() if list(_models(annotation))]
    return [name for name in held if all(other.get(name) == first[name] for other in others)]


def _models(annotation: Any) -> Iterator[type[FileModel]]:
    if isinstance(annotation, type) and issubclass(annotation, FileModel):
        yield annotation
    for inner in get_args(annotation):
        yield from _models(inner)


def _said(model: type[FileModel]) -> str:
    lines = (model.__doc__ or "").splitlines()
    return "\n".join(line.strip() for line in lines)


def _row(model: type[FileModel], name: str, field: FieldInfo, words: dict[str, dict[str, str]]) -> str:
    what = next((words[base.__name__][name] for base in model.__mro__ if name in words.get(base.__name__, {})), None)
    if what is None:
        raise KeyError(f"{WORDS}: {model.__name__}.{name} is not described")
    value, is_length = _value(field.annotation, field.metadata)
    unit = _unit(name, is_length)
    cells = (f"`{key_of(name, field)}`", value, unit, _default(field, is_length), what)
    return "| " + " | ".join(cells) + " |"


def _unit(name: str, is_length: bool) -> str:
    if is_length:
        return "length/s" if name.endswith("speed") else "length"
    return next((unit for ending, unit in _ENDINGS.items() if name.endswith(ending)), "")


def _default(field: FieldInfo, is_length: bool) -> str:
    given = field.default
    one_literal = get_origin(field.annotation) is Literal and len(get_args(field.annotation)) == 1
    if given is PydanticUndefined or one_literal:
        return "**required**"
    if given is None or given in ((), "") or isinstance(given, FileModel):
        return ""
    if is_length and isinstance(given, tuple):
        return f"[{', '.join(f'{1e3 * length:g}' for length in given)}] mm"
    if is_length:
        return f"{1e3 * given:g} mm"
    return f"`{_toml(given)}`"


def _toml(value: Any) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(map(_toml, value))}]"
    return f'"{value}"' if isinstance(value, str) else str(value).lower()


def _value(annotation: Any, metadata: Any = ()) -> tuple[str, bool]:
    """A type in words with its bounds, and whether it holds lengths."""
    origin, inner = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        flat = [item for part in inner[1:] for item in (part.metadata if isinstance(part, FieldInfo) else [part])]
        return _value(inner[0], [*flat, *metadata])
    is_length = _IS_LENGTH in metadata
    if origin is Literal:
        return ", ".join(f'`"{choice}"`' for choice in inner), False
    if origin in (Union, UnionType):
        found = [_value(choice) for choice in inner if choice is not type(None)]
        kinds = list(_models(annotation))
        text = "table" if kinds else "; or ".join(text for text, _ in found)
        return text, is_length or any(length for _, length in found)
    if origin is tuple:
        if inner[-1] is Ellipsis:
            text, is_length = _value(inner[0])
            text = "tables" if text == "table" else f"list of {text}".replace("of number", "of numbers")
        else:
            found = [_value(item) for item in inner]
            text, is_length = f"[{', '.join(text for text, _ in found)}]", any(length for _, length in found)
            if len({text for text, _ in found}) == 1:
                text = f"{len(found)} {found[0][0]}".replace("number", "numbers")
    elif list(_models(annotation)):
        text = "table"
    else:
        text = _NAMES[annotation]
    bounds = _bounds(metadata)
    return f"{text}, {bounds}" if bounds else text, is_length


def _bounds(metadata: Any) -> str:
    said = []
    for item in metadata:
        if type(item) in _BOUNDS:
            attribute, word = _BOUNDS[type(item)]
            said.append(f"{word} {getattr(item, attribute):g}")
        elif isinstance(item, MinLen) and item.min_length > 1:
            said.append(f"at least {item.min_length} of them")
        elif isinstance(item, MinLen):
            said.append("not empty")
        elif isinstance(item, MaxLen):
            said.append(f"at most {item.max_length}")
    return ", ".join(said)
