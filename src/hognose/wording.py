"""Figures as people read them: what is proven is never rounded to the better side.

A clearance of 4.9996 mm is not 5.0 mm. What is at least so much is rounded down, what is at most so much is rounded
up, and a figure beside its limit gets as many digits as it takes to see on which side of it it lies.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal

#: Digits of a figure beside its limit, and of any: no two different numbers look alike with so many.
FIGURES, ALL_FIGURES = 5, 17
#: Whole numbers below this are shown with all of their digits.
_WHOLE = 2.0**53


def at_least(value: float, places: int = 2) -> str:
    """A lower bound with so many decimal places, rounded down."""
    return _places(value, places, ROUND_FLOOR)


def at_most(value: float, places: int = 2) -> str:
    """An upper bound with so many decimal places, rounded up."""
    return _places(value, places, ROUND_CEILING)


def at_least_mm(length: float, places: int = 2) -> str:
    """A length (m) that is at least so many mm, rounded down."""
    return at_least(1e3 * length, places)


def mm(length: float, form: str = ".2f") -> str:
    """A length (m) in a sentence, by default to hundredths: `1.25 mm`."""
    return f"{1e3 * float(length):z{form}} mm"


def point(place: Iterable[float], form: str = ".1f") -> str:
    """A point (3,) m in a sentence, by default to tenths: `(1.0, -2.5, 0.0) mm`.

    `form` is the format of its coordinates in mm: `"g"` for a point that somebody wrote, `".0f"` for a rough place.
    """
    return f"({', '.join(f'{1e3 * float(c):z{form}}' for c in place)}) mm"


def span(values: Collection[float]) -> str:
    """From the least to the largest value, or the one that all are, in words."""
    low, high = min(values), max(values)
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def beside_limit(value: float, limit: float, lower_bound: bool) -> tuple[str, str]:
    """A figure and the limit it is held against.

    Parameters
    ----------
    value, limit
        In the same unit.
    lower_bound
        Whether the value must not fall below the limit, and is rounded down; else it must not exceed it, and is
        rounded up. The limit is rounded to the nearest.

    Returns
    -------
    value, limit
        With five digits, or as many more as it takes to show which of them is the larger; whole numbers with all.
    """
    shown, limited, value, limit = "", "", float(value), float(limit)
    for figures in range(FIGURES, ALL_FIGURES + 1):
        shown = _figures(value, figures, ROUND_FLOOR if lower_bound else ROUND_CEILING)
        limited = _figures(limit, figures, ROUND_HALF_EVEN)
        if _side(float(shown), float(limited)) == _side(value, limit):
            break
    return shown, limited


def _side(value: float, limit: float) -> int:
    """Whether a value is above (1), at (0) or below (-1) a limit; 2 where one of them is no number."""
    return 2 if math.isnan(value - limit) else (value > limit) - (value < limit)


def _places(value: float, places: int, rounding: str) -> str:
    if not math.isfinite(value) or abs(value) >= _WHOLE:
        return f"{value:g}"
    rounded = _decimal(value).quantize(Decimal(1).scaleb(-places), rounding)
    return f"{rounded if rounded else abs(rounded):f}"  # no -0.00


def _figures(value: float, figures: int, rounding: str) -> str:
    if not math.isfinite(value):
        return f"{value:g}"
    if value == int(value) and abs(value) < _WHOLE:
        return f"{int(value)}"
    return f"{float(Context(prec=figures, rounding=rounding).create_decimal(_decimal(value))):.{figures}g}"


def _decimal(value: float) -> Decimal:
    """The shortest number that reads as this one: 0.1 is not 0.1000000000000000055."""
    return Decimal(repr(float(value)))
