"""`hognose plan`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def plan(
    task: str,
    /,
    *,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
    method: str | None = None,
    json: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Plan a task and write the plan.

    Parameters
    ----------
    task
        A task file, or a bundled task: obstacle-array, pipe-tank, detour.
    output
        The plan file; default is the task's name with .parquet, in this folder.
    method
        Following method instead of the task's; `hognose methods` lists them.
    json
        Print figures and verdicts as JSON.
    """
    from hognose import errors
    from hognose.cli.console import output_file, plan_json, say, say_json, stages
    from hognose.files import load_task, with_method
    from hognose.planning import plan as make_plan

    loaded = load_task(task) if method is None else with_method(load_task(task), method)
    target = output_file(output, task, ".parquet")
    failure = None
    try:
        with stages(f"planning {loaded.name}", json) as progress:
            made = make_plan(loaded, progress)
    except errors.InfeasibleError as error:
        if error.plan is None:
            raise
        made, failure = error.plan, error
    made.save(target)
    if json:
        say_json(plan_json(made, file=str(target), **({"error": str(failure)} if failure else {})))
    else:
        say(made.summary())
        say(f"written to {target}" + (" so that it can be looked at" if failure else ""))
    return 1 if failure else 0
