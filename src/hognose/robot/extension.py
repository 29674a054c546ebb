"""Sections that change their length: how far, and what is wrong with them beside the rest of an arm."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.arguments import floats
from hognose.errors import InputError
from hognose.robot.sections.kind import Geometry

Array = NDArray[np.float64]

#: Lengths of sections that keep theirs are given to this (m): rounding.
_SAME = 1e-9


def bounds_of(sections: Sequence[Geometry], rest: Array) -> Array:
    """How short and how long (n, 2) m sections get, of their lengths (n,) m at rest."""
    ranges = [section.length_range or (length, length) for section, length in zip(sections, rest, strict=True)]
    return np.array(ranges, dtype=np.float64)


def as_long(name: str, given: ArrayLike, leading: tuple[int, ...], rest: Array, bounds: Array) -> Array | None:
    """Lengths (..., n) m that are given of the sections of an arm, in rows (T, n); None if no section extends.

    Raises
    ------
    InputError
        They are not those of so many poses (...), one is 0 or less, or one of a section that does not extend is
        another than at rest.
    """
    lengths = floats("lengths", given, f"(..., {rest.size})", "m")
    if lengths.shape[:-1] != leading:
        raise InputError(f"lengths: expected shape {(*leading, rest.size)}, as of angles, got {lengths.shape}")
    fixed = bounds[:, 0] == bounds[:, 1]
    if not (lengths > 0.0).all() or (np.abs(lengths - rest)[..., fixed] > _SAME).any():
        raise InputError(
            f"lengths: sections of {name} are {', '.join(f'{x:g}' for x in rest.tolist())} m long at rest, those that "
            "do not extend always, and no length is 0 or less; `Robot.section_lengths` has those of joints"
        )
    return None if fixed.all() else lengths.reshape(-1, rest.size)


def fault_of_extension(
    groups: Sequence[Geometry],
    counts: Sequence[int],
    circles: Sequence[tuple[float | None, float]],
    tool_length: float,
) -> str:
    """What is wrong with the groups of sections that extend; empty if nothing is.

    Groups are from the base on: their geometry, the sections of each, and the radii (m) for cables that pass, if there
    are any, and of their own cables.
    """
    if tool_length > 0.0 and groups[-1].length_range is not None:
        return (
            f"section: the last section has a length_range, and the tool of {1e3 * tool_length:g} mm is rigid with it: "
            "make tool_length 0, and describe the tool as a last section of its own, of kind 'link'"
        )
    for k, section in enumerate(groups):
        if section.length_range is None or section.disks is None:
            continue
        before = _stepping(k, counts, circles)
        if before is not None:
            return (
                f"section: cables come to the disks of group {k + 1}, whose sections extend, from another circle, of "
                f"{1e3 * before:g} mm; how lengths and angles follow from such cables is not known. Make cable_radius "
                "and passing_cable_radius the same all the way, or leave out disks"
            )
    return ""


def _stepping(k: int, counts: Sequence[int], circles: Sequence[tuple[float | None, float]]) -> float | None:
    """A circle (m) from which cables come to a different one in a section of group k; None if they all keep theirs."""

    def of(owner: int, group: int, ends: bool = False) -> float:
        passing = circles[group][0]
        return circles[owner][1] if ends or passing is None else passing

    several = counts[k] > 1
    for owner in range(k, len(circles)):
        here = [of(owner, k, ends=True)] if owner == k else []
        here += [of(owner, k)] if owner > k or several else []
        before = [of(owner, k - 1)] if k > 0 else []
        before += [of(owner, k)] if several else []
        for circle in before:
            if any(circle != other for other in here):
                return circle
    return None
