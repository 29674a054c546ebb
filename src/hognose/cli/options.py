"""Parameters that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from hognose.cli.completers import shown, tasks, tasks_and_plans, tasks_and_spaces

#: An option that is either there or not, without a `--no-…`.
Flag = Annotated[bool, Parameter(negative="")]
#: An option that may be given several times.
Several = Annotated[tuple[str, ...], Parameter(negative="")]
#: Where to write.
Output = Annotated[Path, Parameter(name=["--output", "-o"])]
#: The same, with a default that depends on something else.
OptionalOutput = Annotated[Path | None, Parameter(name=["--output", "-o"])]
#: What commands read that show a plan or judge it.
PlanOrTask = Annotated[
    str, Parameter(help="A plan file (.parquet), or a task to plan first.", completer=tasks_and_plans)
]
#: The name of a task, or the file of one.
TaskName = Annotated[str, Parameter(completer=tasks)]
#: A task, or the file of a space.
TaskOrSpace = Annotated[str, Parameter(completer=tasks_and_spaces)]
#: Whatever the viewer shows.
Shown = Annotated[str, Parameter(completer=shown)]
#: A unit of length.
Unit = Literal["mm", "cm", "m", "in"]
