"""Run the suite: one row a method and case, kept on disk, so that it can be interrupted and resumed."""

from __future__ import annotations

import csv
import io
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from hognose.errors import InputError
from hognose.evaluation.case import Case
from hognose.evaluation.families import confirm, suite_of_cases
from hognose.evaluation.machine import machine, measured_version
from hognose.evaluation.measure import Row, measured
from hognose.evaluation.subjects import subjects_of, takes_part
from hognose.evaluation.timing import race
from hognose.read_whole import read_whole
from hognose.write_whole import write_whole

#: Seconds a row for timing, and of patience with a slow method, of the quick suite and of the full one.
_BUDGETS = {True: (0.02, 0.2), False: (0.3, 10.0)}
#: Rows are on disk this often, s, and whenever the suite ends, however it does.
_SAVE_EVERY = 2.0
# No results are larger (bytes).
_LARGEST_FILE = 1_000_000_000
#: Columns of a row that hold a figure a step; they are in the JSON only.
SERIES = ("tip_series_mm", "body_series_mm", "time_series_us")


@dataclass(frozen=True)
class Results:
    """What a suite found.

    Attributes
    ----------
    version, seed, quick
        What was run; only the same is resumed.
    machine
        Processor, Python and libraries; rows of another machine are not mixed in.
    rows
        One a method and case, in the suite's order.
    races
        Microseconds a step by case and method, all methods taken in turn.
    """

    version: str
    seed: int
    quick: bool
    machine: dict[str, str]
    rows: tuple[Row, ...] = ()
    races: dict[str, dict[str, float]] = field(default_factory=dict)

    @property
    def methods(self) -> list[str]:
        """Labels of the methods that have rows, in the order of all methods."""
        found = {row.method for row in self.rows}
        return [label for label in subjects_of() if label in found]

    @property
    def families(self) -> list[str]:
        """The families that have rows, in their order."""
        return list(dict.fromkeys(row.family for row in self.rows))

    def of(self, family: str, method: str | None = None, case: str | None = None) -> list[Row]:
        """Rows of a family, of one method and one case if given."""
        return [
            row
            for row in self.rows
            if row.family == family and method in (None, row.method) and case in (None, row.case)
        ]

    def raced(self, case: str, method: str) -> float | None:
        """Microseconds a step in the race on a case, or None."""
        return self.races.get(case, {}).get(method)


def run_suite(
    folder: Path,
    labels: Sequence[str],
    seed: int = 1,
    quick: bool = False,
    progress: Callable[[int, int], None] = lambda done, total: None,
    cases: Sequence[Case] | None = None,
    fresh: bool = False,
) -> Results:
    """Measure every label on every case and write `results.json` and `results.csv` into a folder.

    Parameters
    ----------
    folder
        Rows that stand in its `results.json` are kept and not measured again.
    labels
        Of `hognose.evaluation.subjects.subjects_of`.
    seed, quick
        Which suite: `suite_of_cases(seed, quick)`, unless `cases` are given.
    progress
        Called with the number of rows done and of all. What it raises ends the suite; finished rows are on disk.
    fresh
        Do not look at what stands in the folder.

    Raises
    ------
    InputError
        `results.json` is damaged, or of another version, seed, size or machine; or cannot be written.
    InfeasibleError
        A case that has no solution: then the suite is wrong.
    """
    empty = Results(measured_version(), seed, quick, machine())
    file = folder / "results.json"
    kept = empty if fresh or not file.exists() else _loaded(file, empty)
    chosen = suite_of_cases(seed, quick) if cases is None else list(cases)
    run = _Run(empty, chosen, {(row.method, row.family, row.case): row for row in kept.rows}, dict(kept.races))
    todo = [(label, case) for case in chosen for label in labels if takes_part(label, case.family)]
    raced = [case for case in chosen if case.family == "cases"]
    saved = time.monotonic()
    try:
        for done, (label, case) in enumerate(todo):
            progress(done, len(todo) + len(raced))
            run.measure(label, case)
            if time.monotonic() - saved > _SAVE_EVERY:
                _save(folder, run.results)
                saved = time.monotonic()
        for done, case in enumerate(raced, len(todo)):
            progress(done, len(todo) + len(raced))
            run.race(case)
        progress(len(todo) + len(raced), len(todo) + len(raced))
    finally:
        _save(folder, run.results)
    return run.results


@dataclass
class _Run:
    """A suite going on: what is there already, by method, family and case."""

    empty: Results
    cases: list[Case]
    rows: dict[tuple[str, str, str], Row]
    races: dict[str, dict[str, float]]
    confirmed: list[Case] = field(default_factory=list)

    def measure(self, label: str, case: Case) -> None:
        key = (label, case.family, case.name)
        if key not in self.rows:
            if case not in self.confirmed:
                confirm(case)
                self.confirmed.append(case)
            self.rows[key] = measured(label, case, *_BUDGETS[self.empty.quick])

    def race(self, case: Case) -> None:
        """Race all methods that solved a case, unless they have."""
        rows = [row for row in self.rows.values() if (row.family, row.case) == (case.family, case.name) and row.solved]
        if {row.method for row in rows} <= set(self.races.get(case.name, {})):
            return
        seconds = race({row.method: row.steps for row in rows}, case, _BUDGETS[self.empty.quick][0])
        self.races[case.name] = {label: 1e6 * a_step for label, a_step in seconds.items()}

    @property
    def results(self) -> Results:
        """All rows in the suite's order."""
        keys = [(label, case.family, case.name) for case in self.cases for label in subjects_of()]
        rows = tuple(self.rows[key] for key in keys if key in self.rows)
        return Results(self.empty.version, self.empty.seed, self.empty.quick, self.empty.machine, rows, self.races)


def as_csv(rows: Sequence[Row]) -> str:
    """The rows as a table, without the series."""
    names = [field.name for field in fields(Row) if field.name not in SERIES]
    text = io.StringIO()
    writer = csv.DictWriter(text, names, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(vars(row) for row in rows)
    return text.getvalue()


def _save(folder: Path, results: Results) -> None:
    held = {**vars(results), "rows": [vars(row) for row in results.rows]}
    write_whole(folder / "results.json", (json.dumps(held) + "\n").encode())
    write_whole(folder / "results.csv", as_csv(results.rows).encode())


def _loaded(file: Path, wanted: Results) -> Results:
    """The results in a file, if they are of the wanted suite; else an InputError that says what differs."""
    ways = "--fresh replaces it, --output names another folder"
    try:
        found = TypeAdapter(Results).validate_json(read_whole(file, _LARGEST_FILE))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        said = f"{where}: {first['msg']}" if where else first["msg"]
        raise InputError(f"{file}: is not what an earlier run has written ({said}); {ways}") from None
    except InputError as error:
        raise InputError(f"{error}; {ways}") from None
    for name in ("version", "seed", "quick", "machine"):
        before, now = getattr(found, name), getattr(wanted, name)
        if before != now:
            raise InputError(f"{file}: holds results of another run ({name} was {before}, now {now}); {ways}")
    for row in found.rows:
        lengths = {len(getattr(row, name)) for name in SERIES}
        if row.method not in subjects_of() or not lengths <= {0, row.steps}:
            raise InputError(
                f"{file}: is not what an earlier run has written (row of {row.method} on {row.case}); {ways}"
            )
    return found
