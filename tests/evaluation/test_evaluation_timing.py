"""How often methods are run for their times, with a clock that is made up."""

import platform

import numpy as np
import pytest
from evaluation_makers import small_case

from hognose.evaluation import timing
from hognose.evaluation.machine import machine
from hognose.evaluation.timing import affordable_steps, race, step_times

CASE = small_case(steps=100)


@pytest.fixture
def clock(monkeypatch):
    """Seconds a step by label; every call is noted with its number of steps."""
    seconds, calls = {}, []

    def once(label, case, feeds):
        assert np.array_equal(feeds, case.feeds[-len(feeds) :]), "always the last feeds"
        calls.append((label, len(feeds)))
        return seconds[label] * len(feeds)

    monkeypatch.setattr(timing, "_once", once)
    return seconds, calls


@pytest.mark.parametrize(
    ("a_step", "patience", "steps"),
    [(1e-6, 0.3, 100), (1e-3, 0.31, 100), (1e-3, 0.151, 50), (0.1, 0.3, 1), (0.1, 1.3, 4), (0.2, 0.3, 1), (9, 0.3, 1)],
)
def test_a_slow_method_is_given_as_many_steps_as_patience_allows(clock, a_step, patience, steps):
    seconds, calls = clock
    seconds["slow"] = a_step
    assert affordable_steps("slow", CASE, patience) == steps
    # Nor may finding that out take longer than patience lasts, but for three steps.
    assert sum(count for _, count in calls) * a_step <= patience + 3 * a_step
    assert 3 * a_step * steps <= max(patience, 3 * a_step) * (1 + 1e-9)


def test_a_race_takes_all_in_turn_and_gives_each_its_budget(clock):
    seconds, calls = clock
    seconds |= {"fast": 1e-4, "slow": 1e-2}
    found = race({"fast": 100, "slow": 30}, CASE, 0.05)
    assert found == pytest.approx({"fast": 1e-4, "slow": 1e-2})
    assert calls[:4] == [("fast", 100), ("slow", 30), ("fast", 100), ("slow", 30)]
    assert calls.count(("slow", 30)) == 2, "two rounds, although one is beyond the budget"
    assert calls.count(("fast", 100)) == 5


def test_blocks_cover_all_steps_evenly_and_share_the_call(clock):
    seconds, _ = clock
    seconds["exact"] = 1e-6
    fast = step_times("exact", CASE, CASE.feeds, 1e-4)
    assert fast.sizes.sum() == len(fast.steps) == 100
    assert fast.sizes.min() == fast.sizes.max() == 25, "no more than 32 steps, and all alike"
    assert (fast.blocks > 0.0).all()
    assert fast.whole == pytest.approx(1e-6)


def test_slow_steps_are_timed_one_by_one(clock):
    seconds, _ = clock
    seconds["exact"] = 1e-3
    found = step_times("exact", CASE, CASE.feeds[-7:], 1e-9)
    assert found.sizes.tolist() == [1] * 7
    assert found.whole == pytest.approx(1e-3)


def test_the_machine_is_described_and_not_named():
    found = machine()
    assert set(found) == {"architecture", "processor", "python", "numba"}
    assert found["python"] == platform.python_version()
    assert platform.node() not in found.values()
