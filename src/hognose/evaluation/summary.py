"""Rows summed up into tables of texts: what the terminal and the pages show."""

from __future__ import annotations

import inspect
import itertools
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hognose.evaluation.measure import Row
from hognose.evaluation.shapes import PUBLISHED_KINDS
from hognose.evaluation.subjects import PUBLISHED, as_published, kind_of, method_of
from hognose.evaluation.suite import Results
from hognose.evaluation.targets import (
    PAPER_MS,
    PAPER_RMSE,
    PAPER_VARIANCE,
    PUBLISHED_DEVIATION,
    PUBLISHED_TIP,
    Target,
    lowered,
    mean_deviation,
    ratio,
    row_of,
)


@dataclass(frozen=True)
class Table:
    """Headings and rows of texts; the columns in `numbers` are set to the right."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numbers: tuple[int, ...] = ()


#: Figures of a row and their headings.
COLUMNS = {
    "time_us": "mean µs",
    "median_us": "median µs",
    "p95_us": "95 % µs",
    "worst_us": "worst µs",
    "evaluations": "distances",
    "tip_rmse_mm": "tip RMSE mm",
    "tip_variance_mm2": "tip VVE mm²",
    "body_max_mm": "body mm",
    "body_rms_mm": "body RMS mm",
    "link_error_mm": "link mm",
}
#: What is wrong with a row, as its `why` says it and as it is summed up.
_REASONS = (
    (r"left the tip ([\d.e+-]+) mm", "the tip stays up to {} mm from its goal"),
    (r"a link is off by ([\d.e+-]+) mm", "a link is off by up to {} mm"),
    (r"a joint bends by ([\d.e+-]+) rad", "a joint bends by up to {} rad"),
    (r"a joint is ([\d.e+-]+) mm from", "a joint is up to {} mm from where it belongs"),
    (r"an end is ([\d.e+-]+) mm off", "a section's end is up to {} mm off the path"),
    (r"the tip is ([\d.e+-]+) mm off", "the tip is up to {} mm off the path"),
    (r"()no posture within the bend limits", "no posture within the limits is found"),
    (r"()cannot reach the path", "a link does not reach the path"),
    (r"()has no posture that the method", "a section finds no posture"),
)


def number(value: float | None) -> str:
    """A figure as people read it: three digits, an exponent only for tiny ones, a dash for none."""
    if value is None:
        return "–"
    if value == 0.0 or 1e-4 <= abs(value) < 999.5:
        return f"{value:.3g}"
    return f"{value:,.0f}" if abs(value) >= 1.0 else f"{value:.0e}"


def percent(value: float | None) -> str:
    """Per cent, cut off and not rounded, so that only all of it reads 100."""
    return "–" if value is None else f"{math.floor(1e4 * value) / 1e4:.6g}"


def coverage(results: Results) -> Table:
    """Valid rows of all, by method and family; solved ones too where they are more."""
    rows = [
        (method, *(_share(results.of(family, method)) for family in results.families)) for method in results.methods
    ]
    return Table(("method", *results.families), tuple(rows), tuple(range(1, len(results.families) + 1)))


def _share(rows: Sequence[Row]) -> str:
    if not rows:
        return ""
    solved, valid = sum(row.solved for row in rows), sum(row.valid for row in rows)
    return f"{valid}/{len(rows)}" + (f" ({solved})" if solved > valid else "")


def family_table(results: Results, family: str, case: str | None = None) -> Table:
    """All figures by method, of one case or the largest of a family's cases."""
    rows = []
    for method in results.methods:
        found = results.of(family, method, case)
        if not found:
            continue
        counts = (f"{sum(row.solved for row in found)}/{len(found)}", f"{sum(row.valid for row in found)}/{len(found)}")
        rows.append((method, *(counts if case is None else ()), *(number(_largest(found, name)) for name in COLUMNS)))
    head = ("method", *(("solved", "valid") if case is None else ()), *COLUMNS.values())
    return Table(head, tuple(rows), tuple(range(1, len(head))))


def _largest(rows: Sequence[Row], name: str) -> float | None:
    values = [getattr(row, name) for row in rows]
    return max((value for value in values if value is not None), default=None)


def targets_table(targets: Sequence[Target]) -> Table:
    """Targets with what was measured, what must be, and the verdict."""
    rows = [
        (
            target.name,
            f"{percent(target.value) if target.unit == '%' else number(target.value)} {target.unit}",
            f"{'≥' if target.at_least else '≤'} {target.limit:g} {target.unit}",
            target.verdict,
        )
        for target in targets
    ]
    return Table(("target", "measured", "must be", "verdict"), tuple(rows), (1, 2))


def times_beside_paper(results: Results) -> Table:
    """The paper's table 2 and ours, each with its ratios to prediction lookup."""
    rows = []
    for method, paper in PAPER_MS.items():
        published = as_published(method) if method in PUBLISHED else method
        cells = [method, f"{paper:g}", number(paper / PAPER_MS["prediction"])]
        for label in (published, method):
            cells += [number(results.raced("pipe-tank", label)), number(ratio(results, label, "prediction"))]
        rows.append(tuple(cells))
    head = ("method", "paper ms", "ratio", "published µs", "ratio", "tuned µs", "ratio")
    return Table(head, tuple(rows), tuple(range(1, len(head))))


def errors_beside_paper(results: Results) -> Table:
    """The paper's table 3 and ours."""
    rows = []
    for name, figure, paper in (
        ("RMSE (mm)", "tip_rmse_mm", PAPER_RMSE),
        ("VVE (mm²)", "tip_variance_mm2", PAPER_VARIANCE),
    ):
        pair = [row_of(results, "pipe-tank", method) for method in ("prediction", "interpolation")]
        ours = [getattr(row, figure) if row is not None else None for row in pair]
        less = lowered(results, figure)
        rows.append(
            (
                name,
                *(f"{value:g}" for value in paper),
                f"{math.floor(100.0 * (1.0 - paper[1] / paper[0]))} %",  # cut off, as in the paper
                *(number(value) for value in ours),
                f"{percent(less)} %",
            )
        )
    head = ("", "paper, without", "paper, with", "reduction", "ours, without", "ours, with", "reduction")
    return Table(head, tuple(rows), tuple(range(1, len(head))))


def shapes_beside_published(results: Results) -> Table:
    """Deviations of the drawn shapes by method and kind, with the published figures in the last row."""
    rows = []
    for method in results.methods:
        found = results.of("shapes", method)
        for kind in PUBLISHED_KINDS if found else ():
            some = [row for row in found if row.case.startswith(f"{kind} ")]
            means = (percent(mean_deviation(some, wholly_in)) for wholly_in in (True, False))
            valid = f"{sum(row.valid for row in some)}/{len(some)}"
            rows.append((method, kind, valid, *means, number(_largest(some, "tip_max_mm"))))
    if rows:
        rows.append(("published", "S, C, robot", "–", f"{PUBLISHED_DEVIATION:g}", "–", f"{PUBLISHED_TIP:g}"))
    head = ("method", "shapes", "valid", "wholly in %", "all the way in %", "tip mm")
    return Table(head, tuple(rows), (2, 3, 4, 5))


def failures(results: Results) -> Table:
    """Where methods stop working, and why, one line a method and reason."""
    groups: dict[tuple[str, str], tuple[list[Row], float]] = {}
    for row in results.rows:
        for reason, value in _reasons(row):
            rows, largest = groups.get((row.method, reason), ([], 0.0))
            groups[row.method, reason] = ([*rows, row], max(largest, value))
    order = {method: place for place, method in enumerate(results.methods)}
    lines = [
        (method, reason.format(number(largest)), _places(results, method, rows))
        for (method, reason), (rows, largest) in sorted(groups.items(), key=lambda item: order[item[0][0]])
    ]
    return Table(("method", "why", "where"), tuple(lines))


def _reasons(row: Row) -> list[tuple[str, float]]:
    if row.valid:
        return []
    found = [(text, re.search(pattern, row.why)) for pattern, text in _REASONS]
    matched = [(text, float(match[1] or 0.0)) for text, match in found if match]
    short = row.why if len(row.why) <= 90 else f"{row.why[:90]}…"
    return matched or [(short.replace("{", "(").replace("}", ")"), 0.0)]


def _places(results: Results, method: str, rows: Sequence[Row]) -> str:
    """Families, each with its cases unless all of them are meant."""
    words = []
    for family in dict.fromkeys(row.family for row in rows):
        cases = [row.case for row in rows if row.family == family]
        all_of_them = len(cases) == len(results.of(family, method))
        words.append(family if all_of_them else f"{family} ({', '.join(cases)})")
    return "; ".join(words)


def spacings_like(results: Results, rmse_mm: float, method: str = "prediction") -> list[Row]:
    """The two neighbours in spacing between which a method's tip RMSE first passes a value, or none."""
    rows = sorted(results.of("spacing", method), key=lambda row: row.spacing_mm)
    rows = [row for row in rows if row.tip_rmse_mm is not None]
    for low, high in itertools.pairwise(rows):
        if (low.tip_rmse_mm or 0.0) < rmse_mm <= (high.tip_rmse_mm or np.inf):
            return [low, high]
    return []


def followed_in_part(results: Results) -> list[str]:
    """Sentences about methods of which only the last steps of some cases were followed."""
    words = []
    for method in results.methods:
        rows = [row for row in results.rows if row.method == method and row.solved and row.steps < row.all_steps]
        if rows:
            cases = ", ".join(f"{row.steps} of {row.all_steps} on {row.family} {row.case}" for row in rows[:3])
            words.append(f"{method}: {cases}" + (f", and {len(rows) - 3} more" if len(rows) > 3 else ""))
    return words


def origin(label: str) -> str:
    """What a method's docstring says first; of a published variant, what it says of `as_published`."""
    lines = (inspect.getdoc(kind_of(label)) or "").splitlines()
    if label == method_of(label):
        return lines[0]
    place = next((i for i, line in enumerate(lines) if line.startswith("as_published")), -1)
    said = itertools.takewhile(lambda line: line.startswith(" "), lines[place + 1 :])
    return " ".join(line.strip() for line in said)


def weakness(label: str) -> str:
    """The known weakness of a method, as the docstring of its module says it; empty if it does not."""
    said = inspect.getdoc(inspect.getmodule(kind_of(label))) or ""
    found = re.search(r"weakness: (.+?)(?:\n\n|\Z)", said, re.DOTALL)
    return found[1].replace("\n", " ") if found else ""
