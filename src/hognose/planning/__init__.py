"""Task to plan, and the checks a plan must pass."""

import warnings
from typing import Any

from hognose.planning.checks import run_checks
from hognose.planning.checks.check import Check
from hognose.planning.drawn_arms import Draws
from hognose.planning.link_budgets import LinkBudget, Tolerances, tolerances
from hognose.planning.plan import Plan
from hognose.planning.planner import plan_along
from hognose.planning.retraction import retraction
from hognose.planning.task import Task, TaskSpec

__all__ = [
    "Check",
    "Draws",
    "LinkBudget",
    "Plan",
    "Task",
    "TaskSpec",
    "Tolerances",
    "plan_along",
    "retraction",
    "run_checks",
    "tolerances",
]


def plan(*arguments: Any, **options: Any) -> Plan:
    """The name of `plan_along` in version 0.1, for one version more; `hognose.plan` searches for routes, too."""
    warnings.warn("hognose.planning.plan is called plan_along now", DeprecationWarning, stacklevel=2)
    return plan_along(*arguments, **options)
