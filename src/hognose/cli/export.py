"""`hognose export`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from hognose.cli.completers import exported
from hognose.cli.options import Flag, OptionalOutput

if TYPE_CHECKING:
    from hognose.files.exports import Export, Exported
    from hognose.planning import Plan, Task
    from hognose.robot import Robot


def export(
    source: Annotated[str, Parameter(completer=exported)],
    /,
    output: OptionalOutput = None,
    *,
    to: str | None = None,
    json: Flag = False,
) -> int:
    """Verify a plan and write it for other programs, or arm and space as a model: MJCF for MuJoCo, or URDF.

    For motor controllers there are a bag of ROS 2 with trajectories of all joints, and a CSV for each axis.

    The suffix, as in plan.csv, determines the format, or `--to` names it. The message about an unknown one lists all
    formats, with those that installed packages add. A plan that is not good is written too, with a message and exit
    code 1.

    Parameters
    ----------
    source
        A plan file (.parquet), or a task; for CSV, JSON and Parquet it is planned first. For MJCF and URDF a task is
        exported without a motion, and a robot (name or .toml) alone.
    output
        The file to write; with `--to`, by default the source's name with the format's suffix, in this folder. CSV and
        Parquet have the same columns, in SI units.
    to
        The format: csv, json, parquet, mjcf, urdf, ros2, axes, or one of another package.
    json
        Print a summary of the written file as JSON.
    """
    from hognose.files.exports import export as write

    target, chosen = _target(source, output, to)
    written = write(_source(source, chosen, json), target)
    _say(target, written, json)
    return 0 if written.plan is None or written.plan.good else 1


def _target(source: str, output: Path | None, to: str | None) -> tuple[Path, Export | None]:
    """The file to write and its format; None of a suffix that is not known."""
    from hognose.cli.console import output_file
    from hognose.errors import InputError
    from hognose.files.exports import export_format, formats

    if to is not None:
        chosen = export_format(to)
        return output_file(output, source, chosen.suffix), chosen
    if output is None:
        raise InputError("name the file to write with --output, as in -o plan.csv, or its format with --to, as in mjcf")
    return output, formats().get(output.suffix.lower())


def _source(source: str, chosen: Export | None, quiet: bool) -> Plan | Task | Robot:
    """What to write: a robot or a task as it is where the format takes it, else the plan."""
    from hognose.cli.console import plan_of
    from hognose.files import describes_robot, load_robot, load_task

    if describes_robot(source):
        return load_robot(source)
    if chosen is not None and chosen.of_task is not None and not source.endswith(".parquet"):
        return load_task(source)
    return plan_of(source, quiet)


def _say(target: Path, written: Exported, as_json: bool) -> None:
    from hognose.cli.console import say, say_json
    from hognose.planning.checks.check import faults

    plan, beside, remarks, size = written.plan, written.beside, written.remarks, target.stat().st_size
    if as_json:
        told: dict[str, Any] = {"good": None if plan is None else plan.good, "file": str(target), "bytes": size}
        if plan is not None:
            told["steps"] = len(plan.time) - 1
        if plan is not None and not plan.good:
            told["error"] = f"not a good plan: {'; '.join(check.sentence for check in faults(plan.checks))}"
        if beside:
            told["beside"] = [str(file) for file in beside]
        if remarks:
            told["remarks"] = list(remarks)
        say_json(told)
        return
    rows = "" if plan is None else f"{len(plan.time)} rows, "
    more = f", and {len(beside)} meshes in {beside[0].parent}" if beside else ""
    say(f"{target}: {rows}{size / 1e3:.0f} kB{more}{'' if plan is None or plan.good else '; NOT a good plan'}")
    for words in remarks:
        say(f"note: {words}")
    if plan is not None and not plan.good:
        say(plan.summary())
