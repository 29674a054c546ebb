"""Compiles the kernels that most tests need. `make test` runs it while types are checked, which leaves a core idle.

It runs it once more when types are checked, with `backwards`: numba compiles one function at a time in a process, and
finds what the other process has compiled.
"""

import sys

import tests.conftest  # noqa: F401 -- where kernels are kept
from hognose import METHODS, Path, SteeredPath, follow, load_robot, load_task, plan
from hognose.cli.compile_ahead import compile_ahead
from hognose.sim import simulate

#: Links, a search, stacks of joints, arcs that are fitted, two hinges, and what moves.
TASKS = ("find-a-way", "baffled-tank", "engine-stage", "test-box", "moving-obstacles", "tolerances", "drum")


def forwards() -> None:
    """What any plan needs, and then what others do."""
    compile_ahead(load_robot("sjtu-25dof"))
    for name in TASKS:
        plan(load_task(name))


def backwards() -> None:
    """What follows in other ways, steers and simulates, and then what the other process comes to last."""
    path = Path.through([[0, 0, 0], [0, 0, 0.5], [0.02, 0.03, 1.0]], 3, (0, 0, 1)).with_run(0.3)
    for method in METHODS:
        follow(path, [0.09, 0.08, 0.1], [0.0, 0.1, 0.2], method)
    for name in ("obstacle-array", "engine-stage"):
        steered = SteeredPath.of(load_task(name))
        steered.advance(0.02, turn=(0.0, 1.0))
        steered.retreat(0.01)
    simulate(plan(load_task("obstacle-array")))
    for name in reversed(TASKS):
        plan(load_task(name))


if __name__ == "__main__":
    backwards() if sys.argv[1:] == ["backwards"] else forwards()
