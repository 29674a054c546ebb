"""Times that survive a noisy machine: the best of several rounds, of whole motions and of blocks of a few steps."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.evaluation.case import Case
from hognose.evaluation.subjects import follower_for

Array = NDArray[np.float64]

#: A block of steps is one call from Python and takes about so long, s, in at most so many steps: a call costs some
#: microseconds, which the steps of a block share.
_BLOCK_SECONDS, _LONGEST_BLOCK = 3e-4, 32
_MOST_ROUNDS = 15


@dataclass(frozen=True)
class StepTimes:
    """Seconds a step: the mean of the whole motion in one call, and of each block of steps, its call included."""

    whole: float
    blocks: Array
    sizes: NDArray[np.int64]

    @property
    def steps(self) -> Array:
        """The time of its block for every step."""
        return np.repeat(self.blocks, self.sizes)


def affordable_steps(label: str, case: Case, patience: float) -> int:
    """How many of the feeds a method can follow three times within the patience (s), at least 1.

    Found by following more and more of them. Compiles the method on the way, so that nothing measured later contains
    that.
    """
    _once(label, case, case.feeds[-1:])
    count, long = 1, patience / 10.0
    while True:
        spent = _once(label, case, case.feeds[-count:])
        if spent > long:  # more steps may have had more to compile
            spent = min(spent, _once(label, case, case.feeds[-count:]))
        if spent > long or count == len(case.feeds):
            return int(min(len(case.feeds), max(1, patience / 3.0 * count / max(spent, 1e-9))))
        count = min(4 * count, len(case.feeds))


def step_times(label: str, case: Case, feeds: Array, budget: float) -> StepTimes:
    """The best times over rounds, each with a new follower; as many rounds as the budget (s) holds, at least one."""
    whole = _once(label, case, feeds)
    size = np.clip(_BLOCK_SECONDS * len(feeds) / whole, 1, _LONGEST_BLOCK)
    blocks = np.array_split(feeds, math.ceil(len(feeds) / size))
    best, spent = np.full(len(blocks), np.inf), 0.0
    for done in range(_MOST_ROUNDS):
        if done and spent > budget:
            break
        begun = time.perf_counter()
        whole = min(whole, _once(label, case, feeds)) if done else whole
        follower = follower_for(label, case, float(feeds[0]))
        for number, block in enumerate(blocks):
            begin = time.perf_counter()
            follower.run(block)
            best[number] = min(best[number], (time.perf_counter() - begin) / len(block))
        spent += time.perf_counter() - begun
    return StepTimes(whole / len(feeds), best, np.array([len(block) for block in blocks]))


def race(steps: Mapping[str, int], case: Case, budget: float) -> dict[str, float]:
    """Best seconds a step of each label over its last steps, all taken in turn so that they share the machine's moods.

    Ratios are taken from these. Each gets about the budget (s), but at least two rounds.
    """
    best, spent = dict.fromkeys(steps, np.inf), dict.fromkeys(steps, 0.0)
    for done in range(4 * _MOST_ROUNDS):
        for label, count in steps.items():
            if done < 2 or spent[label] < budget:
                seconds = _once(label, case, case.feeds[-count:])
                best[label] = min(best[label], seconds / count)
                spent[label] += seconds
    return {label: float(seconds) for label, seconds in best.items()}


def _once(label: str, case: Case, feeds: Array) -> float:
    follower = follower_for(label, case, float(feeds[0]))
    begin = time.perf_counter()
    follower.run(feeds)
    return time.perf_counter() - begin
