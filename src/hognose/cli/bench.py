"""`hognose bench`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hognose.cli.options import Flag, Output, Several

if TYPE_CHECKING:
    from hognose.evaluation.suite import Results
    from hognose.evaluation.summary import Table

#: Headings of the tables of the two cases, short enough for a terminal of 100 columns.
_SHORT = ("mean", "median", "95 %", "worst", "dist.", "RMSE", "VVE", "body", "RMS", "link")


def bench(
    *,
    quick: Flag = False,
    output: Output = Path("hognose-bench"),
    seed: int = 1,
    method: Several = (),
    docs: Path | None = None,
    fresh: Flag = False,
    json: Flag = False,
) -> int:
    """Compare the following methods over a suite of paths; an interrupted run continues where it stopped.

    The exit code is 0 whatever the results; the last table lists missed targets.

    Parameters
    ----------
    quick
        Run a smaller suite, in less than a minute; the full one takes several minutes.
    output
        Folder for results.json, results.csv and evaluation.html. Results of an earlier run there are kept.
    seed
        Seed of the random paths.
    method
        Measure only this method; repeat the option for more. `hognose methods` lists them.
    docs
        Also write the results as a documentation page (.md), with its figures in the folder `pictures` beside it.
    fresh
        Measure everything anew and ignore earlier results.
    json
        Print the results as JSON.
    """
    from hognose.cli.console import counting, made_folder, say, say_json
    from hognose.errors import InputError
    from hognose.evaluation.pages import write_docs, write_page
    from hognose.evaluation.subjects import subjects_of
    from hognose.evaluation.suite import run_suite

    labels = subjects_of(method)
    if seed < 0:
        raise InputError(f"--seed {seed}: expected a whole number, 0 or more")
    if docs is not None:
        _refuse_page(docs)
    made_folder(output)
    try:
        with counting("measuring", json) as progress:
            results = run_suite(output, labels, seed, quick, progress, fresh=fresh)
    except KeyboardInterrupt:
        again = "the same command" + (" without --fresh" if fresh else "")
        raise KeyboardInterrupt(f"interrupted; finished rows are in {output}, {again} goes on from them") from None
    with counting("drawing", json) as progress:
        files = [output / "results.json", output / "results.csv", *write_page(results, output, progress)]
        files += write_docs(results, docs, progress) if docs is not None else []
    if json:
        say_json(_as_json(results, files))
    else:
        _say_tables(results)
        say("")
        say("written: " + ", ".join(str(file) for file in files))
    return 0


def _refuse_page(docs: Path) -> None:
    """Before anything is measured for a page that cannot be written."""
    from hognose.errors import InputError

    if docs.suffix != ".md":
        raise InputError(f"{docs}: the name of this page must end in .md")
    if not docs.parent.is_dir():
        raise InputError(f"{docs}: cannot write: there is no folder {docs.parent}; make it first")


def _say_tables(results: Results) -> None:
    from dataclasses import replace

    from hognose.cli.console import say
    from hognose.evaluation.summary import coverage, failures, family_table, shapes_beside_published, targets_table
    from hognose.evaluation.targets import CASES, targets_of

    say("Valid of all cases by family; in brackets the solved ones, if they are more")
    _say_table(coverage(results))
    for case in CASES:
        found = family_table(results, "cases", case)
        if found.rows:
            say(f"\n{case}: µs and distances measured a step; errors of tip, body and links in mm (VVE: mm²)")
            _say_table(replace(found, head=("method", *_SHORT)))
    found = shapes_beside_published(results)
    if found.rows:
        say("\nThree arcs on a slider, mean deviation in % of the length, beside a published average of other shapes")
        _say_table(found)
    found = failures(results)
    if found.rows:
        say("\nNot valid, and why; all figures are in results.csv and evaluation.html")
        _say_table(found)
    say("\nTargets")
    _say_table(targets_table(targets_of(results)))


def _say_table(shown: Table) -> None:
    """Print a table; columns of numbers are filled up on the left, so that they stand right of one another."""
    from hognose.cli.console import table

    columns = list(zip(shown.head, *shown.rows, strict=True))
    for column in shown.numbers:
        width = max(map(len, columns[column]))
        columns[column] = tuple(cell.rjust(width) for cell in columns[column])
    head, *rows = zip(*columns, strict=True)
    table(head, rows)


def _as_json(results: Results, files: Sequence[Path]) -> dict[str, Any]:
    """The results for machines: rows without their series, races, targets."""
    from dataclasses import asdict

    from hognose.evaluation.suite import SERIES
    from hognose.evaluation.targets import targets_of

    targets = targets_of(results)
    verdicts = {target.verdict for target in targets}
    return {
        # Not known as long as a target was not measured.
        "good": False if "MISSED" in verdicts else True if verdicts == {"reached"} else None,
        **{name: getattr(results, name) for name in ("version", "seed", "quick", "machine", "races")},
        "targets": [{**asdict(target), "verdict": target.verdict} for target in targets],
        "rows": [{name: value for name, value in vars(row).items() if name not in SERIES} for row in results.rows],
        "files": [str(file) for file in files],
    }
