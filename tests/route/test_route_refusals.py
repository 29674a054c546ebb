"""A search ends early where a check refuses its plans and no other route would pass it."""

from __future__ import annotations

import itertools

import pytest
from own_criteria import appended
from route_makers import searched

import hognose
from hognose.planning.checks import Criterion, most
from hognose.route import Search
from hognose.route.search.refusals import ALIKE, unmendable


def raises(motion, shared):
    raise ZeroDivisionError("no mass")


def too_long(motion, shared):
    """A figure of the robot."""
    yield most(motion.robot.length, 0.5)


def never_clear_enough(motion, shared):
    """A figure of the route."""
    yield most(-shared.clearance.min(), -1.0)


@pytest.mark.parametrize(
    ("judge", "mendable", "plans"), [(raises, True, ALIKE), (too_long, True, ALIKE), (never_clear_enough, False, 1)]
)
def test_a_search_ends_where_no_other_route_would_pass(judge, mendable, plans):
    stages: list[str] = []
    with appended(Criterion("refuses", "refuses", "m", judge, mendable=mendable)):
        search = Search(searched("pipe-tank"), None, 0, stages.append)
        search.run()
        assert len(search.refused) == plans
        assert search.unmendable is not None
        assert search.unmendable == search.refused[-1].check("refuses")
        with pytest.raises(hognose.InfeasibleError, match="no other route is likely to pass") as caught:
            hognose.plan(searched("pipe-tank"), stages.append)
    assert search.unmendable.sentence in str(caught.value)
    assert caught.value.plan.check("refuses").failed
    assert "finding out what stands in the way" not in stages


def test_a_check_that_other_routes_may_pass_does_not_end_a_search():
    counted = itertools.count()

    def third(motion, shared):
        """The third plan passes; the figures of those before are apart."""
        number = next(counted)
        yield most(2 - number, 0)

    with appended(Criterion("third", "third", "1", third)):
        search = Search(searched("pipe-tank"), None, 0)
        search.run()
    assert search.unmendable is None
    assert len(search.refused) == 2
    assert search.best is not None


def test_plans_that_our_own_checks_refuse_alike_do_not_end_a_search():
    task = hognose.load_task("obstacle-array")
    motion = task.spec.motion.model_copy(update={"period_s": 1e-4})
    with pytest.raises(hognose.InfeasibleError) as caught:
        hognose.plan(hognose.Task(task.spec.model_copy(update={"motion": motion}), task.robot))
    assert caught.value.plan.check("joint_speed").failed
    assert unmendable([caught.value.plan] * ALIKE) is None
