"""`hognose demo`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def demo(
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("hognose-demo"),
    animation: bool = True,
    json: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Plan, verify and report all bundled tasks: the two cases of the paper, a detour, a STEP file and a route search.

    Parameters
    ----------
    output
        Folder for plans and reports.
    animation
        Include animations in the reports.
    json
        Print values and verdicts as JSON.
    """
    import time

    from hognose.cli import compile_ahead
    from hognose.cli.console import counting, plan_json, say, say_json, stages
    from hognose.errors import InputError, MissingExtraError
    from hognose.files import bundled_tasks, load_task
    from hognose.report.report import write_report
    from hognose.route import plan

    compile_ahead.when_needed()
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{output}: cannot make the folder: {error.strerror}") from None
    results, left_out = [], {}
    if not json:
        say(
            "Planning the paper's two inspection cases, a detour, a tank from a STEP file, and a boiler through which "
            "the way is searched.\n"
        )
    for name in bundled_tasks():
        try:
            task = load_task(name)
        except MissingExtraError as error:
            left_out[name] = str(error)
            if not json:
                say(f"{name} is left out: {error}\n")
            continue
        begin = time.perf_counter()
        with stages(f"planning {task.name}", json) as progress:
            made = plan(task, progress)
        seconds = time.perf_counter() - begin
        made.save(output / f"{name}.parquet")
        if not json:
            say(f"{made.summary()}\nplanned and verified in {seconds:.2f} s")
        with counting(f"drawing {task.name}", json) as bar:
            written = write_report(
                made,
                output / f"{name}.html",
                times=task.spec.report.times_s or None,
                animation=animation,
                progress=bar,
            )
        files = [str(output / f"{name}.parquet"), *(str(file) for file in written)]
        results.append(plan_json(made, seconds=seconds, files=files))
        if not json:
            say(f"written: {', '.join(files)}\n")
    if json:
        say_json({"good": True, "plans": results, "left_out": left_out})
    else:
        say(f"Open {output}/obstacle-array.html and {output}/pipe-tank.html to look at the motions.")
    return 0
