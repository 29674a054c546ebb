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
    """Verify a plan and write it for other programs; the suffix picks the format: .csv, .json or .parquet.

    A plan that is not good is written all the same, says so, and the code is 1.

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
    from hognose.files.exports.tables import export as write

    written = write(plan_of(plan, json), output)
    size = output.stat().st_size
    if json:
        failed = [check.sentence for check in written.checks if check.failed]
        more = {"error": "not a good plan: " + "; ".join(failed)} if failed else {}
        say_json({"good": written.good, "file": str(output), "bytes": size, "steps": len(written.time) - 1, **more})
    else:
        say(f"{output}: {len(written.time)} rows, {size / 1e3:.0f} kB" + ("" if written.good else "; NOT a good plan"))
        if not written.good:
            say(written.summary())
    return 0 if written.good else 1
