"""Timing that survives a noisy machine: alternate the candidates, take each one's best round."""

from __future__ import annotations

import os
import time
from collections.abc import Callable


def best_times(
    candidates: dict[str, Callable[[], object]], rounds: int = 60, clock: Callable[[], float] = time.perf_counter
) -> dict[str, float]:
    """Shortest time (s) of one call of each candidate, all taken in turn in one run; one call each warms up.

    With `time.process_time` as its clock, other work on the machine matters little.
    """
    for call in candidates.values():
        call()
    best = dict.fromkeys(candidates, float("inf"))
    for _ in range(rounds):
        for name, call in candidates.items():
            begin = clock()
            call()
            best[name] = min(best[name], clock() - begin)
    return best


def use_one_core() -> str:
    """Keep this process on one core, where the system can; says what was done."""
    if not hasattr(os, "sched_setaffinity"):
        return f"{os.cpu_count()} cores (this system cannot pin a process)"
    core = min(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {core})
    return "one core"
