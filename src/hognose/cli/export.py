"""`hognose export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def export(
    plan: str,
    /,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    *,
    json: Annotated[bool, Parameter(negative="")] = False,
) -> int:
    """Write a plan for other programs; the suffix picks the format: .csv, .json or .parquet.

    Parameters
    ----------
    plan
        A plan file (.parquet), or a task to plan first.
    output
        The file to write. CSV and Parquet have the same columns, in SI units.
    json
        Say what was written as JSON.
    """
    from hognose.cli.console import plan_of, say, say_json
    from hognose.files import export as write

    loaded = plan_of(plan, json)
    write(loaded, output)
    size = output.stat().st_size
    if json:
        say_json({"good": loaded.good, "file": str(output), "bytes": size, "steps": len(loaded.time) - 1})
    else:
        say(f"{output}: {len(loaded.time)} rows, {size / 1e3:.0f} kB" + ("" if loaded.good else "; NOT a good plan"))
    return 0 if loaded.good else 1
