"""What a key of a file must be, in plain words, made from the annotations of its model."""

from __future__ import annotations

import datetime
import types
from collections.abc import Iterable
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel

#: Faults of pydantic that say that a value is of another type than was expected.
OF_TYPE = {
    "bool_type", "dict_type", "float_type", "int_from_float", "int_type", "list_type", "model_attributes_type",
    "model_type", "string_type", "tuple_type",
}  # fmt: skip
#: Types of values, one and several.
_WORDS: dict[Any, tuple[str, str]] = {
    bool: ("true or false", "true or false each"),
    float: ("a number", "numbers"),
    int: ("a whole number", "whole numbers"),
    str: ("text in quotes", "texts in quotes"),
}
_COUNTS = {1: "one", 2: "two", 3: "three", 4: "four"}
#: Letters of a value that are shown.
_LONGEST = 60


def expectation(model: type[BaseModel], fault: dict[str, Any]) -> str | None:
    """What was expected where a value has a wrong type or length, as in "a list of three numbers"; None of others.

    Parameters
    ----------
    model
        Of the whole file.
    fault
        One of pydantic's.
    """
    kind, context = fault["type"], fault.get("ctx", {})
    found = _pieces(_at(model, fault["loc"]))
    if kind in OF_TYPE:
        return _either(_described(each) for each in found) or None
    if kind in ("too_short", "too_long"):
        fixed = [each for each in found if get_origin(each) is tuple and ... not in get_args(each)]
        if fixed:
            return _either(map(_described, fixed))
        return (
            _count("at least", context["min_length"])
            if "min_length" in context
            else _count("at most", context["max_length"])
        )
    return None


def shown(value: Any) -> str:
    """A value of a file for a message, as people write it, cut where it is long."""
    text = "a table" if isinstance(value, dict) else _written(value)
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


def _written(value: Any) -> str:
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_written, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key} = {_written(item)}' for key, item in value.items())}}}"
    if isinstance(value, bool):
        return str(value).lower()
    dated = isinstance(value, datetime.date | datetime.time)
    return value.isoformat() if dated else repr(value)


def _count(bound: str, count: int) -> str:
    return f"{bound} {count} {'entry' if count == 1 else 'entries'}"


def _at(model: type[BaseModel], loc: Iterable[int | str]) -> list[Any]:
    """The annotations of what may stand at the location of a fault; unions add parts of their own to it."""
    here: list[Any] = [model]
    for part in loc:
        pieces = _pieces(here)
        if isinstance(part, int):
            here = [item for each in pieces for item in _items(each, part)]
            continue
        models = [each for each in pieces if isinstance(each, type) and issubclass(each, BaseModel)]
        tagged = [each for each in models if "kind" in each.model_fields and each.model_fields["kind"].default == part]
        fields = [(name, field) for each in models for name, field in each.model_fields.items()]
        here = tagged or [field.annotation for name, field in fields if part in (name, field.alias)] or here
    return here


def _pieces(annotations: Iterable[Any]) -> list[Any]:
    """Annotations without what is said of them besides, the members of unions one by one."""
    found: list[Any] = []
    for each in annotations:
        origin = get_origin(each)
        if origin is Annotated:
            found += _pieces(get_args(each)[:1])
        elif origin in (Union, types.UnionType):
            found += _pieces(get_args(each))
        elif each is not types.NoneType:
            found.append(each)
    return found


def _items(annotation: Any, index: int) -> list[Any]:
    """The annotation of an item of a list."""
    arguments = [each for each in get_args(annotation) if each is not ...] if get_origin(annotation) is tuple else []
    return arguments[:1] if ... in get_args(annotation) else arguments[index : index + 1]


def _described(annotation: Any, several: bool = False) -> str:
    """One value of a type in words, or several."""
    if get_origin(annotation) is tuple:
        arguments = get_args(annotation)
        items = [_either(_described(each, True) for each in _pieces([item])) for item in arguments if item is not ...]
        count = "" if ... in arguments else f"{_COUNTS.get(len(items), len(items))} "
        return f"{'lists' if several else 'a list'} of {count}{_either(items)}"
    if get_origin(annotation) is Literal:
        return _either(repr(each) for each in get_args(annotation))
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return "tables" if several else "a table"
    return _WORDS.get(annotation, ("another value", "other values"))[several]


def _either(words: Iterable[str]) -> str:
    return " or ".join(dict.fromkeys(words))
