"""One verdict on a plan."""

from __future__ import annotations

from dataclasses import dataclass

from hognose.wording import beside_limit


@dataclass(frozen=True)
class Check:
    """One verdict: a figure, its limit, and the step and section that come closest to it.

    Attributes
    ----------
    value, limit
        In `unit`, as people read them. The value must not exceed the limit, or, where `at_least` is set,
        must not fall below it.
    step, section
        Row of the plan and section (1-based) of the worst case, or None where that has no meaning.
    detail
        The worst case in words.
    """

    name: str
    ok: bool
    value: float
    limit: float
    unit: str
    step: int | None = None
    section: int | None = None
    at_least: bool = False
    detail: str = ""

    @property
    def figures(self) -> tuple[str, str]:
        """Value and limit as people read them: the value rounded to the worse side, and apart if they are apart."""
        return beside_limit(self.value, self.limit, self.at_least)

    @property
    def relation(self) -> str:
        """How the value must lie to the limit; no clearance of zero is enough, even where none is asked for."""
        return "≤" if not self.at_least else "≥" if self.limit > 0 else ">"

    @property
    def sentence(self) -> str:
        """The verdict in words: what, how much, where."""
        where = [f"step {self.step}"] if self.step is not None else []
        where += [f"section {self.section}"] if self.section is not None else []
        place = f" at {', '.join(where)}" if where else ""
        value, limit = (f"{figure} {self.unit}" for figure in self.figures)
        text = f"{self.name}: {value} {self._verb} {limit}{place}"
        return f"{text} ({self.detail})" if self.detail else text

    @property
    def _verb(self) -> str:
        if self.at_least:
            return "is at least" if self.ok else "is below" if self.value < self.limit else "is not above"
        return "is within" if self.ok else "exceeds" if not self.value <= self.limit else "fails, though within"


def good(checks: tuple[Check, ...]) -> bool:
    """Whether every check was made and passed."""
    return bool(checks) and all(check.ok for check in checks)
