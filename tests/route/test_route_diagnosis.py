"""When there is no route: what the error says, and the insertion that comes with it."""

import pytest
from route_makers import searched

import hognose
from hognose.route import Search
from hognose.route.diagnosis import explained


def refusal(task):
    with pytest.raises(hognose.InfeasibleError) as caught:
        hognose.plan(task)
    return caught.value


def test_an_arm_that_is_too_short_is_told_by_how_much():
    error = refusal(searched("pipe-tank", target=[0, 0, 1.3]))
    assert "208.0 mm too short" in str(error)


def test_a_wall_across_the_way_is_named_and_the_way_to_it_planned():
    wall = {"kind": "board", "name": "wall", "center": [0, 0, 0.5], "size": [3, 3], "thickness": 0.01}
    wall["hole"] = [{"center": [0, 0], "diameter": 0.05}]
    error = refusal(searched("obstacle-array", obstacles=(wall,)))
    assert "narrows to" in str(error)
    assert "beside 'wall'" in str(error)
    assert "needs 55 mm" in str(error)
    assert error.plan is not None
    assert error.plan.good
    assert 0.1 < error.plan.body[-1, -1, 2] < 0.5


def test_what_would_make_it_possible_is_tried():
    wall = {"kind": "board", "name": "wall", "center": [0, 0, 0.02], "size": [3, 3], "thickness": 0.01}
    wall["hole"] = [{"center": [0, 0], "diameter": 0.054}]
    search = Search(searched("obstacle-array", obstacles=(wall,)), None, 0, most=1)
    search.run()
    assert search.best is None
    error = explained(search)
    assert "beside 'wall'" in str(error)
    assert "with 1 mm of margin a route is found" in str(error)
