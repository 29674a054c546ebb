"""Exports of a plan for other programs: CSV with the plan file's columns, JSON, and the plan file itself."""

from __future__ import annotations

import io
import json
from pathlib import Path

from hognose.arguments import file_name, instance
from hognose.errors import InputError
from hognose.planning.plan import Plan
from hognose.planning.plan_file import metadata, to_parquet, to_table
from hognose.write_whole import write_whole


def to_csv(plan: Plan) -> bytes:
    """The plan's columns as CSV; numbers read back bit for bit."""
    from pyarrow import csv

    buffer = io.BytesIO()
    csv.write_csv(to_table(plan, plan.checks), buffer, csv.WriteOptions(quoting_style="none"))
    return buffer.getvalue()


def to_json(plan: Plan) -> bytes:
    """Metadata and columns as one JSON object: `{"hognose": {...}, "columns": {name: [...]}}`."""
    return json.dumps(
        {"hognose": metadata(plan, plan.checks), "columns": to_table(plan, plan.checks).to_pydict()}
    ).encode()


def _to_parquet(plan: Plan) -> bytes:
    return to_parquet(plan, plan.checks)


#: Export formats by file suffix.
FORMATS = {".csv": to_csv, ".json": to_json, ".parquet": _to_parquet}


def export(plan: Plan, path: Path | str) -> Plan:
    """Verify a plan and write it in the format its suffix names.

    Returns
    -------
    Plan
        The plan as it was written, with its new verdict, good or not: what fails is written as such.

    Raises
    ------
    InputError
        Unknown suffix, or the file cannot be written.
    """
    instance("plan", plan, Plan, "a hognose.Plan")
    path = file_name("path", path)
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"{path}: unknown format {path.suffix!r}; expected {', '.join(FORMATS)}")
    verified = plan.verified()
    write_whole(path, FORMATS[path.suffix.lower()](verified))
    return verified
