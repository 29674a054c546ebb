"""Choosing bodies of a file by their names."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from fnmatch import fnmatchcase

from hognose.errors import InputError
from hognose.scene.imports.content import listed
from hognose.scene.imports.geometry import Geometry


def selected(geometry: Geometry, bodies: Sequence[str] | None, without: Sequence[str] | None) -> Geometry:
    """Return a geometry with the bodies that are asked for, less those that are asked to be left out.

    Parameters
    ----------
    geometry
    bodies, without
        Names, or patterns of them with `*`, `?` and `[…]`; None for all, and for none.

    Raises
    ------
    InputError
        A pattern fits no body, with the names there are; or nothing is left.
    """
    names = [body.name for body in geometry.bodies]
    kept = set(range(len(names))) if bodies is None else _fitting(geometry, bodies, "bodies")
    kept -= set() if without is None else _fitting(geometry, without, "without")
    if not kept:
        raise InputError(f"`bodies` and `without` leave none of its {len(names):,} bodies: {listed(names)}")
    if len(kept) == len(names):
        return geometry
    dropped = [name for k, name in enumerate(names) if k not in kept]
    note = f"{len(dropped):,} of {len(names):,} bodies left out, as asked: {listed(dropped)}"
    return geometry.only(sorted(kept), note)


def _fitting(geometry: Geometry, patterns: Sequence[str], key: str) -> set[int]:
    """The numbers of the bodies that fit one pattern or more; each must fit one.

    A name is a name first, of all bodies that the file calls so, and a pattern only if there is none of that name.
    """
    names = [body.name for body in geometry.bodies]
    found: set[int] = set()
    for pattern in patterns:
        fit = {k for k, body in enumerate(geometry.bodies) if pattern in (body.name, body.called)} or {
            k for k, name in enumerate(names) if fnmatchcase(name, pattern)
        }
        if not fit:
            raise InputError(_unknown(names, pattern, key))
        found |= fit
    return found


def _unknown(names: list[str], pattern: str, key: str) -> str:
    if not any(names):
        return f"`{key}`: there is no body {pattern!r}: the file has one body, without a name"
    folded = {name.casefold(): name for name in names}
    near = [folded[name] for name in difflib.get_close_matches(pattern.casefold(), list(folded), 3)]
    hint = f"; did you mean {' or '.join(map(repr, near))}?" if near else "."
    others = [name for name in names if name not in near]
    return f"`{key}`: there is no body {pattern!r}{hint} There are: {listed([*near, *others], 20)}"
