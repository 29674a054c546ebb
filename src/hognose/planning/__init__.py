"""Task to plan, and the checks a plan must pass."""

from hognose.planning.checks import run_checks
from hognose.planning.checks.check import Check
from hognose.planning.plan import Plan
from hognose.planning.planner import plan_along
from hognose.planning.retraction import retraction
from hognose.planning.task import Task, TaskSpec

__all__ = [
    "Check",
    "Plan",
    "Task",
    "TaskSpec",
    "plan_along",
    "retraction",
    "run_checks",
]
