"""What is wrong where no route was found, and what could help."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hognose.planning.base_limits import BaseLimits
from hognose.planning.checks.mechanics import why_it_cannot_begin
from hognose.planning.task import Task
from hognose.planning.unfit_base import beyond_workspace
from hognose.route.fit.objective import Judged
from hognose.route.lengths import MOST_ARMS, too_far_to_search, way_length
from hognose.route.search.bottleneck import Gap, crowded, narrowest
from hognose.route.search.clearance_grid import ClearanceGrid
from hognose.route.why.changes import (
    Change,
    bendier,
    further,
    longer,
    narrower_margin,
    roomier,
    slower,
    thinner,
    together,
    wider_cone,
)

#: A limit of which less than this part is used is not what stands against a route: splines make use of a little more.
USED_UP = {"tip": 0.0, "bend": 0.93, "speed": 0.9, "reach": 0.95, "workspace": 0.95, "turn": 0.9}


@dataclass(frozen=True)
class Cause:
    """Why there is no route.

    Attributes
    ----------
    sentences
        What to say of it; none where the spline that came closest says more.
    changes
        What could help, the most plausible first.
    pair
        Two of them at once, where none helps alone.
    proven
        Whether there can be no route at all, found or not.
    limits
        Whether it is a matter of the arm's limits: splines show which ones.
    """

    sentences: tuple[str, ...]
    changes: tuple[Change, ...]
    pair: Change | None = None
    proven: bool = False
    limits: bool = False


def feed_speed(task: Task) -> float:
    """Feed speed (m/s) that a task asks for; 0 if it asks for none in particular."""
    return task.spec.motion.feed_speed


def plain_cause(task: Task) -> Cause | None:
    """Why there can be no route, where that is plain without a search; else None."""
    return _too_short(task) or _too_fast(task) or _does_not_stand(task) or _from_gap(task, crowded(task))


def likely_cause(task: Task, room: ClearanceGrid, closest: Judged | None, tried: bool = True) -> Cause:
    """Why a search found no route.

    Parameters
    ----------
    task
    room
        Its clearance field.
    closest
        The spline that came closest: limits that it does not use up are not what is wrong.
    tried
        Whether the search came so far as to try one passage.
    """
    narrow = _from_gap(task, narrowest(task, room))
    if narrow is not None:
        return narrow
    if closest is None and not tried:
        return _cause((), [])  # nothing was tried, so nothing is known of the way
    if closest is None:
        said = "there is a way wide enough, but none was found that the joints can bend along within the arm's length"
        return _cause((said,), [bendier(task), longer(task, 0.0), thinner(task, 0.0)])
    makers = {
        "tip": wider_cone,
        "bend": bendier,
        "speed": slower,
        "reach": lambda task: further(task, 0.0) or longer(task, 0.0),
        "workspace": roomier,
        "turn": slower,
    }
    # A wish about the tip is given up most easily; the other limits in the order in which they are used up.
    used = sorted(closest.overruns.items(), key=lambda item: (item[0] != "tip", -item[1]))
    changes = [makers[key](task) for key, part in used if part > USED_UP[key]]
    if closest.clearance < task.clearance_wanted:
        changes += [thinner(task, 0.0), narrower_margin(task, np.inf)]
    return _cause((), changes)


def _cause(sentences: tuple[str, ...], changes: list[Change]) -> Cause:
    possible = [change for change in changes if change.amounts]
    return Cause(sentences, tuple(possible), together(*possible[:2]) if len(possible) > 1 else None, limits=True)


def _too_short(task: Task) -> Cause | None:
    beyond = beyond_workspace(task)
    if beyond is not None:
        changes = (roomier(task, beyond[0]), longer(task, beyond[0]))
        return Cause((beyond[1],), tuple(change for change in changes if change.amounts), None, True)
    if too_far_to_search(task):
        said = (
            f"in a straight line the way is {1e3 * way_length(task):.1f} mm; no way longer than {MOST_ARMS:g} arms of "
            f"{1e3 * task.robot.length:g} mm is searched. Give `way_points` (or are `units` and `target` right?)"
        )
        return Cause((said,), ())
    reach = task.base.reach(task.robot)
    over = way_length(task) - reach
    if over <= 0:
        return None
    said = (
        f"the arm is at least {1e3 * over:.1f} mm too short: in a straight line the way is "
        f"{1e3 * way_length(task):.1f} mm, arm and {task.spec.base.mover} reach {1e3 * reach:.1f} mm"
    )
    change = further(task, over) or longer(task, over)
    if not change.amounts and over > task.robot.length:
        said += "; are `units` and `target` right?"
    elif not change.amounts:
        said += "; with so many more sections like its first it would not stand, or could not start"
    # A way that bends is longer still, and a sharp bend may be what it needs.
    return Cause((said,), (change,) if change.amounts else (), together(change, bendier(task)), True)


def _too_fast(task: Task) -> Cause | None:
    speed, fastest = feed_speed(task), BaseLimits.of(task).judged_speed
    if speed <= fastest * (1 + 1e-9):
        return None
    said = (
        f"the task feeds at {1e3 * speed:.4g} mm/s (motion.step in motion.period_s), the {task.spec.base.mover} at "
        f"most at {1e3 * fastest:g} mm/s"
    )
    return Cause((said,), (slower(task),), None, True)


def _does_not_stand(task: Task) -> Cause | None:
    """Every route begins with the straight arm before the entrance."""
    said = why_it_cannot_begin(task)
    if not said:
        return None
    return Cause(
        (f"the arm does not stand where every route begins, straight before the entrance: {said}",), (), None, True
    )


def _from_gap(task: Task, gap: Gap | None) -> Cause | None:
    """More bend or more length alone do not help where it is too narrow."""
    if gap is None:
        return None
    if gap.over is not None:
        change = further(task, gap.over) or longer(task, gap.over)
        return Cause(gap.sentences, (change,) if change.amounts else (), together(change, bendier(task)), gap.proven)
    if gap.closed:
        return Cause(gap.sentences, (), None, gap.proven)
    thin = thinner(task, gap.missing)
    changes = tuple(change for change in (thin, narrower_margin(task, gap.half)) if change.amounts)
    return Cause(gap.sentences, changes, together(thin, bendier(task)), gap.proven)
