"""The checks that a plan must pass, each an object in a list.

A criterion is added by appending it to `ALL`, by giving it to `Plan.verified`, or by a package that names it, or a
list of such, under the entry points `hognose.checks`.
"""

from hognose.planning.checks.check import Check
from hognose.planning.checks.criterion import Criterion
from hognose.planning.checks.findings import least, most, not_judged
from hognose.planning.checks.run import ALL, criteria, run_checks
from hognose.planning.checks.shared import Shared

__all__ = [
    "ALL",
    "Check",
    "Criterion",
    "Shared",
    "criteria",
    "least",
    "most",
    "not_judged",
    "run_checks",
]
