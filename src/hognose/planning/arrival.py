"""The feed at which the tip is on the target."""

from __future__ import annotations

import numpy as np

from hognose.errors import InfeasibleError
from hognose.following.exact import Exact
from hognose.following.sections import SectionFollower
from hognose.path import Path
from hognose.planning.followed import followed, method_of
from hognose.planning.task import Task
from hognose.planning.thresholds import FEED_SLACK
from hognose.planning.unfit_base import too_far
from hognose.robot.sections import MixedSections
from hognose.wording import point

#: A tip so close (m of path) to the target is on it; it is looked for at so many feeds.
_AT_TARGET, _MOST_TRIALS = 1e-12, 100


def arrival(task: Task, path: Path) -> float:
    """The feed (m) at which the tip is on the target.

    Parameters
    ----------
    task
    path
        The curve on which the joints glide: the task's path, or what the following method makes of it.

    Raises
    ------
    InfeasibleError
        If the first joint would have to go farther than its base takes it.
    """
    robot = task.robot
    if isinstance(robot.model, MixedSections):
        return _arrival_of_sections(task, path)
    backwards = path.reversed()
    chain, arcs = Exact(backwards, robot.link_lengths[::-1]).run_with_arcs(np.zeros(1))
    stand = task.base
    base, off_run = stand.feed_at(chain[0, -1], path.length - float(arcs[0, -1]))
    on_run = off_run < 1e-9
    reach = path.length - stand.run
    if base > stand.farthest * (1 + FEED_SLACK) or (not on_run and reach > robot.length):
        raise too_far(task, reach, f", and its first joint cannot leave {task.spec.base.words(stand)}")
    _refuse_folded_path(task, path, base if on_run else -1.0)
    return base


def _arrival_of_sections(task: Task, path: Path) -> float:
    """As `arrival`. Where sections bend along their length, the way back from the target is not known: feeds are tried.

    They are the zeros of how far the tip is beyond the target, on a path that goes on straight behind it; found by the
    rule of false position.
    """
    length, reach = task.robot.length, path.length - task.base.run
    method = method_of(task, path.with_end(length))
    assert isinstance(method, SectionFollower)
    low, high = max(path.length - 1.5 * length, 0.0), path.length - 0.5 * length
    if high <= 0.0 or low > task.base.farthest:
        raise too_far(task, reach, f", and its first joint cannot leave {task.spec.base.words(task.base)}")
    below, above = method.tip_arc(low) - path.length, method.tip_arc(high) - path.length
    if below > 0.0 or above < 0.0:
        raise InfeasibleError(
            f"the target at {point(path.point(path.length), 'g')} cannot be reached: the path is shorter than the arm, "
            "or so bent that the sections cannot follow it. Move the target or the way-points before it"
        )
    feed, side = low, 0
    for _ in range(_MOST_TRIALS):
        feed = (low * above - high * below) / (above - below)
        off = method.tip_arc(feed) - path.length
        if abs(off) < _AT_TARGET:
            break
        # An end that stays twice counts half.
        if off < 0.0:
            low, below, above, side = feed, off, above * (0.5 if side < 0 else 1.0), -1
        else:
            high, above, below, side = feed, off, below * (0.5 if side > 0 else 1.0), 1
    if feed > task.base.farthest * (1 + FEED_SLACK):
        raise too_far(task, reach, f", and its first joint cannot leave {task.spec.base.words(task.base)}")
    _refuse_folded_path(task, path, feed)
    return feed


def _refuse_folded_path(task: Task, path: Path, base: float) -> None:
    """The tip reaches the target only if following from the base comes out where following back from it began."""
    target = path.point(path.length)
    if base >= 0:
        try:
            tip = followed(task, path, [base], "exact" if task.robot.straight_links else None)[0, -1]
        except InfeasibleError:
            tip = task.base.start
        if np.linalg.norm(tip - target) < 1e-7:
            return
    or_base = ", or move base.position back" if task.spec.base.kind == "cart" else ""
    raise InfeasibleError(
        f"the target at {point(task.way_points[-1], 'g')} cannot be reached along this path: it lies too close beside "
        f"{task.spec.base.run}, or the path turns back within the length of a link. Move the target or the way-points "
        f"before it{or_base}."
    )
