"""Set-points: a step and a period apart, and the last step takes what is left."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hognose.planning.timing import SetPoints, is_last_step, set_points, steady, steps_of

lengths = st.floats(1e-6, 10.0)
steps = st.floats(1e-3, 1.0)
periods = st.floats(1e-6, 1e3)


@given(lengths, steps, periods)
def test_feeds_and_times_are_steady_to_the_last_step(length, step, period):
    made = set_points(length, step, period)
    rows = len(made.feed)
    even = steady(rows, step, period)
    assert np.array_equal(made.feed[:-1], even.feed[:-1])
    assert np.array_equal(made.time, even.time)
    assert made.feed[0] == made.time[0] == 0
    assert made.feed[-1] == length
    assert (np.diff(made.feed) > 0).all()
    assert rows == steps_of(length, step) + 1 >= 2
    assert is_last_step(float(made.feed[-1] - made.feed[-2]), length, step, 0.0)


@given(lengths, steps, periods)
def test_what_a_step_is_left_out_of_or_put_into_has_no_such_last_step(length, step, period):
    made = set_points(length, step, period).feed
    left = float(made[-1] - made[-2])
    assert not is_last_step(left + step, length, step, 1e-9) or left < 1e-8
    assert not is_last_step(left - step, length, step, 1e-9) or left > step
    assert not is_last_step(0.0, length, step, 1e-9)
    assert not is_last_step(float("nan"), length, step, 1e-9)


@given(lengths, steps, periods)
def test_backwards_twice_is_forwards_again(length, step, period):
    made = set_points(length, step, period)
    back = made.backwards()
    assert np.array_equal(back.feed, made.feed[::-1])
    assert back.time[0] == 0
    assert back.time[-1] == made.time[-1]
    np.testing.assert_allclose(back.time, made.time, rtol=0, atol=1e-12 * max(1.0, made.time[-1]))
    again = back.backwards()
    assert np.array_equal(again.feed, made.feed)
    np.testing.assert_allclose(again.time, made.time, rtol=1e-12, atol=1e-12 * made.time[-1])


def test_by_hand():
    made = set_points(0.25, 0.1, 2.0)
    np.testing.assert_array_equal(made.feed, [0.0, 0.1, 0.2, 0.25])
    np.testing.assert_array_equal(made.time, [0.0, 2.0, 4.0, 6.0])
    assert isinstance(made, SetPoints)
    assert steps_of(0.3, 0.1) == 3  # though 3 × 0.1 is a little more than 0.3
    assert steps_of(0.3 + 1e-12, 0.1) == 3
    assert steps_of(1e-12, 0.1) == 1
    assert steps_of(1.0, 1e-300) == 10**15
