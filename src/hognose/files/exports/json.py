"""Plans as JSON."""

from __future__ import annotations

import json

from hognose.files.exports.format import Export
from hognose.planning.plan import Plan
from hognose.planning.plan_file import metadata
from hognose.planning.plan_table import all_cells


def to_json(plan: Plan) -> bytes:
    """Metadata and columns as one JSON object: `{"hognose": {...}, "columns": {name: [...]}}`."""
    columns = {name: values.tolist() for name, values in all_cells(plan).items()}
    return json.dumps({"hognose": metadata(plan, plan.checks), "columns": columns}).encode()


EXPORT = Export(".json", "the plan file's metadata and columns as one object", to_json)
