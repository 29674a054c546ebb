"""Calls made at the same time."""

from __future__ import annotations

import os
import threading

import numpy as np
import pytest

from hognose.threads import together


def test_all_calls_are_made_and_run_at_once_where_there_are_cores():
    seen, meeting = [], threading.Barrier(2)

    def call(name: str) -> None:
        if len(os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else [0] * (os.cpu_count() or 1)) > 1:
            meeting.wait(60)  # would break, were one made after the other
        seen.append(name)

    together(lambda: call("first"), lambda: call("second"))
    assert sorted(seen) == ["first", "second"]


def test_what_numbers_may_do_is_as_where_the_calls_come_from():
    found = {}

    def call(name: str) -> None:
        found[name] = np.geterr()["divide"]

    with np.errstate(divide="raise"):
        together(lambda: call("here"), lambda: call("there"))
    assert found == {"here": "raise", "there": "raise"}


@pytest.mark.parametrize("failing", [0, 1])
def test_an_error_of_either_call_is_raised_when_both_have_ended(failing):
    ended = []

    def call(place: int) -> None:
        if place == failing:
            raise ValueError(f"call {place}")
        ended.append(place)

    with pytest.raises(ValueError, match=f"call {failing}"):
        together(lambda: call(0), lambda: call(1))
    assert ended == [1 - failing]


def test_one_core_makes_one_call_after_the_other(monkeypatch):
    monkeypatch.setattr("hognose.threads._cores", lambda: 1)
    threads = []
    together(lambda: threads.append(threading.current_thread()), lambda: threads.append(threading.current_thread()))
    assert threads == [threading.current_thread()] * 2
