"""Figures printed beside what they must reach."""

from __future__ import annotations


def row(what: str, value: float, limit: float, unit: str, at_least: bool = False) -> None:
    """Print a figure beside what it must reach."""
    ok = value >= limit if at_least else value <= limit
    relation = ">=" if at_least else "<="
    print(f"  {'ok    ' if ok else 'MISSED'} {what:<62} {value:>10.3g} {relation} {limit:g} {unit}", flush=True)


def aside(what: str, value: float, unit: str) -> None:
    """Print a figure that need not reach anything."""
    print(f"         {what:<62} {value:>10.3g} {unit}", flush=True)
