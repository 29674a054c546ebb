"""Plans that a check refuses along whatever route: no other one need be searched then."""

from __future__ import annotations

from collections.abc import Sequence

from hognose.planning.checks import Check, criteria
from hognose.planning.checks.run import OWN
from hognose.planning.plan import Plan

#: So many plans in a row that fail a check with the very same verdict, and another route will not pass it either.
ALIKE = 3


def unmendable(refused: Sequence[Plan]) -> Check | None:
    """The failure of the last plan that no other route is likely to mend, if there is one.

    It is that of a criterion that says so (`Criterion.mendable`), or the very same verdict of a criterion from a script
    or another package on the last plans, each along another route. What Hognose's own criteria find depends on the
    route.
    """
    if not refused:
        return None
    found = {each.key: each for each in criteria()}
    own = {each.key for each in OWN}
    for check in refused[-1].checks:
        if not check.failed or check.key not in found:
            continue
        if not found[check.key].mendable:
            return check
        if check.key not in own and len(refused) >= ALIKE and all(_has(plan, check) for plan in refused[-ALIKE:]):
            return check
    return None


def _has(plan: Plan, check: Check) -> bool:
    """Whether a plan has the same verdict; compared as text, in which NaN is NaN."""
    return any(repr(each) == repr(check) for each in plan.checks)
