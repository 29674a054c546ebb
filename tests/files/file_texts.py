"""TOML texts of robots and tasks: written, altered, damaged."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

from hognose.errors import HognoseError
from hognose.files import bundled_tasks
from hognose.files.loading import _ROBOTS

Answer = TypeVar("Answer")
Keys = tuple[str | int, ...]

ROBOT_FILES: dict[str, Path] = {name: Path(file) for name, file in _ROBOTS.items()}
TASK_FILES: dict[str, Path] = bundled_tasks()
ALL_FILES = {**ROBOT_FILES, **TASK_FILES}
#: Files of many sections or obstacles, whose keys others have, too: tests that try every key leave them out.
REPETITIVE = {
    "casia-coiled", "on-wing-taper", "safire-18dof", "zju-24cable", "test-box", "pipe-jungle", "engine-stage",
    "feeder-slot",
}  # fmt: skip
VARIED_FILES = {name: file for name, file in ALL_FILES.items() if name not in REPETITIVE}


def outcome(action: Callable[[], Answer]) -> Answer | HognoseError:
    """What an action returns, or the error of ours that it raises; any other escapes."""
    try:
        return action()
    except HognoseError as error:
        return error


def places(data: Any, at: Keys = ()) -> Iterator[Keys]:
    """The key path of every value at every depth, containers too."""
    if at:
        yield at
    if isinstance(data, dict):
        for key, value in data.items():
            yield from places(value, (*at, key))
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from places(value, (*at, index))


def value_at(data: Any, keys: Keys) -> Any:
    for key in keys:
        data = data[key]
    return data


def with_value(data: dict[str, Any], keys: Keys, value: Any) -> dict[str, Any]:
    """The data with another value at a key path; `...` deletes it."""
    data = copy.deepcopy(data)
    parent = value_at(data, keys[:-1])
    if value is ...:
        del parent[keys[-1]]
    else:
        parent[keys[-1]] = value
    return data


def toml(data: dict[str, Any]) -> tuple[str, dict[Keys, int]]:
    """A TOML text of the data, and the line on which each key or table header stands."""
    lines: list[str] = []
    where: dict[Keys, int] = {}

    def table(content: dict[str, Any], at: Keys, header: str) -> None:
        inner = {}
        for key, value in content.items():
            if isinstance(value, dict) or (
                isinstance(value, list) and value and all(isinstance(v, dict) for v in value)
            ):
                inner[key] = value
            else:
                lines.append(f"{_key(key)} = {_value(value)}")
                where[*at, key] = len(lines)
        for key, value in inner.items():
            name = f"{header}.{_key(key)}" if header else _key(key)
            opened = [(value, f"[{name}]", (*at, key))] if isinstance(value, dict) else []
            if isinstance(value, list):
                opened = [(item, f"[[{name}]]", (*at, key, index)) for index, item in enumerate(value)]
            for item, head, path in opened:
                lines.extend(["", head])
                where[path] = len(lines)
                where.setdefault((*at, key), len(lines))
                table(item, path, name)

    table(data, (), "")
    return "\n".join(lines) + "\n", where


def _key(key: str) -> str:
    return key if key.replace("_", "").replace("-", "").isalnum() and key.isascii() else json.dumps(key)


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(key)} = {_value(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(_value(item) for item in value) + "]"
    return repr(value)


def scaled(data: dict[str, Any], factor: float, lengths: set[str]) -> dict[str, Any]:
    """The data with every value of the keys named multiplied."""

    def walk(value: Any, is_length: bool) -> Any:
        if isinstance(value, dict):
            return {key: walk(item, key in lengths) for key, item in value.items()}
        if isinstance(value, list):
            return [walk(item, is_length) for item in value]
        return value * factor if is_length and isinstance(value, int | float) else value

    return walk(data, False)
