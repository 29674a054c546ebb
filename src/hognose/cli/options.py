"""Parameters that several commands have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

#: An option that is either there or not, without a `--no-…`.
Flag = Annotated[bool, Parameter(negative="")]
#: Where to write.
Output = Annotated[Path, Parameter(name=["--output", "-o"])]
#: The same, with a default that depends on something else.
OptionalOutput = Annotated[Path | None, Parameter(name=["--output", "-o"])]
#: What commands read that show a plan or judge it.
PlanOrTask = Annotated[str, Parameter(help="A plan file (.parquet), or a task to plan first.")]
