"""Figures beside what they must reach: printed at once, and kept for a page of the documentation."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class Section:
    """What was measured under one heading, as rows of a table: what, figure, limit."""

    heading: str
    rows: list[tuple[str, str, str]] = field(default_factory=list)


#: Everything printed in this run, in order.
_SECTIONS: list[Section] = []


def heading(text: str) -> None:
    """Print a heading; the figures that follow belong to it."""
    _SECTIONS.append(Section(text))
    print(f"\n{text}", flush=True)


def row(what: str, value: float, limit: float, unit: str, at_least: bool = False) -> None:
    """Print a figure beside what it must reach."""
    ok = value >= limit if at_least else value <= limit
    relation = ">=" if at_least else "<="
    print(f"  {'ok    ' if ok else 'MISSED'} {what:<62} {value:>10.3g} {relation} {limit:g} {unit}", flush=True)
    _keep(what, value, unit, f"{'≥' if at_least else '≤'} {limit:,g} {unit}".strip() + ("" if ok else ", **missed**"))


def aside(what: str, value: float, unit: str) -> None:
    """Print a figure that need not reach anything."""
    print(f"         {what:<62} {value:>10.3g} {unit}", flush=True)
    _keep(what, value, unit, "")


def as_markdown() -> str:
    """Everything printed so far as headings and tables."""
    return "\n\n".join(_table(section) for section in _SECTIONS if section.rows)


def _keep(what: str, value: float, unit: str, limit: str) -> None:
    if not _SECTIONS:
        _SECTIONS.append(Section("Figures"))
    unit, limit = ("×" if unit == "x" else unit), limit.replace(" x", " ×")
    figure = f"{value:.3g}" if value < 1000 else f"{value:,.0f}"
    _SECTIONS[-1].rows.append((what, f"{figure} {unit}".strip(), limit))


def _table(section: Section) -> str:
    title = section.heading[:1].upper() + section.heading[1:]
    lines = [f"### {title}", "", "| | measured | must be |", "|---|---:|---:|"]
    return "\n".join(lines + [f"| {' | '.join(cells)} |" for cells in section.rows])
