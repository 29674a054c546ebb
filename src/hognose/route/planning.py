"""Planning of any task: along its way-points, or along a route that is searched."""

from __future__ import annotations

from collections.abc import Callable

from hognose.arguments import instance, real, whole
from hognose.errors import InputError
from hognose.planning.plan import Plan
from hognose.planning.planner import plan_along
from hognose.planning.task import Task
from hognose.route.search.search import Search
from hognose.route.search_stages import search_route
from hognose.route.why.diagnosis import explained

LARGEST_SEED = 2**63 - 1

Progress = Callable[[str], None]


def plan(task: Task, progress: Progress = lambda stage: None, seconds: float | None = None, seed: int = 0) -> Plan:
    """Plan an insertion, from the arm straight at the entrance to the tip on the target, and check it.

    A task with way-points is planned along them. To a task with a target a route is searched first, and the one with
    the largest certified clearance is returned.

    Parameters
    ----------
    task
    progress
        Called with the name of each stage.
    seconds : optional
        How long to search: the first route comes early, better ones follow. Unless given, a fixed amount of work is
        done, and the answer is the same on every machine.
    seed
        Of the variations that are tried: the same one gives the same routes in the same order.

    Returns
    -------
    Plan
        All of its checks passed.

    Raises
    ------
    InputError
        The task contradicts itself, or time or seed make no sense.
    InfeasibleError
        No good motion exists or was found: why, where and by how much. Its `plan` holds the motion as far as it was
        made; after a search the farthest good one on the way to the target, if there is any.
    KeyboardInterrupt
        Ctrl-C before a route was found; its text says how far the search was.
    DiagnosisInterrupted
        Ctrl-C while it was found out why there is no route: a KeyboardInterrupt that says what is known.
    """
    instance("task", task, Task, "a hognose.Task; `hognose.load_task` reads one from a file")
    if not callable(progress):
        raise InputError("progress: expected a function that takes the name of a stage")
    if seconds is not None:
        expected = "a number of seconds above 0 and below a million"
        seconds = real("time", seconds, expected, lambda given: 0 < given < 1e6)
    seed = whole("seed", seed, 0, LARGEST_SEED)
    if task.spec.path.target is None:
        return plan_along(task, progress)
    search, made = search_route(task, lambda task: Search(task, seconds, seed, progress))
    if made is None:
        error = explained(search)  # and while that is found out, a route may be found at last
        if search.best is None:
            raise error
        made = search.best.plan
    return made
