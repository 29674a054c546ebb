"""`hognose check`."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter


def check(
    plan: str,
    /,
    *,
    task: str | None = None,
    json: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Check a plan anew, from its own columns; the verdict stored in the file is not believed.

    Parameters
    ----------
    plan
        A plan file (.parquet), or a task to plan first.
    task
        The task that the plan should be made for (.toml or a bundled one): what differs from it, its robot's values
        included, fails the check. Without it the task and the robot are what the plan file says they are.
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
