"""Out again: the insertion backwards, along the same path, judged by the same checks."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from hognose.errors import InfeasibleError
from hognose.planning.checks.check import faults
from hognose.planning.plan import Plan
from hognose.planning.timing import SetPoints


def retraction(plan: Plan, progress: Callable[[str], None] = lambda stage: None) -> Plan:
    """The motion of a plan from its end to its start, checked.

    The set-points are those of the plan, bit for bit: an insertion and its retraction together end where they began,
    in the straight pose at feed 0. Columns that Hognose does not know are left out: they are the insertion's.

    Parameters
    ----------
    plan
        An insertion.
    progress
        As of `hognose.plan`.

    Returns
    -------
    Plan
        A good one.

    Raises
    ------
    InfeasibleError
        A check failed, or nothing can be checked; its `plan` is the retraction.
    """
    columns = ("joints", "angles", "cable_lengths", "motor_counts", "clearance")
    turned = {name: np.ascontiguousarray(getattr(plan, name)[::-1]) for name in columns}
    points = SetPoints(plan.feed, plan.time).backwards()
    result = dataclasses.replace(plan, feed=points.feed, time=points.time, extra={}, **turned).verified(progress)
    if not result.good:
        said = [check.sentence for check in faults(result.checks)]
        raise InfeasibleError(f"{plan.task.name}: no good retraction.\n  " + "\n  ".join(said), result)
    return result
