"""How often and how soon routes are found for arms of 5 to 60 links of 20 to 300 mm that bend 10 to 60 degrees a joint.

    python -m benchmarks.arms --spaces 10 --json arms.jsonl
    python -m benchmarks.arms --table arms.jsonl --docs docs/speed.md

Each arm gets spaces of all families in turn, in proportion to its size, wrapped round a random motion of its own that
keeps 4/9 of the body's radius (as 10 mm are of the bundled arm's), which is proven first. The search sees obstacles,
entrance and target, and must certify half of that, or all of it with `--margin 1`.

Seconds are the processor's, of all threads together, so that other work on the machine matters little.

Each space is a row of the file; a run that was interrupted goes on with the same settings.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path as FilePath

import numpy as np

import hognose
from benchmarks.docs_page import add_option, found_in, write_block
from benchmarks.planted_arms import ARMS, arm, planted_clearance
from benchmarks.planted_spaces import FAMILIES, space
from benchmarks.route_table import Row, aligned
from benchmarks.routes import certified, rows_of, say
from hognose.planning.task import Task
from hognose.route import Search


@dataclass(frozen=True)
class Settings:
    """What a row was measured with; the margin is a part of the planted clearance."""

    seconds: float
    margin: float


@dataclass(eq=False)
class ProcessorSearch(Search):
    """A search that ends at its first route, or after so many seconds of the processor."""

    _used: float = field(default_factory=time.process_time)

    @property
    def spent(self) -> float:
        """Seconds of the processor since the search began."""
        return time.process_time() - self._used

    def goes_on(self) -> bool:
        """Whether there is no route yet, and time."""
        return self.best is None and super().goes_on()


def searched(task: Task, seconds: float, seed: int) -> ProcessorSearch:
    """A search that has ended."""
    search = ProcessorSearch(task, seconds, seed)
    search.run()
    return search


def main() -> None:
    """Measure, or print what was measured."""
    given = arguments()
    if given.docs is not None:
        found_in(given.docs, "arms")  # so that a wrong page is refused before anything is measured
    if given.table is not None:
        print(table(rows_of(given.table)))
        write_docs(given.docs, rows_of(given.table))
        return
    settings = Settings(given.seconds, given.margin)
    # So that nothing is compiled while the clock runs.
    hognose.plan(hognose.load_task("obstacle-array"))
    searched(space(arm(*ARMS[0]), "boards", 0, 0.001, 0.0005).task, 10.0, 0)
    done = [] if given.json is None or not given.json.exists() else rows_of(given.json)
    found = {(row["arm"], row["seed"]): row for row in done if row["settings"] == asdict(settings)}
    rows: list[Row] = []
    for number in given.arm or range(len(ARMS)):
        for seed in range(given.seed, given.seed + given.spaces):
            if (number, seed) not in found:
                found[number, seed] = row = measured(number, seed, settings)
                say(told(row))
                if given.json is not None:
                    with given.json.open("a") as stream:
                        stream.write(json.dumps(row) + "\n")
            rows.append(found[number, seed])
    print(table(rows))
    write_docs(given.docs, rows)


def write_docs(file: FilePath | None, rows: list[Row]) -> None:
    """Write the table into a page of the documentation."""
    if file is not None:
        write_block(file, "arms", table(rows))


def measured(number: int, seed: int, settings: Settings) -> Row:
    """A row of results: lengths in mm, times in s; what was not found is None."""
    robot, family = arm(*ARMS[number]), FAMILIES[(number + seed) % len(FAMILIES)]
    planted = planted_clearance(robot)
    made = space(robot, family, seed, planted, settings.margin * planted)
    proof = made.proof()
    assert made.task.scene is not None  # it is built before the clock runs
    search = searched(made.task, settings.seconds, seed)
    return {
        "settings": asdict(settings),
        "arm": number,
        "name": robot.name,
        "family": family,
        "seed": seed,
        "margin": 1e3 * made.task.margin,
        "planted": 1e3 * planted,
        "planted_certified": certified(proof),
        "passages": search.passages,
        "spent": search.spent,
        "first": search.found[0].seconds if search.found else None,
        "certified": certified(search.best.plan) if search.best else None,
    }


def told(row: Row) -> str:
    """A row in a line."""
    words = f"{row['name']}: {row['family']} {row['seed']}"
    if row["first"] is None:
        return f"{words} | no route in {row['spent']:.1f} s, {row['passages']} passages"
    return f"{words} | first {row['first']:.2f} s, certified {row['certified']:.2f} of {row['margin']:.2f} mm"


def table(rows: list[Row]) -> str:
    """A line an arm, and one for all."""
    groups = {name: [row for row in rows if row["name"] == name] for name in dict.fromkeys(row["name"] for row in rows)}
    if len(groups) > 1:
        groups["total"] = rows
    heads = ["arm", "spaces", "proven as planted", "found", "certified ≥ margin", "first, median / 95 % / worst (s)"]
    lines = [heads]
    for name, group in groups.items():
        times = [row["first"] for row in group if row["first"] is not None]
        proven = sum(row["planted_certified"] >= row["planted"] for row in group)
        kept = sum(row["certified"] is not None and row["certified"] >= row["margin"] for row in group)
        spread = [np.median(times), np.percentile(times, 95), max(times)] if times else []
        figures = [len(group), proven, len(times), kept, " / ".join(f"{time:.2f}" for time in spread)]
        lines.append([name, *map(str, figures)])
    return aligned(lines)


def arguments() -> argparse.Namespace:
    """What the command line asks for."""
    what = "The route finder, measured with arms of many sizes on spaces with a known way through."
    parser = argparse.ArgumentParser(prog="python -m benchmarks.arms", description=what)
    parser.add_argument("--spaces", type=int, default=10, help="spaces an arm (default: %(default)s)")
    parser.add_argument("--seconds", type=float, default=10.0, help="time for a space (default: %(default)s)")
    parser.add_argument(
        "--margin", type=float, default=0.5, help="part of the planted clearance (default: %(default)s)"
    )
    parser.add_argument("--arm", action="append", type=int, choices=range(len(ARMS)), help="only this; may be repeated")
    parser.add_argument("--seed", type=int, default=0, help="of the first space (default: %(default)s)")
    parser.add_argument("--json", type=FilePath, metavar="FILE", help="results are kept there, a line a space")
    parser.add_argument("--table", type=FilePath, metavar="FILE", help="only print the table of such a file")
    add_option(parser)
    return parser.parse_args()


if __name__ == "__main__":
    main()
