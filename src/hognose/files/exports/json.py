"""Plans as JSON."""

from __future__ import annotations

import json
from typing import Any

from numpy.typing import NDArray

from hognose.files.exports.format import Export
from hognose.planning.base_words import base_figures, profile_figures
from hognose.planning.plan import Plan
from hognose.planning.plan_file import metadata
from hognose.planning.plan_table import all_cells


def to_json(plan: Plan) -> bytes:
    """Metadata and columns as one JSON object: `{"hognose": {...}, "columns": {name: [...]}}`.

    What the arm stands on and how its feed goes over time are in the metadata, too.
    """
    said = {**metadata(plan, plan.checks), "base": base_figures(plan.task), "profile": profile_figures(plan)}
    return of_cells(said, all_cells(plan))


def of_cells(said: dict[str, Any], cells: dict[str, NDArray[Any]]) -> bytes:
    """What is said of columns (T,), and these by name, as one object."""
    columns = {name: values.tolist() for name, values in cells.items()}
    return json.dumps({"hognose": said, "columns": columns}).encode()


EXPORT = Export(".json", "the plan file's metadata and columns as one object", to_json)
