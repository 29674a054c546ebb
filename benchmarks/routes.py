"""How often, how soon and with how much room routes are found in spaces with a known way through.

    python -m benchmarks.routes --spaces 34 --json routes.jsonl
    python -m benchmarks.routes --table routes.jsonl --docs docs/speed.md

Every space is wrapped round a random motion of the arm that keeps the planted clearance, which is proven first. The
search sees obstacles, entrance and target, and must certify the margin. What it finds is checked again by Coal, joints
interpolated as the drives do. Beside it, OMPL's RRTConnect gets the same time in the arm's joint space.

Each space is a row of the file; a run that was interrupted goes on with `--json` and the same settings, and two runs
may write to one file, each with other families.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from dataclasses import asdict, dataclass
from pathlib import Path as FilePath
from typing import Any

import numpy as np

import hognose
from benchmarks.by_coal import Obstacles, chain, dense_check, interpolated
from benchmarks.docs_page import add_option, found_in, write_block
from benchmarks.planted_spaces import FAMILIES, Space, space
from benchmarks.route_table import Row, printed
from hognose.planning import Plan
from hognose.planning.task import Task
from hognose.route.search.search import Found, Search

ROBOT = "sjtu-25dof"
#: Feed (m) between two configurations of Coal's check.
FEED = 1e-4


@dataclass(frozen=True)
class Settings:
    """What a row was measured with: rows with other settings are not compared."""

    robot: str
    seconds: float
    patience: float
    planted: float
    margin: float
    ompl: bool
    coal: bool


class PatientSearch(Search):
    """A search that stops after its seconds, but goes on up to the patience (s) while nothing is found."""

    patience = 0.0

    def goes_on(self) -> bool:
        """Whether there is time left."""
        assert self.seconds is not None
        return self.spent < (self.seconds if self.found else self.patience)


def main() -> None:
    """Measure, or print what was measured."""
    given = arguments()
    if given.docs is not None:
        found_in(given.docs, "routes")  # so that a wrong page is refused before anything is measured
    if given.table is not None:
        print(printed(rows_of(given.table)))
        write_docs(given.docs, rows_of(given.table))
        return
    settings = Settings(
        ROBOT, given.seconds, given.patience, given.planted, given.margin, not given.no_ompl, not given.no_coal
    )
    # So that nothing is compiled while the clock runs.
    hognose.plan(hognose.load_task("obstacle-array"))
    robot = hognose.load_robot(ROBOT)
    warm = searched(space(robot, "boards", given.seed).task, 1.0, 1.0, given.seed)
    done = [] if given.json is None or not given.json.exists() else rows_of(given.json)
    found = {(row["family"], row["seed"]): row for row in done if row["settings"] == asdict(settings)}
    say(f"warm after {warm.spent:.1f} s; {len(found)} spaces are there already")
    rows: list[Row] = []
    for family in given.family or FAMILIES:
        for seed in range(given.seed, given.seed + given.spaces):
            if (family, seed) in found:
                rows.append(found[family, seed])
                continue
            made = space(robot, family, seed, settings.planted / 1e3, settings.margin / 1e3)
            rows.append(measured(made, settings))
            say(told(rows[-1]))
            if given.json is not None:
                with given.json.open("a") as stream:
                    stream.write(json.dumps(rows[-1]) + "\n")
    print(printed(rows))
    write_docs(given.docs, rows)


def write_docs(file: FilePath | None, rows: list[Row]) -> None:
    """Write the table into a page of the documentation."""
    if file is not None:
        write_block(file, "routes", printed(rows))


def measured(made: Space, settings: Settings) -> Row:
    """A row of results: lengths in mm, times in s; what was not found or not done is None."""
    planted = certified(made.proof())
    triangles = len(made.task.scene.triangles)  # and the scene is built before the clock runs
    search = searched(made.task, settings.seconds, settings.patience, made.seed)
    row: Row = {
        "settings": asdict(settings),
        "family": made.family,
        "seed": made.seed,
        "triangles": triangles,
        "planted_certified": planted,
        "spent": search.spent,
        "passages": search.passages,
        "first": search.found[0].seconds if search.found else None,
        "best": search.best.seconds if search.best else None,
        "certified": certified(search.best.plan) if search.best else None,
        "by_coal": None,
        "ompl": None,
    }
    if settings.coal and search.best:
        row["by_coal"] = checked_by_coal(search.best)
    if settings.ompl:
        row["ompl"] = by_ompl(made.task, settings, made.seed)
    return row


def searched(task: Task, seconds: float, patience: float, seed: int) -> PatientSearch:
    """A search that has ended."""
    search = PatientSearch(task, seconds, seed)
    search.patience = max(seconds, patience)
    search.run()
    return search


def certified(plan: Plan) -> float:
    """Certified clearance (mm), the smaller of both motions."""
    return 1e3 * (plan.certified_clearance or 0.0)


def checked_by_coal(found: Found) -> dict[str, float]:
    """The smallest distance (mm) of the best route's dense configurations."""
    begin = time.perf_counter()
    plan, robot = found.plan, found.plan.robot
    at = interpolated(np.column_stack([plan.feed, plan.angles.reshape(len(plan.feed), -1)]), FEED)
    joints, _ = chain(at[:, 1:].reshape(len(at), -1, 2), at[:, 0], robot.link_lengths)
    dense = dense_check(Obstacles(plan.scene.triangles), joints + plan.task.base.start, robot.body_radii)
    return {
        "smallest": 1e3 * dense.smallest,
        "configurations": dense.configurations,
        "measured": dense.measured,
        "seconds": time.perf_counter() - begin,
    }


def by_ompl(task: Task, settings: Settings, seed: int) -> dict[str, Any]:
    """What RRTConnect did with the same task in the same time."""
    from benchmarks.joint_space import attempt

    tried = attempt(task, settings.seconds, seed)
    out = asdict(tried)
    del out["path"]
    return out | {"way_points": None if tried.path is None else len(tried.path)}


def rows_of(file: FilePath) -> list[Row]:
    """The rows of a file; a last line that was cut off does not count."""
    rows: list[Row] = []
    for line in file.read_text().splitlines():
        try:
            rows.append(json.loads(line))
        except json.JSONDecodeError:
            say(f"{file}: a line that is no row is left out")
    return rows


def told(row: Row) -> str:
    """A row in a line."""
    words = [f"{row['family']} {row['seed']}"]
    if row["first"] is None:
        words.append(f"no route in {row['spent']:.1f} s, {row['passages']} passages")
    else:
        words.append(f"first {row['first']:.2f} s, best {row['best']:.2f} s, certified {row['certified']:.2f} mm")
    if row["by_coal"]:
        words.append(f"by Coal {row['by_coal']['smallest']:.3f} mm ({row['by_coal']['seconds']:.1f} s)")
    if row["ompl"]:
        tried = row["ompl"]
        words.append(f"OMPL: {tried['ended']} in {tried['seconds']:.1f} s, {tried['goals']}/{tried['reached']} goals")
    return " | ".join(words)


def say(text: str) -> None:
    """Progress, beside the table."""
    print(text, file=sys.stderr, flush=True)


def arguments() -> argparse.Namespace:
    """What the command line asks for."""
    what = "The route finder, measured on spaces with a known way through."
    parser = argparse.ArgumentParser(prog="python -m benchmarks.routes", description=what)
    parser.add_argument("--spaces", type=int, default=10, help="spaces a family (default: %(default)s)")
    parser.add_argument("--seconds", type=float, default=10.0, help="time for a space (default: %(default)s)")
    parser.add_argument("--patience", type=float, default=60.0, help="s, while nothing is found (default: %(default)s)")
    parser.add_argument("--planted", type=float, default=10.0, help="known clearance, mm (default: %(default)s)")
    parser.add_argument("--margin", type=float, default=5.0, help="asked clearance, mm (default: %(default)s)")
    parser.add_argument("--family", action="append", choices=FAMILIES, help="only this one; may be repeated")
    parser.add_argument("--seed", type=int, default=0, help="of the first space (default: %(default)s)")
    parser.add_argument("--no-ompl", action="store_true", help="without RRTConnect beside it")
    parser.add_argument("--no-coal", action="store_true", help="without the dense check")
    parser.add_argument("--json", type=FilePath, metavar="FILE", help="results are kept there, a line a space")
    parser.add_argument("--table", type=FilePath, metavar="FILE", help="only print the table of such a file")
    add_option(parser)
    return parser.parse_args()


if __name__ == "__main__":
    main()
