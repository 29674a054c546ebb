"""The table of all checks, made from the list that plans are judged by, so that it cannot fall behind."""

from __future__ import annotations

from hognose.planning.checks import ALL


def checks_table() -> str:
    """Markdown with a row for each criterion."""
    rows = [f"| `{each.key}` | {each.name} | {each.unit} | {each.says} |" for each in ALL]
    return "\n".join(["## All checks", "", "| key | name | unit | what must hold |", "|---|---|---|---|", *rows, ""])
