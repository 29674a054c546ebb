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
    json: Flag = False,
) -> int:
    """Plan, verify and report all bundled tasks; or run the whole experiment of the paper without its hardware.

    They are the two cases of the paper, a detour, a tank from a STEP file, a searched route, other bases, tolerances
    and obstacles that move.

    Parameters
    ----------
    output
        Folder for plans and reports.
    animation
        Include animations in the reports.
    experiment
        Instead: calibrate an arm whose truth is hidden, plan both cases of the paper, run them in and back on emulated
        drives that move the twin, and report it all. It takes a few minutes; exit code 1 if the tip is not where it
        must be.
    json
        Print values and verdicts as JSON.
    """
    if experiment:
        return _experiment(output, json)
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
            "way is searched, arms on other bases, one with tolerances, and one past obstacles that move.\n"
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


def _experiment(output: Path, json: bool) -> int:
    """Run the whole experiment; what is done is left if it is interrupted."""
    import time

    from hognose.cli.console import made_folder, say, say_json, stages
    from hognose.files import bundled_tasks, load_task
    from hognose.studies.experiment_page import experiment_page
    from hognose.studies.whole_experiment import CASES, verdict
    from hognose.studies.whole_experiment import experiment as carried_out
    from hognose.write_whole import write_whole

    made_folder(output)
    done, page = [], output / "experiment.html"
    for name in CASES:
        begin = time.perf_counter()
        with stages(name, json) as show:
            task = load_task(str(bundled_tasks()[name]))
            case = carried_out(name, task, output, progress=lambda share, words: show(f"{100 * share:.0f} %, {words}"))
        done.append(case)
        write_whole(page, experiment_page(done).encode())
        if not json:
            ways = ", ".join(f"{leg.name} {1e3 * leg.rms:.3f} mm" for leg in case.legs)
            say(f"{name}: tip off its plan in root mean square: {ways}; in {time.perf_counter() - begin:.0f} s")
    said = verdict(done)
    good = said.startswith("GOOD")
    if json:
        say_json({"good": good, "verdict": said, "cases": [case.to_json() for case in done], "page": str(page)})
    else:
        say(f"{page}: what was reached and seen\n{said}")
    return 0 if good else 1


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
