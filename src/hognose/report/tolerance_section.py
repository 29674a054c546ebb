"""What the report says of tolerances, and the words it shares with the viewer's page."""

from __future__ import annotations

from html import escape

from hognose.planning import Plan, Task, tolerances
from hognose.report.page import heading, table

#: What the numbers of a table of links are.
CAPTION = (
    "What tolerances take of the clearance of each link, in mm, at the step where they take most; last, the "
    "smallest clearance that they leave at any step."
)


def has_tolerances(task: Task) -> bool:
    """Whether a budget can be made: there are tolerances, or obstacles that may be early or late."""
    return task.budget is not None or any(each.timing for each in task.moving)


def tolerance_section(plan: Plan) -> list[str]:
    """What tolerances take of clearances, as HTML; nothing without tolerances."""
    if not has_tolerances(plan.task):
        return []
    found = tolerances(plan)
    words = [heading("Tolerances"), *(f"<p>{escape(text)}</p>" for text in found.sentences)]
    if not found.links:
        return words
    body = table(found.headings, found.rows, numbers=range(1, len(found.headings)))
    return [*words, f"<p>{escape(CAPTION)}</p>", body, f"<p>{escape(found.sums)}</p>"]
