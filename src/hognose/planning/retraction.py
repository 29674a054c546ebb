"""Out again: the insertion backwards, along the same path, judged by the same checks."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from hognose.errors import InfeasibleError
from hognose.planning.checks.check import faults
from hognose.planning.followed import method_of
from hognose.planning.motion_spec import Profile
from hognose.planning.plan import Plan
from hognose.planning.planner import insertion_plan
from hognose.planning.timing import SetPoints

_COLUMNS = ("joints", "angles", "cable_lengths", "motor_counts", "clearance", "base_pose")


def retraction(plan: Plan, progress: Callable[[str], None] = lambda stage: None) -> Plan:
    """The motion of a plan from its end to its start, checked.

    The set-points are those of the plan, bit for bit: an insertion and its retraction together end where they began,
    in the straight pose at feed 0. All limits are the same in both directions, so a profile that is the fastest one
    way is so the other way. Where the task gives the retraction a profile of its own, `motion.retraction_profile`, the
    set-points are those of that profile on the same path. Columns that Hognose does not know are left out: they are the
    insertion's.

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
    motion = plan.task.spec.motion
    own = motion.profile_of(not plan.retracts)
    turned = _backwards(plan) if own == motion.profile_of(plan.retracts) else _anew(plan, own, progress)
    if turned.task.moving:  # they stand elsewhere now
        turned = dataclasses.replace(turned, clearance=turned.clearance_now())
    result = dataclasses.replace(turned, extra={}).verified(progress)
    if not result.good:
        said = [check.sentence for check in faults(result.checks)]
        raise InfeasibleError(f"{plan.task.name}: no good retraction.\n  " + "\n  ".join(said), result)
    return result


def _backwards(plan: Plan) -> Plan:
    columns = {name: getattr(plan, name) for name in _COLUMNS}
    turned = {name: None if column is None else np.ascontiguousarray(column[::-1]) for name, column in columns.items()}
    points = SetPoints(plan.feed, plan.time).backwards()
    return dataclasses.replace(plan, feed=points.feed, time=points.time, **turned)


def _anew(plan: Plan, profile: Profile, progress: Callable[[str], None]) -> Plan:
    """The other way on the same path, with set-points of another profile."""
    length = float(plan.feed.max())
    # Not with `plan.follower`, which may remember: some methods go on from where they last were.
    method = method_of(plan.task, plan.path)
    made = insertion_plan(plan.task, plan.way_points, method, length, profile, progress)
    way = dataclasses.replace(plan, **{name: getattr(made, name) for name in ("feed", "time", *_COLUMNS)})
    return way if plan.retracts else _backwards(way)
