"""Whether a change of the sources left every plan as it was, bit for bit on one machine.

`python -m benchmarks.unchanged --write before.json` plans all bundled tasks and 200 random ones (arms of the paper,
every method and kind of path, and routes searched with a fixed amount of work), and keeps a digest of each plan's
columns and its verdict. `--against before.json` plans them anew with the sources as they are then, and names the plans
that differ.
"""

from __future__ import annotations

import argparse
import hashlib
import itertools
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import hognose
from hognose.errors import HognoseError, InfeasibleError
from hognose.files import bundled_robots, bundled_tasks
from hognose.planning import Plan, TaskSpec
from hognose.route import Search

RANDOM, SEARCHED = 180, 20
COLUMNS = ("time", "feed", "joints", "angles", "cable_lengths", "motor_counts", "clearance")
KINDS = ("spline", "spline", "polyline", "bezier", "bspline")


def spaces() -> Iterator[tuple[str, hognose.Task]]:
    """Every task, by name."""
    for name in bundled_tasks():
        yield name, hognose.load_task(name)
    robots = [hognose.load_robot(name) for name in bundled_robots() if name.startswith("sjtu")]
    choices = itertools.cycle(itertools.product(hognose.METHODS, KINDS))
    for seed in range(RANDOM):
        method, kind = next(choices)
        yield f"random {seed}, {method}, {kind}", _along(seed, robots[seed % len(robots)], method, kind)
    for seed in range(SEARCHED):
        yield f"searched {seed}", _searched(seed, robots[seed % len(robots)])


def _balls(random: np.random.Generator, count: int, keep: float) -> list[dict[str, Any]]:
    """Balls and boxes beside the way, now and then upon it."""
    made: list[dict[str, Any]] = []
    for k in range(count):
        at = random.uniform((-0.3, -0.3, 0.1), (0.3, 0.3, 0.9))
        at[:2] += np.sign(at[:2]) * keep
        size = random.uniform(0.02, 0.15)
        if k % 2:
            made.append({"kind": "box", "center": tuple(at), "size": (size, 0.5 * size, 2 * size)})
        else:
            made.append({"kind": "sphere", "center": tuple(at), "diameter": size})
    return made


def _along(seed: int, robot: hognose.Robot, method: str, kind: str) -> hognose.Task:
    random = np.random.default_rng(seed)
    count = int(random.integers(2, 6))
    step = float(random.choice([0.0035, 0.01]))
    steps = np.column_stack([random.normal(0, 0.025, (count, 2)), random.uniform(0.1, 0.2, count)])
    points = np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])
    spec: dict[str, Any] = {
        "name": f"random {seed}",
        "robot": robot.name,
        "margin": float(random.choice([0.0, 0.005])),
        "path": {"kind": kind, "way_points": [tuple(map(float, point)) for point in points]},
        "motion": {"method": method, "step": step, "period_s": step / 0.02},
        "obstacle": _balls(random, int(random.integers(0, 6)), float(random.uniform(0, 0.1))),
    }
    if kind == "polyline":
        spec["path"] |= {"kind": "spline", "order": 1}
    return hognose.Task(TaskSpec.model_validate(spec), robot)


def _searched(seed: int, robot: hognose.Robot) -> hognose.Task:
    random = np.random.default_rng(1000 + seed)
    target = (*random.normal(0, 0.15, 2), random.uniform(0.5, 0.8))
    spec = {
        "name": f"searched {seed}",
        "robot": robot.name,
        "margin": 0.005,
        "path": {"target": tuple(map(float, target))},
        "motion": {"step": 0.01, "period_s": 0.5},
        "obstacle": _balls(random, 5, 0.02),
    }
    return hognose.Task(TaskSpec.model_validate(spec), robot)


class _First(Search):
    def goes_on(self) -> bool:
        """Whether there is no route yet, and not much was tried."""
        return self.best is None and self.attempts < 4


def outcome(task: hognose.Task) -> str:
    """What comes of a task: a digest of the plan's columns and verdict, or of the reason that there is none."""
    try:
        if task.spec.path.target is not None:
            search = _First(task, None, 0, lambda stage: None)
            search.run()
            return "no route" if search.best is None else digest(search.best.plan)
        return digest(hognose.plan(task))
    except InfeasibleError as error:
        return "infeasible" if error.plan is None else digest(error.plan)
    except HognoseError as error:
        return type(error).__name__


def digest(plan: Plan) -> str:
    """A digest of a plan's columns, and which of its checks passed."""
    found = hashlib.sha256()
    for name in COLUMNS:
        found.update(np.ascontiguousarray(getattr(plan, name)).tobytes())
    verdict = "".join("+" if check.ok else "-" for check in plan.checks)
    return f"{found.hexdigest()[:32]} {verdict}"


def main() -> int:
    """Write the outcomes, or compare them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    way = parser.add_mutually_exclusive_group(required=True)
    way.add_argument("--write", type=Path, help="where to keep the outcomes")
    way.add_argument("--against", type=Path, help="outcomes that were kept")
    chosen = parser.parse_args()
    found = {name: outcome(task) for name, task in spaces()}
    good = sum(value.count(" ") == 1 and "-" not in value.split()[1] for value in found.values())
    said = f"{len(found)} tasks, {good} of them with a good plan"
    if chosen.write:
        chosen.write.write_text(json.dumps(found, indent=1))
        print(said)
        return 0
    before = json.loads(chosen.against.read_text())
    differ = [name for name in before | found if before.get(name) != found.get(name)]
    for name in differ:
        print(f"{name}: {before.get(name)} before, {found.get(name)} now")
    print(f"{said}; {len(differ)} differ")
    return int(bool(differ))


if __name__ == "__main__":
    sys.exit(main())
