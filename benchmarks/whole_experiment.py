"""The whole experiment as a table: `python -m benchmarks.whole_experiment --docs docs/experiment.md`.

Without `--docs` it is printed. `--seed` draws another arm.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path

from benchmarks import docs_page
from benchmarks.experiment import table
from hognose.studies.experiment_page import figure_rows
from hognose.studies.whole_experiment import whole_experiment

BLOCK = "drives"


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.whole_experiment", description=__doc__)
    docs_page.add_option(parser)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args(arguments)
    if given.docs is not None:
        docs_page.found_in(given.docs, BLOCK)
    with tempfile.TemporaryDirectory(prefix="hognose-experiment-") as folder:
        found = whole_experiment(Path(folder), seed=given.seed, said=lambda words: print(words, flush=True))
    text = table(*figure_rows(found))
    print(f"\n{text}\n\n{found.verdict}; in {found.seconds:.0f} s")
    if given.docs is not None:
        docs_page.write_block(given.docs, BLOCK, text)
    if not found.good:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
