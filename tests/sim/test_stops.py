"""What stops the twin: a contact on request, and figures that are none. Others are in `test_twin`."""

import numpy as np
import pytest
from twin_makers import boards, shortened

from hognose.errors import InputError
from hognose.sim import Changes, Twin, simulate
from hognose.sim.set_points import SetPoints, planned_at


def lifted(shift: float) -> Changes:
    return Changes(shifted={"board 2": (0.0, shift, 0.0)})


def beginning():
    """Until some steps after the first contact with a board that is higher."""
    return shortened(boards(), 130)


@pytest.fixture(scope="module")
def stopped():
    return simulate(beginning(), lifted(0.045), stop_at_contact=5.0)


def test_a_contact_stops_all_motors_and_says_what_is_left(stopped):
    stop = stopped.contact_stop
    assert stop is not None
    assert (stop.obstacle, stop.link, stop.limit, stop.settled) == ("board 2", 11, 5.0, 1.0)
    assert 5.0 < stop.force < 6.0  # a step of 2 ms beyond
    assert stop.force <= stop.peak < 7.0
    assert 0.0 < stop.remaining < 6.0
    assert stop.tip_error == stopped.tip_errors[-1]
    assert f"link 12 pressed board 2 with {stop.force:.1f} N, more than 5 N" in stopped.stopped
    assert f"after 1 s {stop.remaining:.1f} N are left" in stopped.stopped
    assert stopped.time[-1] == pytest.approx(stop.time + 1.0, abs=0.003)
    assert np.count_nonzero(stopped.time > stop.time + 0.003) == 7


def test_all_stand_still_after_a_contact(stopped):
    after = stopped.time >= stopped.contact_stop.time
    assert np.ptp(stopped.commanded[after], axis=0).max() == 0.0
    assert np.ptp(stopped.joints[after, 0, 2]) < 0.05e-3
    before = simulate(beginning(), lifted(0.045))
    rows = np.count_nonzero(stopped.time <= stopped.contact_stop.time)
    np.testing.assert_array_equal(stopped.joints[:rows], before.joints[:rows])
    assert before.contact.max() > 1.5 * stopped.contact.max()
    assert before.first_contact == stopped.first_contact


def test_nothing_stops_without_contact_or_below_the_force():
    plan = beginning()
    assert simulate(plan, stop_at_contact=1.0).good
    done = simulate(plan, lifted(0.03), stop_at_contact=100.0)
    assert done.contact_stop is None
    assert not done.stopped
    assert 1.0 < done.contact.max() < 100.0


@pytest.mark.parametrize("limit", [0.0, -1.0, np.nan, np.inf])
def test_an_absurd_force_is_refused(limit):
    with pytest.raises(InputError, match="stop_at_contact: expected a number above 0 N"):
        simulate(boards(), stop_at_contact=limit)


def test_an_integration_that_falls_apart_is_noticed(monkeypatch):
    """Where nobody has looked before whether the step is too long."""
    monkeypatch.setattr(Twin, "shorten_step", lambda self, bends: None)
    done = simulate(shortened(boards(), 40), Changes(stiffness=100.0))
    assert "the integration fell apart; its step of 2 ms is too long" in done.stopped
    assert not done.good


def test_friction_counts_among_what_a_step_must_be_short_for():
    with pytest.raises(InputError, match=r"that rub with a coefficient of 1, .* Is EA and friction right"):
        simulate(boards(), Changes(stiffness=2e4, friction=1.0))


def test_set_points_go_through_the_plan():
    plan = boards()
    for period in (1, 200, 312):
        given = SetPoints.of(plan, period, 0.002, 0.0)
        assert len(given.lengths) == len(given.base_speeds) == len(given.bases) - 1 == 75
        np.testing.assert_array_equal(given.lengths[0], plan.commanded_lengths[period - 1])
        np.testing.assert_allclose(given.lengths[-1] + given.step * given.speeds, plan.commanded_lengths[period])
        np.testing.assert_array_equal(given.bases[[0, -1]], plan.at[period - 1 : period + 1])
        late = SetPoints.of(plan, period, 0.002, 1e-12)
        np.testing.assert_allclose(late.bases, given.bases, atol=1e-10)
        angles, at = planned_at(plan, float(plan.time[period]))
        np.testing.assert_allclose(angles, plan.angles[period], atol=1e-15)
        np.testing.assert_array_equal(at, plan.at[period])
    assert len(SetPoints.of(plan, 1, 0.0021, 0.0).lengths) == 72
    held = given.held(10, 0.02)
    np.testing.assert_array_equal(held.lengths, np.repeat(given.lengths[9:10], 10, axis=0))
    np.testing.assert_array_equal(held.bases, np.repeat(given.bases[9:10], 11, axis=0))
    assert not held.speeds.any()
    assert held.clock == pytest.approx(given.clock + 0.02)
