"""`hognose log`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from hognose.cli.completers import records
from hognose.cli.options import Flag

if TYPE_CHECKING:
    from hognose.drive.record.summary import Summary


def log(
    record: Annotated[str, Parameter(completer=records)],
    /,
    *,
    recover: Path | None = None,
    figure: Path | None = None,
    plan: Path | None = None,
    json: Flag = False,
) -> int:
    """Summarise the record of a run: how it ended, what happened, and how far commands were from the plan.

    A record that was cut off, as when the program was killed or the power failed, is read up to its last whole message.

    Parameters
    ----------
    record
        A record that `hognose run` has written (.mcap).
    recover
        Write all whole messages into this file (.mcap), with an end and an index, for programs that need them.
    figure
        Draw place along the plan, tensions and following errors over time into this file, .png or .svg.
    plan
        Compare with this plan file (.parquet), not with the plan in the record.
    json
        Print the figures as JSON, in SI units.
    """
    from hognose.cli.console import say_json
    from hognose.drive.record import read_record
    from hognose.drive.record import recover as write_recovered
    from hognose.drive.record.summary import summary
    from hognose.planning import plan_file

    _refuse(record, recover, figure)
    found = summary(read_record(record), None if plan is None else plan_file.read(plan).motion)
    files: dict[str, str] = {}
    if recover is not None:
        write_recovered(record, recover)
        files["recovered"] = str(recover)
    if figure is not None:
        from hognose.drive.record.chart import chart
        from hognose.report.style import png, svg
        from hognose.write_whole import write_whole

        write_whole(figure, (svg if figure.suffix.lower() == ".svg" else png)(chart(found.record)))
        files["figure"] = str(figure)
    if json:
        say_json(found.to_json() | files)
        return 0
    _say(record, found, files)
    return 0


def _say(name: str, found: Summary, files: dict[str, str]) -> None:
    """Print for people; `files` are those that were written, with what they hold."""
    from hognose.cli.console import say, table

    said = found.record.said
    say(f"{name}: {said['task']}, {said['robot']}, {found.record.start:%Y-%m-%d %H:%M:%S} UTC\n")
    table(("what", "figure", "where"), found.rows)
    for event in found.record.events:
        say(f"  {event.words}")
    say(f"plan: {found.compared.words}")
    for words in found.remarks:
        say(f"note: {words}")
    say(f"verdict: {found.verdict}")
    for what, file in files.items():
        say(f"{file}: {what}")


def _refuse(record: str, recover: Path | None, figure: Path | None) -> None:
    """Raise an InputError if a file cannot be written, before anything is read."""
    from hognose.cli.console import refuse_target
    from hognose.errors import InputError

    for file, suffixes in ((recover, (".mcap",)), (figure, (".png", ".svg"))):
        if file is None:
            continue
        if file.suffix.lower() not in suffixes:
            raise InputError(f"{file}: the name of this file must end in {' or '.join(suffixes)}")
        refuse_target(file, record)
