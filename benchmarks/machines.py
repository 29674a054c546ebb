"""What is the same on every machine: the bundled tasks planned with other BLAS kernels and for another processor.

`python -m benchmarks.machines` plans every bundled task, in a process each, with numpy's BLAS made for other processors
(`OPENBLAS_CORETYPE`) and with our kernels compiled for none in particular (`NUMBA_CPU_NAME=generic`, without fused
multiply-adds). It prints how far the plans are from this machine's and exits with 1 if the number of steps, the verdict
or a motor count differs. A count may differ only where a cable's length lies on the border between two counts. Kernels
with instructions that this processor does not have cannot be tried on it: the table says so.
"""

from __future__ import annotations

import itertools
import json
import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

#: What OpenBLAS calls processors; a name that this machine's build does not know changes nothing.
BLAS_KERNELS = ("Nehalem", "Sandybridge", "Haswell", "Zen", "SkylakeX")
SETTINGS: dict[str, dict[str, str]] = {
    "this machine": {},
    **{f"BLAS for {name}": {"OPENBLAS_CORETYPE": name} for name in BLAS_KERNELS},
    "kernels for any": {"NUMBA_CPU_NAME": "generic"},
    "both": {"OPENBLAS_CORETYPE": BLAS_KERNELS[0], "NUMBA_CPU_NAME": "generic"},
}
#: How far (in counts) a cable's length may be from the border between two counts if they differ.
BORDER = 1e-6
#: Plans forwards or backwards: two processes that begin together find what the other one has compiled, from its end.
_PLAN = """
import json, sys, hognose
from hognose.cli.compile_ahead import compile_ahead
from hognose.files import bundled_tasks
plans, names = {}, list(bundled_tasks())
if sys.argv[1:] == ["backwards"]:
    compile_ahead(hognose.load_robot("sjtu-25dof"))
    names.reverse()
for name in names:
    task = hognose.load_task(name)
    if task.spec.path.target is None:  # a search may find another way on another machine
        plan = hognose.plan(task)
        exact = (plan.cable_lengths - plan.robot.straight_cable_lengths) / plan.robot.travel_per_count
        plans[name] = {"good": plan.good, "counts": plan.motor_counts.tolist(), "exact": exact.tolist(),
                       "angles": plan.angles.tolist(), "certified": plan.certified_clearance}
json.dump(plans, sys.stdout)
"""


def main() -> int:
    """Print the table; 1 if something that must be the same is not."""
    wrong = 0
    print(f"{'settings':20} {'task':16} {'steps':>6} {'counts that differ':>19} {'largest difference':>26}")
    with ThreadPoolExecutor(os.cpu_count()) as processes:
        orders = itertools.cycle([[], ["backwards"]])
        found = dict(zip(SETTINGS, processes.map(planned, SETTINGS.values(), orders), strict=True))
    here = found["this machine"]
    if here is None:
        raise SystemExit("the plans of this machine itself died of an instruction that it does not have")
    for name, plans in found.items():
        if plans is None:
            print(f"{name:20} this processor does not have their instructions")
            continue
        for task, expected in here.items():
            plan = plans[task]
            differ, beyond, apart = compared(expected, plan)
            wrong += beyond
            steps = len(plan["counts"]) - 1
            said = "" if not beyond else "  NOT THE SAME"
            print(f"{name:20} {task:16} {steps:6d} {differ:19d} {np.degrees(apart):21.1e} deg{said}")
    return 1 if wrong else 0


def planned(settings: dict[str, str], order: list[str]) -> dict[str, Any] | None:
    """The plans of the bundled tasks, made in a process with these settings; None if the processor cannot run them."""
    plain = {name: value for name, value in os.environ.items() if name not in ("OPENBLAS_CORETYPE", "NUMBA_CPU_NAME")}
    done = subprocess.run([sys.executable, "-c", _PLAN, *order], env=plain | settings, capture_output=True, text=True)
    if done.returncode == -signal.SIGILL:
        return None
    if done.returncode:
        raise SystemExit(f"planning with {settings or 'no settings'} failed:\n{done.stderr}")
    return json.loads(done.stdout)


def compared(one: dict[str, Any], other: dict[str, Any]) -> tuple[int, int, float]:
    """Counts that differ, how many of them may not (nor verdict or steps), and how far (rad) angles differ."""
    counts, others = np.array(one["counts"]), np.array(other["counts"])
    if counts.shape != others.shape or one["good"] != other["good"]:
        return counts.size, 1, np.inf
    differ = counts != others
    exact = np.array(one["exact"])
    on_border = np.abs(np.abs(exact - np.floor(exact)) - 0.5) < BORDER
    apart = float(np.abs(np.array(one["angles"]) - np.array(other["angles"])).max())
    return int(differ.sum()), int((differ & ~on_border).sum()), apart


if __name__ == "__main__":
    sys.exit(main())
