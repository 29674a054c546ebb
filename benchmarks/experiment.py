"""The experiments of the paper on the twin, as a page: `python -m benchmarks.experiment --docs docs/experiment.md`.

Without `--docs` the tables are printed. Pictures go into the folder `pictures` beside the page.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from benchmarks import docs_page
from hognose.studies.experiment import (
    CASES,
    Rows,
    Run,
    error_rows,
    paper_rows,
    shift_rows,
    shifted,
    shown_shift,
    stop_rows,
)
from hognose.write_whole import write_whole

PREFIX = "experiment-"
BLOCKS = ("paper", "errors", "shifts", "stops")


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.experiment", description=__doc__)
    docs_page.add_option(parser)
    page: Path | None = parser.parse_args(arguments).docs
    if page is not None:
        for name in BLOCKS:
            docs_page.found_in(page, name)
    runs = [Run.of(name) for name in CASES]
    moved = shifted(runs[0], lambda done, total: print(f"shift {done} of {total}", flush=True))
    tables = {
        "paper": table(("", "paper", "planned", "twin"), paper_rows(runs)),
        "errors": table(("", *(run.done.plan.task.name for run in runs)), error_rows(runs)),
        "shifts": table(
            ("shifted up by (mm)", "first contact (s)", "largest force (N)", "tip off, RMS (mm)", "largest (mm)",
             "at the end (mm)", "ended"),
            shift_rows(moved),
        ),
        "stops": table(
            ("shifted up by (mm)", "stop (s)", "link", "force (N)", "largest after it (N)", "left after 1 s (N)",
             "tip off then (mm)"),
            stop_rows(moved),
        ),
    }  # fmt: skip
    for name, text in tables.items():
        print(f"\n{text}")
        if page is not None:
            docs_page.write_block(page, name, text)
    if page is None:
        return
    folder = page.parent / "pictures"
    pictures = {f"{PREFIX}{run.name}{ending}": data for run in runs for ending, data in run.pictures().items()}
    pictures[f"{PREFIX}shifted.png"] = shown_shift(moved)
    for name, data in pictures.items():
        write_whole(folder / name, data)
        print(f"{folder / name}: {len(data) / 1e3:.0f} kB")


def table(head: tuple[str, ...], rows: Rows) -> str:
    """A table in Markdown, all but the first column to the right."""
    lines = [head, ("---", *("---:" for _ in head[1:])), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


if __name__ == "__main__":
    main()
