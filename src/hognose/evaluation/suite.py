"""Run the suite: one row a method and case, kept on disk after each, so that it can be interrupted and resumed."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from hognose.errors import InfeasibleError, InputError
from hognose.evaluation.families import Case, suite_of_cases
from hognose.evaluation.machine import machine
from hognose.evaluation.measure import Row, measured
from hognose.evaluation.subjects import takes_part
from hognose.evaluation.timing import race
from hognose.planning.storage import write_whole
from hognose.version import __version__

#: Seconds a row, roughly: the quick suite and the full one.
_BUDGETS = {True: 0.1, False: 0.6}
_SERIES = ("tip_series_mm", "time_series_us")


@dataclass(frozen=True)
class Results:
    """What a suite found.

    Attributes
    ----------
    fingerprint
        Version, seed and size of the suite; only equal ones are resumed.
    machine
        Processor, Python and libraries.
    rows
    races
        Microseconds a step by case and method, all methods taken in turn.
    """

    fingerprint: dict[str, Any]
    machine: dict[str, str]
    rows: tuple[Row, ...] = ()
    races: dict[str, dict[str, float]] | None = None

    def of(self, family: str, method: str | None = None, case: str | None = None) -> list[Row]:
        """Rows of a family, of one method and one case if given."""
        return [
            row
            for row in self.rows
            if row.family == family and method in (None, row.method) and case in (None, row.case)
        ]

    def raced(self, case: str, method: str) -> float | None:
        """Microseconds a step in the race on a case, or None."""
        return (self.races or {}).get(case, {}).get(method)


def run_suite(
    folder: Path,
    labels: Sequence[str],
    seed: int = 1,
    quick: bool = False,
    progress: Callable[[int, int], None] = lambda done, total: None,
    cases: Sequence[Case] | None = None,
) -> Results:
    """Measure every label on every case and write `results.json` and `results.csv` into a folder.

    Rows that stand in the folder's `results.json` are kept, if they are of the same version, seed and size.
    """
    fingerprint = {"version": __version__, "seed": seed, "quick": quick}
    chosen = suite_of_cases(seed, quick) if cases is None else list(cases)
    kept = _kept(folder / "results.json", fingerprint)
    rows = {(row.method, row.family, row.case): row for row in kept.rows} if kept else {}
    races = dict(kept.races or {}) if kept else {}
    todo = [(label, case) for case in chosen for label in labels if takes_part(label, case.family)]
    raced = [case for case in chosen if case.family == "cases"]
    total = len(todo) + len(raced)
    for done, (label, case) in enumerate(todo):
        progress(done, total)
        key = (label, case.family, case.name)
        if key not in rows:
            rows[key] = measured(label, case, _BUDGETS[quick])
            _write(folder, Results(fingerprint, machine(), tuple(rows.values()), races))
    for done, case in enumerate(raced, len(todo)):
        progress(done, total)
        able = [label for label in labels if rows[label, case.family, case.name].solved]
        if not set(able) <= set(races.get(case.name, {})):
            try:
                races[case.name] = {k: 1e6 * s for k, s in race(able, case, _BUDGETS[quick]).items()}
            except InfeasibleError:
                races[case.name] = {}
            _write(folder, Results(fingerprint, machine(), tuple(rows.values()), races))
    progress(total, total)
    wanted = {(label, case.family, case.name) for label, case in todo}
    results = Results(fingerprint, machine(), tuple(row for key, row in rows.items() if key in wanted), races)
    write_whole(folder / "results.csv", as_csv(results.rows).encode())
    return results


def as_csv(rows: Sequence[Row]) -> str:
    """The rows as a table, without the series."""
    names = [field.name for field in fields(Row) if field.name not in _SERIES]
    text = io.StringIO()
    writer = csv.DictWriter(text, names, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(asdict(row) for row in rows)
    return text.getvalue()


def _write(folder: Path, results: Results) -> None:
    write_whole(folder / "results.json", (json.dumps(asdict(results), indent=1) + "\n").encode())


def _kept(file: Path, fingerprint: dict[str, Any]) -> Results | None:
    if not file.exists():
        return None
    try:
        found = json.loads(file.read_text())
        if found["fingerprint"] != fingerprint:
            return None
        rows = tuple(Row(**{**row, **{name: tuple(row[name]) for name in _SERIES}}) for row in found["rows"])
        return Results(found["fingerprint"], found["machine"], rows, found["races"])
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"{file}: is not what an earlier run has written ({type(error).__name__}); "
            "remove it, or name another folder"
        ) from None
