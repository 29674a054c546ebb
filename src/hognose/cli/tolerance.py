"""`hognose tolerance`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter
from cyclopts.validators import Number

from hognose.cli.options import Flag, PlanOrTask

if TYPE_CHECKING:
    from hognose.planning import Plan
    from hognose.planning.link_budgets import Tolerances

#: Shares of drawn arms whose clearance is said.
SHARES = (0.01, 0.05, 0.5)


def tolerance(
    plan: PlanOrTask,
    /,
    *,
    draws: Annotated[int, Parameter(validator=Number(gte=1, lte=1_000_000))] = 10_000,
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
    say(f"{made.task.name}: what tolerances take of the clearance of each link, mm, where they take most\n")
    names = found.budget.given
    table(
        ("link", *(found.budget.label(name) for name in names), "together", "step", "leaves at least"),
        [
            [
                str(link.link),
                *(f"{1e3 * link.parts[name]:.2f}" for name in names),
                f"{1e3 * link.taken:.2f}",
                str(link.step),
                f"{1e3 * link.left:.2f}",
            ]
            for link in found.links
        ],
    )
    say("Bounds (CAD, sag) add; of the others, each at 2σ, the squares add.")
    say(found.headline)
    for line in _chances(found):
        say(line)
    lines = made.summary().splitlines()
    verdict = next(place for place, line in enumerate(lines) if line.startswith(("GOOD", "NOT ")))
    for line in lines[verdict:]:
        say(line)
    return 0 if made.good else 1


def _chances(found: Tolerances) -> list[str]:
    drawn = found.draws
    closer = ", ".join(f"{share:.0%} closer than {1e3 * drawn.quantile(share):.2f} mm" for share in SHARES)
    return [
        f"of {len(drawn.clearance):,} drawn arms {drawn.loses:.2%} come closer than the margin of "
        f"{1e3 * drawn.margin:g} mm, {drawn.touches:.2%} touch; {closer}",
    ]


def _as_json(made: Plan, found: Tolerances) -> dict[str, Any]:
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
            }
            for link in found.links
        ],
        "assumed": sorted(found.budget.assumed),
        "certified_clearance_m": made.certified_clearance,
        "margin_m": drawn.margin,
        "draws": {
            "count": len(drawn.clearance),
            "below_margin": drawn.loses,
            "touching": drawn.touches,
            "quantiles_m": {f"{share:g}": drawn.quantile(share) for share in SHARES},
        },
    }
