"""What a budget of tolerances costs: drawn arms, and a plan with and without it, in alternation.

`python -m benchmarks.tolerances` prints times of the example `tolerances` on one core, the least of many.
"""

from __future__ import annotations

import time

import hognose
from benchmarks.rows import aside, heading, row
from benchmarks.timing import best_times, use_one_core
from hognose.planning import Task
from hognose.planning.checks.shared import Shared
from hognose.planning.drawn_arms import draw
from hognose.planning.tolerance.spec import ToleranceSpec

ROUNDS = 30


def main() -> None:
    """Measure and print."""
    use_one_core()
    task = hognose.load_task("tolerances")
    plain = Task(task.spec.model_copy(update={"tolerance": ToleranceSpec()}), task.robot)
    plan, budget = hognose.plan(task), task.budget
    assert budget is not None
    taken = Shared(plan, plan.clearance).taken
    candidates = {
        "draws": lambda: draw(plan, budget, taken),
        "given": lambda: hognose.plan(task),
        "without": lambda: hognose.plan(plain),
    }
    draws, given, without = best_times(candidates, ROUNDS, time.process_time).values()
    heading("the example tolerances: drawn arms, and what a budget costs, one core")
    row("10,000 drawn arms", 1e3 * draws, 20.0, "ms")
    row("a budget makes a plan longer by", 1e3 * (given - without), 3.0, "ms")
    aside("a plan without", 1e3 * without, "ms")
    heading("shares of 10,000 and of 1,000,000 drawn arms")
    few, many = (draw(plan, budget, taken, count) for count in (10_000, 1_000_000))
    for share in (0.01, 0.05, 0.5):
        aside(f"{share:.0%} come closer than, 10,000 draws", 1e3 * few.quantile(share), "mm")
        aside(f"{share:.0%} come closer than, 1,000,000 draws", 1e3 * many.quantile(share), "mm")


if __name__ == "__main__":
    main()
