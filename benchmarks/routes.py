"""How often and how soon routes are found in spaces with a known way through.

    python -m benchmarks.routes [SPACES [SECONDS [PLANTED_MM [MARGIN_MM]]]]

Every space is wrapped round a random motion of the arm that keeps the planted clearance, which is proven first. The
search sees obstacles, entrance and target, and must certify the margin.
"""

from __future__ import annotations

import sys

import numpy as np

import hognose
from hognose.route.search import Search
from hognose.route.spaces import FAMILIES, Family, space

HEADINGS = ("family", "solved", "first median", "95 %", "best median", "95 %", "certified median", "worst", "planted")


def measured(family: Family, count: int, seconds: float, planted: float, margin: float) -> list[str]:
    """One row of the table."""
    robot = hognose.load_robot("sjtu-25dof")
    first, best, certified, unsolved = [], [], [], []
    for seed in range(count):
        made = space(robot, family, seed, planted, margin)
        made.proof()
        search = Search(made.task, seconds, seed)
        search.run()
        if search.best is None:
            unsolved.append(seed)
            continue
        first.append(search.found[0].seconds)
        best.append(search.best.seconds)
        certified.append(1e3 * search.best.clearance)
    if unsolved:
        print(f"{family}: no route for seeds {unsolved}", flush=True)
    if not first:
        return [family, f"0/{count}", *[""] * 6, f"{1e3 * planted:g} mm"]
    times = [f"{value:.2f} s" for data in (first, best) for value in (np.median(data), np.percentile(data, 95))]
    room = [f"{np.median(certified):.2f} mm", f"{min(certified):.2f} mm", f"{1e3 * planted:g} mm"]
    return [family, f"{len(first)}/{count}", *times, *room]


def main(arguments: list[str]) -> None:
    """Print the table."""
    count, seconds, planted, margin = (float(a) for a in [*arguments, *("10", "10", "10", "5")[len(arguments) :]])
    hognose.plan(hognose.load_task("obstacle-array"))  # so that nothing is compiled while the clock runs
    print(f"{count:g} spaces a family, {seconds:g} s each, {margin:g} mm asked for", flush=True)
    print(" | ".join(HEADINGS), flush=True)
    for family in FAMILIES:
        print(" | ".join(measured(family, int(count), seconds, planted / 1e3, margin / 1e3)), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
