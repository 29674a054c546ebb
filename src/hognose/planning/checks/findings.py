"""What criteria find: verdicts without key, name and unit, which the criterion adds."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, TypedDict, Unpack

import numpy as np
from numpy.typing import NDArray

from hognose.planning.checks.check import Check
from hognose.planning.thresholds import COLUMN_TOLERANCE
from hognose.ties import first_largest

Array = NDArray[np.float64]


class Place(TypedDict, total=False):
    """Where the worst case is, counted from 0 as in arrays, and in words.

    A link's section and a cable's section need not be said.
    """

    step: Any
    section: Any
    link: Any
    cable: Any
    obstacle: str | None
    detail: str


def most(value: Any, limit: Any, ok: bool | None = None, **place: Unpack[Place]) -> Check:
    """A value that must not exceed its limit, both in the criterion's unit; what is no number fails.

    `ok` is the verdict where more than the two numbers decides.
    """
    return _found(bool(value <= limit) if ok is None else ok, value, limit, place)


def least(value: Any, limit: Any, is_bound: bool = False, **place: Unpack[Place]) -> Check:
    """A value, such as a clearance, that must not fall below its limit and must be above zero.

    `is_bound` says that it was not measured, but is known to be at least so much.
    """
    found = _found(bool(value >= limit and value > 0), value, limit, place, at_least=True)
    return replace(found, is_bound=bool(is_bound))


def agrees(off: Array) -> Check:
    """Figures (m) that follow from others; `off` is how far they are from what follows."""
    return most(off.max(), COLUMN_TOLERANCE)


def peak(values: Array, limit: float, axis: str | None = None, detail: str = "") -> Check:
    """The largest of values (T, k), which must not exceed a limit; `axis` says that k counts `section` or `cable`.

    `detail` adds words.
    """
    if not values.size:
        return most(0.0, limit)
    step, index = first_largest(values)
    place: Place = {"step": step, "detail": detail}
    if axis == "section":
        place["section"] = index
    elif axis == "cable":
        place["cable"] = index
    return most(values[step, index], limit, **place)


def within(values: NDArray[Any], limits: tuple[float, float]) -> Check:
    """Values (T, c) of cables that must stay between limits (low, high); the one that comes closest to its own."""
    low, high = np.array(limits)
    used = np.maximum(values / high, values / low)
    step, cable = first_largest(used)
    out = bool(values[step, cable] >= 0)
    value, limit = (values[step, cable], high) if out else (-values[step, cable], -low)
    detail = "paid out" if out else "pulled in"
    return most(value, limit, bool(used[step, cable] <= 1), step=step, cable=cable, detail=detail)


def not_judged(reason: str) -> Check:
    """No verdict, because the plan lacks what it takes; the reason says what."""
    return Check("", "", None, math.nan, math.nan, "", detail=reason)


def informative(said: str, **place: Unpack[Place]) -> Check:
    """A verdict that always passes, for what people should know; it has no figure."""
    return _found(True, math.nan, math.nan, {**place, "detail": said})


def failure(reason: str) -> Check:
    """A failure without a figure."""
    return Check("", "", False, math.nan, math.nan, "", detail=reason)


def _found(ok: bool, value: Any, limit: Any, place: Place, at_least: bool = False) -> Check:
    step, words = place.get("step"), {"obstacle": place.get("obstacle"), "detail": place.get("detail", "")}
    section, link, cable = (_from_one(place.get(name)) for name in ("section", "link", "cable"))
    where = (None if step is None else int(step), section, link, cable)
    return Check("", "", bool(ok), float(value), float(limit), "", *where, at_least=at_least, **words)


def _from_one(index: Any) -> int | None:
    return None if index is None else int(index) + 1
