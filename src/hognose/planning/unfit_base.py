"""Bases from which no motion of a task can begin, or none can end on its target: said before one is planned."""

from __future__ import annotations

import numpy as np

from hognose.errors import InfeasibleError, InputError
from hognose.planning.task import Task
from hognose.robot.base import SAME_PLACE
from hognose.wording import beside_limit, mm, point

#: Places are said to this (m): what is computed from them is not exact.
_WRITTEN = 9


def refuse_unfit_base(task: Task) -> None:
    """Raise an InputError if the arm cannot stand where it starts: outside a workspace, or past the entrance."""
    _refuse_start_outside(task)
    _refuse_nose_past_entrance(task)


def refuse_distant_target(task: Task) -> None:
    """Raise an InfeasibleError before anything is made of a path that no motion of this arm can take."""
    beyond = beyond_workspace(task)
    if beyond is not None:
        raise InfeasibleError(f"{task.name}: {beyond[1]}")
    if task.base.follows:
        return
    reach = task.path_through(task.way_points).length - task.base.run
    if reach > 2 * task.robot.length:
        raise too_far(task, reach, last=" (or check the file's `units`)")


def too_far(task: Task, reach: float, because: str = "", last: str = "") -> InputError | InfeasibleError:
    """The error of a path that is too long (m) for the arm; an InputError if a cart stands beside the entrance.

    `because` and `last` are what else is said of the path and of what to try. While a route is searched, other paths
    may be short enough: of one of them it is always an InfeasibleError.
    """
    cart, length = len(task.way_points) > len(task.spec.path.stops), 1e3 * task.robot.length
    begin = f"the nose of the straight arm at {_written(task.way_points[0])}" if cart else "the entrance"
    said = f"the target is too far: the path from {begin} to it is {1e3 * reach:.3f} mm long, the arm {length:.3f} mm"
    otherwise = f"ove the target, straighten the path, or take a longer arm{last}."
    if cart and task.spec.path.target is None:
        along, off = np.array(task.spec.base.along), task.way_points[0] - task.way_points[1]
        beside = float(np.linalg.norm(off - (off @ along) * along))
        if beside > task.robot.body_radii.max():
            return InputError(
                f"base.position: {said}{because}. The nose is {mm(beside, '.6g')} beside the entrance at "
                f"{_written(task.way_points[1])}: move base.position, to {_written(task.base.start - off)} to have it "
                f"there; or m{otherwise}"
            )
    return InfeasibleError(f"{said}{because}. M{otherwise}")


def beyond_workspace(task: Task) -> tuple[float, str] | None:
    """By how much (m) the arm is too short to get to the target from inside the workspace, and a sentence; or None."""
    target = task.way_points[-1:]
    away, length = round(float(np.linalg.norm(task.base.outside(target))), _WRITTEN), task.robot.length
    if away <= length + SAME_PLACE:
        return None
    shown, limit = beside_limit(1e3 * away, 1e3 * length, lower_bound=False)
    return away - length, (
        f"the target at {point(target[0], 'g')} is {shown} mm from base.workspace, in which the first joint stays, and "
        f"the arm is {limit} mm long; move the target, enlarge the workspace, or take a longer arm"
    )


def _refuse_start_outside(task: Task) -> None:
    """A workspace that the first joint would have to come into."""
    start = task.base.start
    out = float(np.linalg.norm(task.base.outside(start[None])))
    box = task.spec.base.workspace
    if box is None or out == 0.0:
        return
    raise InputError(
        f"base.workspace: at feed 0 the first joint, at {_written(start)}, is {mm(out, '.4g')} outside it; expected "
        f"within {point(box.low, 'g')} and {point(box.high, 'g')}. Enlarge the workspace, or move the entrance: the "
        "straight arm lies in front of it"
    )


def _refuse_nose_past_entrance(task: Task) -> None:
    """A cart whose straight arm is in the entrance already, so that the path would fold back."""
    nose, entrance = task.nose, np.array(task.spec.path.stops[0])
    if nose is None:
        return
    along = np.array(task.spec.base.along)
    past = float((nose - entrance) @ along)
    beside = float(np.linalg.norm(nose - entrance - past * along))
    if past <= SAME_PLACE or beside > task.robot.body_radii.max():
        return
    position = np.array(task.spec.base.position) - past * along
    raise InputError(
        f"base.position: the nose of the straight arm, at {_written(nose)}, is {mm(past, '.6g')} past the entrance at "
        f"{_written(entrance)}; expected before it. Move base.position back, to {_written(position)} or farther, or "
        "begin path.way_points in front of the nose"
    )


def _written(place: np.ndarray) -> str:
    return point(np.round(place, _WRITTEN), "g")
