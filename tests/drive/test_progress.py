"""Set-points stay on the plan, meet every step, and change their rate gently."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hognose.drive.progress import Progress, interpolated
from hognose.errors import InputError


def run(progress, wanted, until, most=20_000):
    """All places and rates until it rests at the end."""
    found = [progress]
    for _ in range(most):
        found.append(found[-1].next(wanted, until))
        if found[-1].place == until and found[-1].rests:
            return found
    raise AssertionError("it never arrives")


@pytest.mark.parametrize("cycles", [1, 3, 5, 10])
def test_at_the_plan_s_own_rate_every_step_takes_its_cycles(cycles):
    found = run(Progress(40, cycles, ramp=1), 1.0, 40)
    places = [each.place for each in found]
    assert places[:-1] == pytest.approx(np.arange(40 * cycles + 1) / cycles, abs=1e-12)
    assert [place for place in places if place == int(place)][:41] == list(range(41))


@settings(max_examples=200, deadline=None)
@given(
    st.integers(2, 30),
    st.integers(1, 10),
    st.integers(1, 30),
    st.floats(0.05, 1.0),
    st.lists(st.floats(-1, 1), max_size=60),
)
def test_no_corner_is_cut_and_no_change_is_sudden(last, cycles, ramp, rate, wishes):
    progress, found = Progress(last, cycles, ramp), []
    for wish in [rate] * 20 + wishes:
        after = progress.next(wish, last if wish > 0 else 0)
        low, high = sorted((progress.place, after.place))
        assert 0 <= low <= high <= last
        assert np.floor(high - 1e-12) <= np.floor(low + 1e-12)  # no corner within
        assert abs(after.place - progress.place) <= abs(after.rate) / cycles + 1e-12
        arrived = after.rests and after.place in (0, last)
        assert abs(after.rate - progress.rate) <= 1 / ramp + 1e-12 or (
            arrived and abs(progress.rate) <= 1 / ramp + 1e-12
        )
        found.append(after)
        progress = after
    back = run(progress, -1.0, 0)
    assert back[-1].place == 0
    there = run(back[-1], rate, last)
    met = {each.place for each in there}
    assert set(range(last + 1)) <= met


@settings(max_examples=100, deadline=None)
@given(st.integers(3, 20), st.integers(1, 10), st.integers(1, 30), st.floats(0.1, 1.0))
def test_it_rests_at_the_step_that_is_asked_for(last, cycles, ramp, rate):
    found = run(Progress(last, cycles, ramp), rate, 2)
    assert found[-1].place == 2
    assert max(each.place for each in found) == 2
    rates = np.array([each.rate for each in found])
    assert (np.abs(np.diff(rates)) <= 1 / ramp + 1e-12).all()


def test_it_stops_when_asked_and_goes_on_from_there():
    progress = Progress(50, 5, ramp=10)
    for _ in range(40):
        progress = progress.next(1.0, 50)
    cycles = 0
    while not progress.rests:
        progress, cycles = progress.next(0.0, 50), cycles + 1
    assert cycles == 10
    rested = progress.place
    assert progress.next(0.0, 50).place == rested
    assert run(progress, 1.0, 50)[-1].place == 50


def test_counts_are_those_of_the_plan_at_its_steps_and_lie_between_them_elsewhere():
    rng = np.random.default_rng(0)
    counts = rng.integers(-(10**7), 10**7, (20, 36))
    for step in range(20):
        np.testing.assert_array_equal(interpolated(counts, float(step)), counts[step])
    for place in rng.uniform(0, 19, 50):
        low = int(place)
        exact = counts[low] + (place - low) * (counts[low + 1] - counts[low])
        assert (np.abs(interpolated(counts, float(place)) - exact) <= 0.5).all()
    np.testing.assert_array_equal(interpolated(counts[:1], 0.0), counts[0])
    with pytest.raises(InputError, match=r"place: 19\.5 is not on the plan, which goes from step 0 to 19"):
        interpolated(counts, 19.5)
