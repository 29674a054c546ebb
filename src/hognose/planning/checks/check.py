"""One verdict on a plan."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Any

from pydantic import TypeAdapter

from hognose.wording import beside_limit

_DEGREES = 180.0 / math.pi
#: SI units, and what people read instead: how many of which unit. Other units are read as they are.
_AS_READ = {
    "m": (1e3, "mm"),
    "m/s": (1e3, "mm/s"),
    "m/s²": (1e3, "mm/s²"),
    "m/s³": (1e3, "mm/s³"),
    "rad": (_DEGREES, "deg"),
    "rad/s": (_DEGREES, "deg/s"),
    "rad/s²": (_DEGREES, "deg/s²"),
    "1": (1.0, ""),
}
#: Digits that a change of the unit leaves alone.
_DIGITS = 15
#: A figure as close to its limit as this, in parts of it, passes as the limit itself: criteria allow for rounding.
_ALIKE, _ALIKE_DIGITS = 1e-9, 9


@dataclass(frozen=True)
class Check:
    """One verdict: a figure, its limit, and the place that comes closest to it.

    Attributes
    ----------
    key
        Of the criterion, as `bend_limits`; the same in every version.
    name
        The criterion as people read it.
    ok
        Whether it passed; None if it was not judged, because the plan lacks what it takes. Then `detail` says what.
    value, limit
        In the unit below; the value must not exceed the limit, or, where `at_least` is set, must not fall below it.
        Both are NaN where there is no figure.
    unit
        An SI unit: m, rad, s, m/s, rad/s, rad/s², N, counts, or 1.
    step
        Row of the plan of the worst case, or None where that has no meaning.
    section, link, cable
        The worst case's, counted from 1, or None.
    obstacle
        Name of the obstacle that the worst case is about, or None.
    at_least
        Whether the limit is a lower one.
    detail
        The worst case in words.
    is_bound
        Whether the value was not measured, but is known to be at least so much, as a clearance beyond the horizon; only
        where the limit is a lower one.
    """

    key: str
    name: str
    ok: bool | None
    value: float
    limit: float
    unit: str
    step: int | None = None
    section: int | None = None
    link: int | None = None
    cable: int | None = None
    obstacle: str | None = None
    at_least: bool = False
    detail: str = ""
    is_bound: bool = False

    @property
    def judged(self) -> bool:
        """Whether it passed or failed; a check that was not judged did neither."""
        return self.ok is not None

    @property
    def failed(self) -> bool:
        """Whether it was judged and did not pass."""
        return self.ok is not None and not self.ok

    @property
    def verdict(self) -> str:
        """The verdict in words: passed, failed or not judged."""
        return "not judged" if self.ok is None else "passed" if self.ok else "failed"

    @property
    def has_figures(self) -> bool:
        """Whether there are a value and a limit."""
        return not (math.isnan(self.value) and math.isnan(self.limit))

    @property
    def figures(self) -> tuple[str, str]:
        """Value and limit as people read them: in mm and degrees, the value rounded to the worse side.

        They are apart if they are apart, but for a value that passes within a billionth of its limit; empty if there
        are none.
        """
        value, limit = self._numbers
        return f"{self._bound}{_with_unit(value, self.unit)}", _with_unit(limit, self.unit)

    @property
    def relation(self) -> str:
        """How the value must lie to the limit; no clearance of zero is enough, even where none is asked for."""
        return "≤" if not self.at_least else ">" if self.limit == 0 else "≥"

    @property
    def figures_agree(self) -> bool:
        """Whether the value lies to the limit as it must, or there are no figures; more than figures may decide."""
        return not self.has_figures or self._keeps_limit or self._alike

    @property
    def comparison(self) -> str:
        """Value and limit side by side, `10.351 ≤ 28.648 deg`, with `!≤` if it failed by them; empty without.

        What is only known to be at least so much is a chain: `≥ 50 ≥ 5 mm`.
        """
        if not self.has_figures:
            return ""
        relation = f"{'' if self.ok or self._keeps_limit else '!'}{self.relation}"
        but = ", but failed" if self.failed and self._keeps_limit else ""
        return f"{self._bound}{self._numbers[0]} {relation} {self.figures[1]}{but}"

    @property
    def place(self) -> tuple[str, ...]:
        """Where the worst case is, in words: step, section, cable."""
        named = (("step", self.step), ("section", self.section), ("cable", self.cable))
        return tuple(f"{word} {number}" for word, number in named if number is not None)

    @property
    def sentence(self) -> str:
        """The verdict in words: what, how much, where."""
        place = f" at {', '.join(self.place)}" if self.place else ""
        value, limit = self.figures
        said = f"{value} {self._verb} {limit}" if self.judged and self.has_figures else self.verdict
        text = f"{self.name}: {said}{place}"
        return f"{text} ({self.detail})" if self.detail else text

    @property
    def _numbers(self) -> tuple[str, str]:
        """Value and limit in the unit that people read."""
        if not self.has_figures:
            return "", ""
        if self._alike and (self.ok or self._keeps_limit):
            both = float(f"{_converted(self.limit, self.unit):.{_ALIKE_DIGITS}g}")
            return beside_limit(both, both, self.at_least)
        value, limit = _converted(self.value, self.unit), _converted(self.limit, self.unit)
        if (value < limit, value > limit) != (self.value < self.limit, self.value > self.limit):
            factor = _AS_READ[self.unit][0]  # so close that rounding took their order away
            value, limit = factor * self.value, factor * self.limit
        return beside_limit(value, limit, self.at_least)

    @property
    def _bound(self) -> str:
        """What stands before a value that is only known to be at least so much."""
        return "≥ " if self.is_bound and self.at_least and self.has_figures else ""

    @property
    def _verb(self) -> str:
        if self.failed and self._keeps_limit:
            return "fails, though at least" if self.at_least else "fails, though within"
        if self._bound:
            unproven = "not proven to be above" if self.limit == 0 else "not proven to be at least"
            return "and thus at least" if self.ok else unproven
        if self.at_least:
            return "is at least" if self.ok else "is below" if self.value < self.limit else "is not above"
        return "is within" if self.ok else "exceeds"

    @property
    def _keeps_limit(self) -> bool:
        """Whether the value lies to the limit as `relation` says; what is no number does not."""
        if not self.at_least:
            return self.value <= self.limit
        return self.value >= self.limit and not self.value == self.limit == 0

    @property
    def _alike(self) -> bool:
        """Whether the value is so close to the limit that only rounding tells them apart; whole numbers never are."""
        value, limit = self.value, self.limit
        if not (math.isfinite(value) and math.isfinite(limit)) or (value == int(value) and limit == int(limit)):
            return False
        return abs(value - limit) <= _ALIKE * abs(limit)


def good(checks: Iterable[Check]) -> bool:
    """Whether there are verdicts and none is a failure; checks that were not judged count for nothing."""
    judged = [check for check in checks if check.judged]
    return bool(judged) and not any(check.failed for check in judged)


def faults(checks: Iterable[Check]) -> list[Check]:
    """Why a plan with these checks is not good: those that failed, or all if none was judged; none if it is good."""
    checks = list(checks)
    if not any(check.judged for check in checks):
        return checks
    return [check for check in checks if check.failed]


def tally(checks: Iterable[Check]) -> str:
    """How many of some checks passed or failed, and how many were not judged, in words."""
    checks = list(checks)
    judged, failed = (sum(getattr(check, name) for check in checks) for name in ("judged", "failed"))
    left = len(checks) - judged
    if not judged:
        return f"none of {left} checks was judged" if left > 1 else "nothing was judged"
    said = f"{failed} of {judged} checks failed" if failed else f"all {judged} checks passed"
    return f"{said}, {left} {'was' if left == 1 else 'were'} not judged" if left else said


def to_json(check: Check) -> dict[str, Any]:
    """The fields of a check for JSON, in which what is no finite number is null."""
    said = {field.name: getattr(check, field.name) for field in fields(Check)}
    return {name: None if isinstance(v, float) and not math.isfinite(v) else v for name, v in said.items()}


def from_json(said: Iterable[dict[str, Any]]) -> tuple[Check, ...]:
    """The checks of which `to_json` made these; those of versions that knew no keys have empty ones.

    Raises
    ------
    pydantic.ValidationError
        A field is missing, or of another type.
    """
    entries = [{"key": "", **each} for each in said]
    for each in entries:
        each |= {name: math.nan for name in ("value", "limit") if name in each and each[name] is None}
    return _CHECKS.validate_python(entries)


_CHECKS = TypeAdapter(tuple[Check, ...])


def _converted(value: float, unit: str) -> float:
    """A figure in the unit that people read."""
    factor = _AS_READ.get(unit, (1.0, unit))[0]
    return value if factor == 1.0 or not math.isfinite(value) else float(f"{factor * value:.{_DIGITS}g}")


def _with_unit(figure: str, unit: str) -> str:
    read = _AS_READ.get(unit, (1.0, unit))[1]
    return f"{figure} {read}" if figure and read else figure
