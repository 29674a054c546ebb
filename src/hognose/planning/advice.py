"""What to try where a motion fails for one reason alone."""

from __future__ import annotations

from hognose.planning.plan import Plan
from hognose.wording import at_least_mm


def of_tolerances(plan: Plan) -> str | None:
    """A sentence if only what tolerances take is missing of the margin to obstacles; else None.

    The plan has checks that failed.
    """
    task, room = plan.task, float(plan.clearance.min(initial=plan.horizon))
    short = any(check.failed and check.key.startswith(("clearance_at", "certified")) for check in plan.checks)
    if task.budget is None or not short or room < task.margin:
        return None
    beyond = room >= plan.horizon
    return (
        f"without tolerances {'≥ ' if beyond else ''}{at_least_mm(room)} mm would be left at the steps: tolerances "
        "take more than the way has room for. Calibrate or register more closely (`hognose tolerance` says what takes "
        "most), lower the margin, or give `way_points` or a `target` with more room around the way."
    )
