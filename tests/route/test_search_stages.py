"""The stages of a search past what moves: clear of all its ways first, in the time that was asked for."""

from __future__ import annotations

import numpy as np
import pytest

import hognose
from hognose.files import load_task
from hognose.planning import Plan, Task
from hognose.route.search.search import Search
from hognose.route.search_stages import FOR_ALL_WAYS, search_route
from hognose.viewer.model.background_search import Finding

#: A ball that goes by before the arm comes.
TEXT = """
name = "past a ball"
units = "mm"
robot = "sjtu-25dof"
margin = 5
[path]
entrance = [0, 0, 0]
target = [30, 0, 500]
[[obstacle]]
kind = "sphere"
name = "ball"
center = {center}
diameter = 60
motion = [{{ time_s = -3 }}, {{ time_s = 1, position = {to} }}]
"""
ACROSS = {"center": [-200, 0, 250], "to": [400, 0, 0]}
#: It comes through the entrance before the insertion begins: no route is clear of its whole way.
THROUGH_ENTRANCE = {"center": [-500, 0, 0], "to": [800, 0, 0]}


def read(folder, said) -> Task:
    (folder / "task.toml").write_text(TEXT.format(**said), encoding="utf-8")
    return load_task(folder / "task.toml")


class Begun(list[Search]):
    def __call__(self, task: Task) -> Search:
        self.append(Search(task, None, 0))
        return self[-1]


def test_a_route_is_clear_of_all_ways_where_it_can_be(tmp_path):
    task, begun = read(tmp_path, ACROSS), Begun()
    search, plan = search_route(task, begun)
    assert begun == [search]
    assert search.gives_up == FOR_ALL_WAYS
    assert not search.task.moving
    assert search.best is not None
    assert plan is not None
    assert plan.task is task
    np.testing.assert_array_equal(plan.way_points, search.best.plan.way_points)
    np.testing.assert_array_equal(plan.way_points, hognose.plan(task).way_points)


def test_the_page_searches_as_the_command_does(tmp_path):
    task, shown = read(tmp_path, ACROSS), list[Plan]()
    finding = Finding(task, 1, 30.0, lambda _, plan: shown.append(plan) or finding.stop())
    finding._thread.join()
    assert not shown[0].task.moving
    assert "ball" in shown[0].scene.names
    assert "mm certified, the best of 1 route; stopped after" in finding.said


def test_where_a_way_covers_the_entrance_what_stands_still_is_searched_in_the_same_time(tmp_path):
    task, begun = read(tmp_path, THROUGH_ENTRANCE), Begun()
    _, plan = search_route(task, begun)
    assert plan is not None
    assert plan.good
    first, second = begun
    assert not first.task.moving
    assert second.task is task
    assert second.began == first.began
    assert second.gives_up == 1.0


@pytest.mark.parametrize("part", [0.25, 1.0])
def test_a_search_gives_up_only_while_it_has_found_nothing(part, tmp_path):
    search = Search(read(tmp_path, ACROSS), 1000.0, 0, gives_up=part)
    search.began -= 1000.0 * part - 50.0
    assert search.goes_on()
    search.began -= 100.0
    assert not search.goes_on()
    search.found = [None]  # type: ignore[list-item]
    assert search.goes_on() == (part < 1.0)
