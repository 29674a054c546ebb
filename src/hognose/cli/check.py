"""`hognose check`."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter


def check(plan: str, /, *, json: Annotated[bool, Parameter(negative="")] = False) -> int:
    """Check a plan anew, from its own columns; the verdict stored in the file is not believed.

    Parameters
    ----------
    plan
        A plan file (.parquet), or a task to plan first.
    json
        Print figures and verdicts as JSON.
    """
    import dataclasses

    from hognose.cli.console import plan_json, plan_of, say, say_checks, say_json, stages
    from hognose.planning import run_checks

    loaded = plan_of(plan, json)
    with stages("checking", json) as progress:
        checked = dataclasses.replace(loaded, checks=run_checks(loaded, progress))
    if json:
        say_json(plan_json(checked))
    else:
        say_checks(checked.checks)
        say("")
        say(checked.summary())
    return 0 if checked.good else 1
