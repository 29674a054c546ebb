"""The search for a route to a target: where obstacles move, first clear of wherever they ever are."""

from __future__ import annotations

from collections.abc import Callable

from hognose.errors import HognoseError
from hognose.planning.plan import Plan
from hognose.planning.planner import plan_along, refuse_buried_places
from hognose.planning.task import Task
from hognose.route.around_moving import around_moving
from hognose.route.search.search import Search
from hognose.route.why.causes import plain_cause

#: Of the time for a search, the part after which none is looked for any more that is clear of all ways of what moves.
FOR_ALL_WAYS = 0.5


def search_route(task: Task, begin: Callable[[Task], Search]) -> tuple[Search, Plan | None]:
    """Search a route, and plan along the best one.

    Where obstacles move, it is searched clear of wherever they ever are: that is good whatever the time. If there is no
    such route, they are left to the checks: a route is searched among what stands still, and is good if the arm meets
    them nowhere at any time. Both take no more time together than one search.

    Parameters
    ----------
    task
        With a target.
    begin
        Makes a search for a route of a task that is not begun yet.

    Returns
    -------
    Search
        The last one: where it found nothing, it knows why.
    Plan or None
        Of the task.

    Raises
    ------
    InputError
        See `refuse_buried_places`.
    KeyboardInterrupt
        Ctrl-C before a route was found; its text says how far the search was.
    """
    refuse_buried_places(task)
    began = None
    if task.moving:
        search, made = _clear_of_all_ways(task, begin)
        if made is not None:
            return search, made
        began = search.began
    search = begin(task)
    search.began = search.began if began is None else began
    _run(search)
    return search, None if search.best is None else search.best.plan


def _clear_of_all_ways(task: Task, begin: Callable[[Task], Search]) -> tuple[Search, Plan | None]:
    """The search among obstacles that stand everywhere they ever are, and a plan of the task along its best route."""
    search = begin(around_moving(task))
    search.gives_up = FOR_ALL_WAYS
    try:
        refuse_buried_places(search.task)
        _run(search)
        if search.best is None:
            return search, None
        return search, plan_along(task, search.progress, search.best.plan.way_points)
    except HognoseError:
        if search.interrupted:
            raise _interrupted(search) from None
        return search, None


def _run(search: Search) -> None:
    if plain_cause(search.task) is not None:
        return
    try:
        search.run()
    except KeyboardInterrupt:
        raise _interrupted(search) from None


def _interrupted(search: Search) -> KeyboardInterrupt:
    return KeyboardInterrupt(f"{search.task.name}: {search.cut_short}; no route had been found")
