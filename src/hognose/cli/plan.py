"""`hognose plan`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from hognose.cli.options import Flag, OptionalOutput, TaskName

if TYPE_CHECKING:
    from hognose.planning import Plan, Task

#: What is written beside a plan, by its key in JSON, as people read it.
_BESIDE = {"retraction_file": "out again", "report_file": "report"}


def plan(
    task: TaskName,
    /,
    *,
    output: OptionalOutput = None,
    method: str | None = None,
    time: float | None = None,
    seed: int = 0,
    out_again: Flag = False,
    report: Flag = False,
    json: Flag = False,
) -> int:
    """Plan a task and write the plan.

    Parameters
    ----------
    task
        A task file, or a bundled task such as pipe-tank; the message about an unknown name lists them all.
    output
        The plan file; by default, the name of the task with .parquet, in the current folder.
    method
        Following method to use instead of that in the task; `hognose methods` lists them.
    time
        Time limit (s) of the search for a route to a target: the first route comes early, better ones follow. Unless
        given, a fixed amount of work is done.
    seed
        Seed of the variations that a search tries.
    out_again
        Also write the retraction: the same motion backwards, checked. The name of its file ends in -out.parquet.
    report
        Also write a report beside the plan; `hognose report` has more options.
    json
        Print values and verdicts as JSON.
    """
    from hognose.cli import compile_ahead
    from hognose.cli.console import output_file, plan_json, say, say_json
    from hognose.files import load_task, with_method
    from hognose.planning import retraction

    compile_ahead.when_needed()
    loaded = load_task(task) if method is None else with_method(load_task(task), method)
    target = output_file(output, task, ".parquet")
    made, failure = _planned(loaded, target, time, seed, json)
    made.save(target)
    beside: dict[str, Path] = {}
    if out_again and not failure:
        beside["retraction_file"] = target.with_name(f"{target.stem}-out.parquet")
        retraction(made).save(beside["retraction_file"])
    if report:
        beside["report_file"] = _page_of(made, target, json, asked_for=not failure)
    if json:
        more = {"good": False, "error": str(failure)} if failure else {}
        say_json(plan_json(made, file=str(target), **more, **{key: str(file) for key, file in beside.items()}))
    else:
        searched = loaded.spec.path.target is not None
        say(str(failure) if failure and searched else _with_advice(made.summary(), failure))
        say(_written(target) if failure else f"written to {target}")
        for key, file in beside.items():
            say(f"{_BESIDE[key]}: {file}")
    return 1 if failure else 0


def _planned(task: Task, target: Path, seconds: float | None, seed: int, quiet: bool) -> tuple[Plan, Exception | None]:
    """The plan of a task, and why it is not good; raises where there is nothing to look at.

    What an interrupted diagnosis has found is written before it raises.
    """
    from hognose.cli.console import stages
    from hognose.errors import InfeasibleError
    from hognose.route import plan as make_plan
    from hognose.route.why.diagnosis import DiagnosisInterrupted

    try:
        with stages(f"planning {task.name}", quiet) as progress:
            return make_plan(task, progress, seconds, seed), None
    except InfeasibleError as error:
        if error.plan is None:
            raise
        return error.plan, error
    except DiagnosisInterrupted as stop:
        if stop.plan is None:
            raise
        stop.plan.save(target)
        raise KeyboardInterrupt(f"{stop}\n  {_written(target)}") from None


def _with_advice(summary: str, failure: Exception | None) -> str:
    """What is said of a plan, and what its failure says besides the checks that failed."""
    said = summary.splitlines()
    return "\n".join([*said, *(line for line in str(failure or "").splitlines()[1:] if line not in said)])


def _written(target: Path) -> str:
    return f"written to {target} so that it can be looked at"


def _page_of(made: Plan, target: Path, quiet: bool, asked_for: bool) -> Path:
    """Write a report beside a plan; the task's instants are those of the motion that was asked for."""
    from hognose.cli.console import counting
    from hognose.report.report import write_report

    page = target.with_suffix(".html")
    with counting("drawing", quiet) as drawn:
        write_report(made, page, times=made.task.spec.report.times_s or None if asked_for else None, progress=drawn)
    return page
