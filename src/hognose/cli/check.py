"""`hognose check`."""

from __future__ import annotations

from hognose.cli.options import Flag, PlanOrTask


def check(plan: PlanOrTask, /, *, task: str | None = None, json: Flag = False) -> int:
    """Recompute every check of a plan from its columns; the verdict stored in the file is ignored.

    Parameters
    ----------
    task
        The task that the plan should be made for (.toml or a bundled one): any difference from it, or from its robot,
        fails the check. Without this option, the task and the robot in the plan file are used.
    json
        Print figures and verdicts as JSON: of every check its key, name, value and limit in SI units, and place.
    """
    from hognose.cli.console import plan_json, plan_of, say, say_checks, say_json
    from hognose.files import load_task
    from hognose.planning.origin import made_for

    source = None if task is None else load_task(task)
    checked = plan_of(plan, json)
    if source is not None:
        checked = made_for(checked, source)
    if json:
        say_json(plan_json(checked))
    else:
        say_checks(checked.checks)
        say("")
        say(checked.summary())
    return 0 if checked.good else 1
