"""What other packages add to Hognose, by entry points of theirs: methods, checks, exports, robots.

A package declares them in its `pyproject.toml`, as in `[project.entry-points."hognose.checks"]`.
"""

from __future__ import annotations

from functools import cache
from importlib.metadata import entry_points
from typing import Any

from hognose.errors import InputError


@cache
def added(group: str) -> dict[str, Any]:
    """What is added under a group, by the name of each entry; loaded once.

    Parameters
    ----------
    group
        `methods`, `checks`, `exports` or `robots`.

    Raises
    ------
    InputError
        An entry cannot be loaded, or two packages add one of the same name; says which packages.
    """
    found: dict[str, Any] = {}
    homes: dict[str, str] = {}
    for entry in entry_points(group=f"hognose.{group}"):
        home = entry.dist.name if entry.dist else "a package without a name"
        if entry.name in found:
            raise InputError(
                f"two packages add {entry.name!r} to hognose.{group}: {homes[entry.name]} and {home}; remove one"
            )
        try:
            found[entry.name], homes[entry.name] = entry.load(), home
        except Exception as error:
            raise InputError(
                f"{home} adds {entry.name!r} to hognose.{group}, but {entry.value} cannot be loaded: "
                f"{type(error).__name__}: {error}; mend or uninstall that package"
            ) from error
    return found
