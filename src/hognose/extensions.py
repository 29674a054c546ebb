"""What other packages add to Hognose, by entry points of theirs: methods, checks, columns, exports, robots.

A package declares them in its `pyproject.toml`, as in `[project.entry-points."hognose.checks"]`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, MutableMapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, TypeVar

from hognose.errors import InputError
from hognose.plain_text import plain

Value = TypeVar("Value")


@cache
def added(group: str) -> dict[str, Any]:
    """What is added under a group, by the name of each entry; loaded once.

    Parameters
    ----------
    group
        `methods`, `checks`, `columns`, `exports` or `robots`.

    Raises
    ------
    InputError
        An entry cannot be loaded, or two packages add one of the same name; says which packages.
    """
    found: dict[str, Any] = {}
    homes: dict[str, str] = {}
    for entry in entry_points(group=f"hognose.{group}"):
        home = _package(entry)
        if entry.name in found:
            raise InputError(
                f"two packages add {entry.name!r} to hognose.{group}: {homes[entry.name]} and {home}; remove one"
            )
        try:
            found[entry.name], homes[entry.name] = entry.load(), home
        except (Exception, SystemExit) as error:
            raise InputError(
                f"{home} adds {entry.name!r} to hognose.{group}, but {entry.value} cannot be loaded: "
                f"{words_of(error)}; mend or uninstall that package"
            ) from error
    return found


def home(group: str, name: str) -> str:
    """The package that adds an entry; Hognose, if none does."""
    return next((_package(entry) for entry in entry_points(group=f"hognose.{group}", name=name)), "hognose")


def words_of(error: BaseException) -> str:
    """An error that code of others raised, in one line with its type; one whose text cannot be made is only named."""
    try:
        said = f"{type(error).__name__}: {error}"
    except Exception:
        said = type(error).__name__
    return plain(" ".join(said.split()))


def _package(entry: EntryPoint) -> str:
    return entry.dist.name if entry.dist else "a package without a name"


class Table(MutableMapping[str, Value]):
    """Entries of Hognose, and behind them those that other packages add to a group; by name.

    Other packages are looked for when the table is first read, not when it is made.

    Parameters
    ----------
    group
        As in `added`.
    own
        The entries of Hognose.
    fault
        Why the value that a package adds under a name is none of the table, as in "is not a path"; None if it is one.
    """

    def __init__(self, group: str, own: Mapping[str, Value], fault: Callable[[str, Any], str | None]) -> None:
        self._group, self._fault = group, fault
        self._entries, self._whole = dict(own), False

    def _read(self) -> dict[str, Value]:
        """All entries.

        Raises
        ------
        InputError
            As in `added`; also for an entry of a name that is taken, and for one that is none of the table.
        """
        if not self._whole:
            others = added(self._group)
            for name, value in others.items():
                if name in self._entries:
                    other = home(self._group, name)
                    raise InputError(
                        f"hognose.{self._group}: {name!r} is there already: hognose has one, and {other} adds another; "
                        f"{other} must give it another name"
                    )
                if fault := self._fault(name, value):
                    raise InputError(f"hognose.{self._group}: {name!r}, which {home(self._group, name)} adds, {fault}")
            self._entries = self._entries | others
            self._whole = True
        return self._entries

    def __getitem__(self, name: str) -> Value:
        return self._read()[name]

    def __setitem__(self, name: str, value: Value) -> None:
        """Add an entry, or replace one.

        Raises
        ------
        InputError
            The value is none of the table.
        """
        entries = self._read()
        if fault := self._fault(name, value):
            raise InputError(f"hognose.{self._group}: {name!r:.60} {fault}")
        entries[name] = value

    def __delitem__(self, name: str) -> None:
        del self._read()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._read())

    def __len__(self) -> int:
        return len(self._read())

    def __repr__(self) -> str:
        return repr(self._read())
