"""What is shown while a new edit is planned, by a clock of the test's own."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from hognose.viewer.model.freshness import CALM, Standing


class Bench:
    """A workbench that only has a version and a verdict."""

    def __init__(self) -> None:
        self.number = 0
        self.verdict: Any = None

    def is_current(self, number: int) -> bool:
        return number == self.number

    def judge(self, number: int, motion: bool = True) -> None:
        self.verdict = SimpleNamespace(number=number, plan=object() if motion else None)


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.fixture
def standing(bench) -> Standing:
    return Standing(bench)


def test_the_first_verdict_counts_at_once(bench, standing):
    assert not standing.look(1.0)
    assert (standing.verdict, standing.settled) == (None, False)
    bench.judge(0)
    assert standing.look(0.01)
    assert (standing.settled, standing.outdated) == (True, False)
    assert not standing.look(10.0)


def test_with_an_edit_the_old_verdict_counts_no_more_and_turns_grey_when_the_new_one_is_long_in_coming(bench, standing):
    bench.judge(0)
    standing.look(10.0)
    bench.number = 1
    standing.look(0.4 * CALM)
    assert (standing.settled, standing.outdated) == (False, False)
    standing.look(1.1 * CALM)
    assert (standing.settled, standing.outdated) == (False, True)
    bench.judge(1)
    assert standing.look(0.1 * CALM)
    assert (standing.settled, standing.outdated) == (True, False)


def test_while_somebody_drags_nothing_is_settled_and_nothing_flickers(bench, standing):
    bench.judge(0)
    standing.look(1.0)
    seen = set()
    for number in range(1, 200):  # each edit is planned before the next one comes, or just after it
        bench.number = number
        standing.look(0.05)
        seen.add((standing.settled, standing.outdated))
        bench.judge(number)
        if number % 3:
            standing.look(0.01)
            seen.add((standing.settled, standing.outdated))
    assert seen == {(False, False)}
    standing.look(CALM)
    assert (standing.settled, standing.outdated) == (True, False)


def test_where_there_is_no_motion_what_is_drawn_is_outdated_at_once(bench, standing):
    bench.judge(0)
    standing.look(1.0)
    bench.number = 1
    bench.judge(1, motion=False)
    standing.look(CALM)
    assert standing.outdated
    standing.look(CALM)
    assert (standing.settled, standing.outdated) == (True, True)


def test_a_verdict_on_a_version_before_never_counts(bench, standing):
    bench.number = 3
    for number in range(3):
        bench.judge(number)
        standing.look(10 * CALM)
        assert not standing.settled
    bench.judge(3)
    standing.look(0.0)
    assert standing.settled
