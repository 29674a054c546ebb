"""Times that survive a noisy machine: the best of several rounds, of whole motions and of blocks of a few steps."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.evaluation.families import Case
from hognose.evaluation.subjects import follower_for

Array = NDArray[np.float64]

#: Steps a block: one call from Python costs about a microsecond, which a block shares out.
BLOCK = 8
_FEWEST_STEPS = 8
_MOST_ROUNDS = 15


@dataclass(frozen=True)
class StepTimes:
    """Seconds a step: the mean of the whole motion in one call, and of each block of steps, its call included."""

    whole: float
    blocks: Array

    def of_steps(self, steps: int) -> Array:
        """The block's time for every step (steps,)."""
        return np.repeat(self.blocks, BLOCK)[:steps]


def budgeted_steps(label: str, case: Case, budget: float) -> int:
    """How many of the feeds a method can follow about five times within the budget (s), at least 8.

    Compiles the method on the way, so that nothing measured later contains that.
    """
    follower_for(label, case).run(case.feeds[-1:])
    follower, trial = follower_for(label, case), case.feeds[-4:]
    begin = time.perf_counter()
    follower.run(trial)
    a_step = (time.perf_counter() - begin) / len(trial)
    return int(min(len(case.feeds), max(_FEWEST_STEPS, budget / 5.0 / max(a_step, 1e-9))))


def step_times(label: str, case: Case, feeds: Array, budget: float) -> StepTimes:
    """The best times over rounds, each with a new follower; as many rounds as the budget (s) holds, at least two."""
    starts = range(0, len(feeds), BLOCK)
    best, whole, spent = np.full(len(starts), np.inf), np.inf, 0.0
    for done in range(_MOST_ROUNDS):
        if done >= 2 and spent > budget / 2:
            break
        begun = time.perf_counter()
        whole = min(whole, _once(label, case, feeds))
        follower = follower_for(label, case)
        for number, start in enumerate(starts):
            block = feeds[start : start + BLOCK]
            begin = time.perf_counter()
            follower.run(block)
            best[number] = min(best[number], (time.perf_counter() - begin) / len(block))
        spent += time.perf_counter() - begun
    return StepTimes(whole / len(feeds), best)


def race(labels: Sequence[str], case: Case, budget: float) -> dict[str, float]:
    """Best seconds a step of each, all taken in turn so that they share the machine's moods; for ratios."""
    feeds = {label: case.feeds[-budgeted_steps(label, case, budget) :] for label in labels}
    best = dict.fromkeys(labels, np.inf)
    rounds = dict.fromkeys(labels, 0)
    spent = dict.fromkeys(labels, 0.0)
    for _ in range(4 * _MOST_ROUNDS):
        for label in labels:
            if rounds[label] >= 2 and spent[label] > budget:
                continue
            begin = time.perf_counter()
            best[label] = min(best[label], _once(label, case, feeds[label]) / len(feeds[label]))
            spent[label] += time.perf_counter() - begin
            rounds[label] += 1
    return {label: float(seconds) for label, seconds in best.items()}


def _once(label: str, case: Case, feeds: Array) -> float:
    follower = follower_for(label, case)
    begin = time.perf_counter()
    follower.run(feeds)
    return time.perf_counter() - begin
