"""`hognose export`."""

from __future__ import annotations

from hognose.cli.options import Flag, Output, PlanOrTask


def export(plan: PlanOrTask, /, output: Output, *, json: Flag = False) -> int:
    """Verify a plan and write it for other programs; the suffix, as in plan.csv, determines the format.

    The message about an unknown suffix lists all formats, with those that installed packages add. A plan that is not
    good is written too, with a message and exit code 1.

    Parameters
    ----------
    output
        The file to write. CSV and Parquet have the same columns, in SI units.
    json
        Print a summary of the written file as JSON.
    """
    from hognose.cli.console import plan_of, say, say_json
    from hognose.files.exports import export as write
    from hognose.planning.checks.check import faults

    written = write(plan_of(plan, json), output)
    size = output.stat().st_size
    if json:
        why = "; ".join(check.sentence for check in faults(written.checks))
        more = {} if written.good else {"error": f"not a good plan: {why}"}
        say_json({"good": written.good, "file": str(output), "bytes": size, "steps": len(written.time) - 1, **more})
    else:
        say(f"{output}: {len(written.time)} rows, {size / 1e3:.0f} kB" + ("" if written.good else "; NOT a good plan"))
        if not written.good:
            say(written.summary())
    return 0 if written.good else 1
