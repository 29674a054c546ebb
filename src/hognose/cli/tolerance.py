"""`hognose tolerance`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter, validators

from hognose.cli.options import Flag, PlanOrTask

if TYPE_CHECKING:
    from hognose.planning import Plan
    from hognose.planning.link_budgets import Tolerances


def tolerance(
    plan: PlanOrTask,
    /,
    *,
    draws: Annotated[int, Parameter(validator=validators.Number(gte=1, lte=1_000_000))] = 10_000,
    seed: int = 0,
    json: Flag = False,
) -> int:
    """Print what tolerances take of the clearance of every link, and how likely the margin is lost.

    Parameters
    ----------
    draws
        Arms that are drawn, with errors of all kinds.
    seed
        Of the random numbers.
    json
        Print the budget as JSON, in SI units.
    """
    from hognose.cli.console import plan_of, say, say_json, table
    from hognose.planning.link_budgets import tolerances

    made = plan_of(plan, json)
    found = tolerances(made, draws, abs(seed))
    if json:
        say_json(_as_json(made, found))
        return 0 if made.good else 1
    if found.links:
        say(f"{made.task.name}: what tolerances take of the clearance of each link, mm, where they take most\n")
        table(found.headings, found.rows)
        say(found.sums)
    else:
        say(f"{made.task.name}: what the timing of moving obstacles takes of the clearance to them\n")
    for sentence in found.sentences:
        say(sentence)
    lines = made.summary().splitlines()
    verdict = next(place for place, line in enumerate(lines) if line.startswith(("GOOD", "NOT ")))
    for line in lines[verdict:]:
        say(line)
    return 0 if made.good else 1


def _as_json(made: Plan, found: Tolerances) -> dict[str, Any]:
    from hognose.planning.link_budgets import SHARES

    drawn = found.draws
    return {
        "good": made.good,
        "task": made.task.name,
        "links": [
            {
                "link": link.link,
                "step": link.step,
                "parts_m": link.parts,
                "taken_m": link.taken,
                "left_m": link.left,
                "left_is_lower_bound": link.left_is_lower_bound,
            }
            for link in found.links
        ],
        "timing": [
            {
                "obstacle": each.obstacle,
                "timing_s": each.timing,
                "taken_m": each.taken,
                "left_m": each.left,
                "left_is_lower_bound": each.left >= each.horizon,
            }
            for each in found.timings
        ],
        "assumed": sorted(found.assumed),
        "certified_clearance_m": made.certified_clearance,
        "margin_m": made.task.margin,
        "draws": None
        if drawn is None
        else {
            "count": len(drawn.clearance),
            "below_margin": drawn.loses,
            "touching": drawn.touches,
            "quantiles_m": {f"{share:g}": drawn.quantile(share) for share in SHARES},
            "quantiles_are_lower_bounds": {f"{share:g}": drawn.is_lower_bound(share) for share in SHARES},
        },
    }
