"""`hognose demo`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from hognose.cli.options import Flag, Output

if TYPE_CHECKING:
    from hognose.planning import Task


def demo(
    *,
    output: Output = Path("hognose-demo"),
    animation: bool = True,
    experiment: Flag = False,
    seed: int = 0,
    json: Flag = False,
) -> int:
    """Plan, verify and report all bundled tasks; or do the paper's whole experiment.

    They are the two cases of the paper, a detour, a tank from a STEP file, a searched route, other bases, tolerances,
    obstacles that move, and a task for each of the other arms.

    With --experiment both cases of the paper are run, in and out again, in simulated time: an arm whose zeros and
    stiffness are hidden is calibrated in a jig, planned for, and moved by 36 emulated drives and a slider. Plans,
    records with pictures of the tip camera, figures and a page, experiment.html, are written. The exit code is 1 if
    the tip is off its plan by more than 0.1 mm in root mean square, or another bound is missed.

    Parameters
    ----------
    output
        Folder for plans, reports and records.
    animation
        Include animations in the reports.
    experiment
        Do the whole experiment instead; it needs the extras drive and sim.
    seed
        Of what is hidden of the arm in it.
    json
        Print values and verdicts as JSON.
    """
    if experiment:
        from hognose.cli.experiment import experiment as whole_experiment

        return whole_experiment(output, seed, json)
    return _bundled(output, animation, json)


def _bundled(output: Path, animation: bool, json: bool) -> int:
    """Plan, verify and report all bundled tasks."""
    from hognose.cli import compile_ahead
    from hognose.cli.console import made_folder, say, say_json
    from hognose.errors import MissingExtraError
    from hognose.files import bundled_tasks, load_task

    compile_ahead.when_needed()
    made_folder(output)
    results: list[dict[str, Any]] = []
    left_out: dict[str, str] = {}
    if not json:
        say(
            "Planning the paper's two inspection cases, a detour, a tank from a STEP file, a boiler through which the "
            "way is searched, arms on other bases, one with tolerances, one past obstacles that move, and other arms.\n"
        )
    for name in bundled_tasks():
        try:
            task = load_task(name)
        except MissingExtraError as error:
            left_out[name] = str(error)
            if not json:
                say(f"{name} is left out: {error}\n")
            continue
        results.append(_shown(task, output / f"{name}.html", animation, json))
    if json:
        say_json({"good": True, "plans": results, "left_out": left_out})
    else:
        say(f"Open {output}/obstacle-array.html and {output}/pipe-tank.html to look at the motions.")
    return 0


def _shown(task: Task, page: Path, animation: bool, quiet: bool) -> dict[str, Any]:
    """Plan a task, write the report and, beside it, the plan; returns the figures."""
    import time

    from hognose.cli.console import counting, plan_json, say, stages
    from hognose.report.report import write_report
    from hognose.route import plan

    begin = time.perf_counter()
    with stages(f"planning {task.name}", quiet) as progress:
        made = plan(task, progress)
    seconds = time.perf_counter() - begin
    made.save(page.with_suffix(".parquet"))
    if not quiet:
        say(f"{made.summary()}\nplanned and verified in {seconds:.2f} s")
    times = task.spec.report.times_s or None
    with counting(f"drawing {task.name}", quiet) as bar:
        written = write_report(made, page, times=times, animation=animation, progress=bar)
    files = [str(file) for file in (page.with_suffix(".parquet"), *written)]
    if not quiet:
        say(f"written: {', '.join(files)}\n")
    return plan_json(made, seconds=seconds, files=files)
