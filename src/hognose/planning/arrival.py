"""The feed at which the tip is on the target."""

from __future__ import annotations

from collections.abc import Callable

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
#: Strides of feeds that are tried, in arm lengths; and from where on it is believed that the arm cannot be followed.
_STRIDE, _SMALLEST_STRIDE = 1 / 16, 1e-3
#: A feed, and how far (m) the tip is beyond the target there.
Tried = tuple[float, float]


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
    robot, reach = task.robot, path.length - task.base.run
    method = method_of(task, path.with_end(robot.length))
    assert isinstance(method, SectionFollower)

    def beyond(feed: float) -> float:
        return method.tip_arc(feed) - path.length

    (low, below), (high, above) = _on_both_sides(task, path, beyond)
    if above < 0.0:
        raise too_far(task, reach, f", and its first joint cannot leave {task.spec.base.words(task.base)}")
    if below > 0.0:
        raise InfeasibleError(
            f"the target at {point(path.point(path.length), 'g')} cannot be reached: the path is shorter than the arm, "
            "or so bent that the sections cannot follow it. Move the target or the way-points before it"
        )
    feed, side = low, 0
    for _ in range(_MOST_TRIALS):
        feed = (low * above - high * below) / (above - below)
        off = beyond(feed)
        if abs(off) < _AT_TARGET:
            break
        # An end that stays twice counts half.
        if off < 0.0:
            low, below, above, side = feed, off, above * (0.5 if side < 0 else 1.0), -1
        else:
            high, above, below, side = feed, off, below * (0.5 if side > 0 else 1.0), 1
    _refuse_folded_path(task, path, feed)
    return feed


def _on_both_sides(task: Task, path: Path, beyond: Callable[[float], float]) -> tuple[Tried, Tried]:
    """Feeds with the tip before and behind the target, and how far beyond it is (m); one twice if there is no other.

    They are sought in strides from where the arm would be if it were as long as its path; a stride to where it cannot
    be followed is halved, as that may lie behind what is sought.
    """
    length, farthest = task.robot.length, task.base.farthest * (1 + FEED_SLACK)
    at = min(max(path.length - length, 0.0), farthest)
    last, stride = (at, beyond(at)), _STRIDE * length
    end = min(farthest, path.length) if last[1] < 0.0 else 0.0
    while last[0] != end:
        to = min(last[0] + stride, end) if last[1] < 0.0 else max(last[0] - stride, end)
        try:
            found = (to, beyond(to))
        except InfeasibleError:
            stride *= 0.5
            if stride < _SMALLEST_STRIDE * length:
                raise
            continue
        if (found[1] < 0.0) != (last[1] < 0.0):
            return (last, found) if last[1] < 0.0 else (found, last)
        last = found
    return last, last


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
