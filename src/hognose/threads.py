"""Work shared out to threads: many small queries in blocks, or a few larger calculations."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from contextvars import copy_context
from functools import cache
from itertools import pairwise
from typing import Any

from hognose.arguments import whole

#: First link, past the last, first step, past the last.
Block = tuple[int, int, int, int]

# Fewer queries than this are not worth handing to threads.
_WORTH_THREADS = 1500


def share_out(work: Callable[[Block], None], steps: int, links: int, threads: int | None) -> None:
    """Do some work on steps × links, in blocks, with a number of threads; None for one a core.

    Raises
    ------
    InputError
        Threads that are not a whole number, or too many.
    """
    workers = _workers(threads, steps * links)
    blocks = _blocks(steps, links, workers)
    if workers == 1:
        for block in blocks:
            work(block)
        return
    list(_pool(workers, "blocks").map(work, blocks))  # waits, and raises what a block raised


def together(*calls: Callable[[], Any]) -> list[Any]:
    """What calls return that are made at the same time, as far as there are cores; kernels gain by it.

    Raises
    ------
    Exception
        What the first of them raised, once all have ended.
    """
    if _cores() == 1:
        return [call() for call in calls]
    others = [_pool(len(calls) - 1, "together").submit(copy_context().run, call) for call in calls[1:]]
    try:
        first = calls[0]()
    finally:
        wait(others)
    return [first, *(other.result() for other in others)]


def _workers(threads: int | None, queries: int) -> int:
    if threads is not None:
        threads = whole("threads", threads, 1, 4096)
    return 1 if queries < _WORTH_THREADS else threads or _cores()


def _cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _blocks(steps: int, links: int, workers: int) -> list[Block]:
    """Cut steps × links into blocks.

    Several blocks a worker, one a link if they are few, even out that some links are searched longer; runs of steps
    stay whole where there are links enough, since each cut costs a search without a warm start.
    """
    wanted = 1 if workers == 1 else min(max(links, 4 * workers), 8 * workers)
    across = min(links, wanted)
    along = min(steps, -(-wanted // across))
    link_cuts = [links * i // across for i in range(across + 1)]
    step_cuts = [steps * i // along for i in range(along + 1)]
    return [(*link, *step) for link in pairwise(link_cuts) for step in pairwise(step_cuts)]


@cache
def _pool(workers: int, purpose: str) -> ThreadPoolExecutor:
    """Threads that wait for work: starting them anew for each check would take as long as a small check.

    Those of one purpose never wait for others of the same.
    """
    return ThreadPoolExecutor(workers, thread_name_prefix=purpose)


if hasattr(os, "register_at_fork"):  # a child process has none of its parent's threads
    os.register_at_fork(after_in_child=_pool.cache_clear)
