"""Compiles the kernels that most tests need. `make test` runs it while types are checked, which leaves a core idle."""

import tests.conftest  # noqa: F401 -- where kernels are kept
from hognose import load_robot, load_task, plan
from hognose.cli.compile_ahead import compile_ahead

#: Links, a search, stacks of joints, arcs that are fitted, two hinges, and what moves.
TASKS = ("find-a-way", "baffled-tank", "engine-stage", "test-box", "moving-obstacles", "tolerances", "drum")

if __name__ == "__main__":
    compile_ahead(load_robot("sjtu-25dof"))
    for name in TASKS:
        plan(load_task(name))
