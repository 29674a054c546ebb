"""The table of the routes benchmark, from its rows."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from hognose.wording import at_least

#: One space: see `benchmarks.routes.measured`.
Row = dict[str, Any]
#: A route that has this part of the planted clearance is as good as the known one.
AS_GOOD = 0.9


def printed(rows: Iterable[Row]) -> str:
    """A table a family and in total, for each of the settings among the rows."""

    def settings(row: Row) -> str:
        return json.dumps(row["settings"], sort_keys=True)

    groups = itertools.groupby(sorted(rows, key=settings), settings)
    return "\n\n".join(_table(json.loads(key), _latest(group)) for key, group in groups)


def _latest(rows: Iterable[Row]) -> list[Row]:
    """One row a space: two runs side by side may both have done one."""
    return list({(row["family"], row["seed"]): row for row in rows}.values())


def _table(settings: dict[str, Any], rows: list[Row]) -> str:
    families = list(dict.fromkeys(row["family"] for row in rows))
    groups = {family: [row for row in rows if row["family"] == family] for family in families}
    if len(families) > 1:
        groups["total"] = rows
    columns = _columns(settings)
    lines = [["family", *columns]]
    lines += [[name, *(figure(group) for figure in columns.values())] for name, group in groups.items()]
    return "\n".join([_title(settings), "", aligned(lines)])


def aligned(lines: list[list[str]]) -> str:
    """A table in Markdown; the first line is its head."""
    widths = [max(len(line[k]) for line in lines) for k in range(len(lines[0]))]
    ruled = [lines[0], ["-" * width for width in widths], *lines[1:]]
    return "\n".join("| " + " | ".join(c.ljust(n) for c, n in zip(line, widths, strict=True)) + " |" for line in ruled)


def _title(settings: dict[str, Any]) -> str:
    return (
        f"{settings['robot']}, {settings['planted']:g} mm planted, {settings['margin']:g} mm asked for, "
        f"{settings['seconds']:g} s each, {settings['patience']:g} s while nothing is found"
    )


def _columns(settings: dict[str, Any]) -> dict[str, Callable[[list[Row]], str]]:
    """What is said of a group of rows, under which heading."""
    seconds, planted = settings["seconds"], settings["planted"]

    def solved(rows: list[Row], within: float) -> str:
        return str(sum(row["first"] is not None and row["first"] <= within for row in rows))

    def as_good(rows: list[Row]) -> str:
        return str(sum(row["certified"] >= AS_GOOD * planted for row in rows if row["certified"] is not None))

    columns: dict[str, Callable[[list[Row]], str]] = {
        "spaces": lambda rows: str(len(rows)),
        f"solved in {seconds:g} s": lambda rows: solved(rows, seconds),
        f"in {settings['patience']:g} s": lambda rows: solved(rows, np.inf),
        "first route, median / 95 % (s)": lambda rows: _times(_known(rows, "first")),
        "best route, median / 95 % (s)": lambda rows: _times(_known(rows, "best")),
        "certified, median / worst (mm)": lambda rows: _proven(_known(rows, "certified")),
        f"≥ {AS_GOOD:.0%} of planted": as_good,
    }
    if settings["coal"]:
        columns["smallest by Coal (mm)"] = _smallest_by_coal
    if settings["ompl"]:
        columns["RRTConnect solved"] = lambda rows: str(len(_attempts(rows, "path")))
        columns["its median time (s)"] = lambda rows: _median([tried["seconds"] for tried in _attempts(rows, "path")])
        columns["no goal found"] = lambda rows: str(len(_attempts(rows, "no goal")))
        columns["no path found"] = lambda rows: str(len(_attempts(rows, "no path")))
    return columns


def _known(rows: list[Row], name: str) -> list[float]:
    return [row[name] for row in rows if row[name] is not None]


def _attempts(rows: list[Row], ended: str) -> list[dict[str, Any]]:
    return [row["ompl"] for row in rows if row["ompl"]["ended"] == ended]


def _smallest_by_coal(rows: list[Row]) -> str:
    found = [row["by_coal"]["smallest"] for row in rows if row["by_coal"] is not None]
    if not found:
        return ""
    return f"{min(found):.3f}" if min(found) > 0 else f"COLLISION {min(found):.3f}"


def _median(values: list[float]) -> str:
    return f"{np.median(values):.2f}" if values else ""


def _times(values: list[float]) -> str:
    return f"{np.median(values):.2f} / {np.percentile(values, 95):.2f}" if values else ""


def _proven(values: list[float]) -> str:
    return f"{at_least(float(np.median(values)))} / {at_least(min(values))}" if values else ""
