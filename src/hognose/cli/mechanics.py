"""`hognose mechanics`."""

from __future__ import annotations

from pathlib import Path

from hognose.cli.options import Flag, PlanOrTask


def mechanics(
    plan: PlanOrTask,
    /,
    *,
    figure: Path | None = None,
    json: Flag = False,
) -> int:
    """Print what the cables must pull, how far the arm is from buckling, and how far its tip hangs or is moved.

    Parameters
    ----------
    figure
        Draw tensions, load factor and sag over time into this file, .png or .svg.
    json
        Print the figures of all steps as JSON, in SI units.
    """
    from hognose.cli.console import plan_of, refuse_target, say, say_json, table
    from hognose.errors import InputError
    from hognose.planning.loads import HEADINGS, loads

    if figure is not None:
        if figure.suffix.lower() not in (".png", ".svg"):
            raise InputError(f"{figure}: the name of this file must end in .png or .svg")
        refuse_target(figure, plan)
    made = plan_of(plan, json)
    found = loads(made)
    if figure is not None:
        from hognose.report import mechanics as chart
        from hognose.report.style import png, svg
        from hognose.write_whole import write_whole

        write_whole(figure, (svg if figure.suffix.lower() == ".svg" else png)(chart.mechanics(found)))
    if json:
        files = {} if figure is None else {"file": str(figure)}
        say_json({"good": made.good, "task": made.task.name, **files, **found.to_json()})
        return 0 if made.good else 1
    say(f"{made.task.name}: will the arm hold it?\n")
    table(HEADINGS, found.rows)
    for sentence in found.sentences:
        say(sentence)
    lines = made.summary().splitlines()
    verdict = next(place for place, line in enumerate(lines) if line.startswith(("GOOD", "NOT ")))
    for line in lines[verdict:]:
        say(line)
    if figure is not None:
        say(f"{figure}: tensions, load factor and sag over time")
    return 0 if made.good else 1
