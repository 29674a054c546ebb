"""Edits, from what a task says to what it says then."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from workbench_makers import ROBOT, small

import hognose
from hognose.errors import InputError
from hognose.planning import Task
from hognose.viewer.model import edits


def test_a_place_is_three_numbers():
    for place in ((1.0, 2.0), "abc", (1.0, 2.0, 3.0, 4.0)):
        with pytest.raises(InputError, match="three numbers"):
            edits.move_way_point(0, place)


@given(st.integers(0, 3), st.sampled_from([2, 3, 4, 5]), st.sampled_from(["spline", "bspline"]))
@settings(deadline=None)
def test_a_way_point_is_added_in_the_middle_of_the_curve(index, order, kind):
    spec = small().spec
    spec = edits.move_way_point(1, (0.04, -0.03, 0.2))(spec)
    task = Task(spec.model_copy(update={"path": spec.path.model_copy(update={"order": order, "kind": kind})}), ROBOT)
    if index > 2:
        with pytest.raises(InputError):
            edits.add_way_point(index)(task.spec)
        return
    stops = edits.add_way_point(index)(task.spec).path.stops
    new = min(index, 1) + 1
    assert len(stops) == 4
    assert stops[:new] + stops[new + 1 :] == task.spec.path.stops
    if kind == "spline":
        path = task.path_through(task.way_points)
        assert path.distance_to(stops[new]) < 1e-9
        before, after = (np.linalg.norm(np.subtract(stops[new], stops[new + k])) for k in (-1, 1))
        assert before == pytest.approx(after, rel=0.2)
    else:
        assert np.allclose(stops[new], np.add(stops[new - 1], stops[new + 1]) / 2)


def test_entrance_target_and_what_is_between_move_in_a_search():
    spec = hognose.load_task("find-a-way").spec
    more = edits.add_way_point(0, (0.01, 0.02, 0.3))(spec)
    assert more.path.via == ((0.01, 0.02, 0.3),)
    assert edits.remove_way_point(1)(more).path == spec.path
    for index, name in ((0, "entrance"), (2, "target")):
        assert getattr(edits.move_way_point(index, (0.0, 0.0, 0.9))(more).path, name) == (0.0, 0.0, 0.9)
    assert edits.move_way_point(1, (0.0, 0.0, 0.5))(more).path.via == ((0.0, 0.0, 0.5),)


def test_the_way_asked_for_again_keeps_what_was_wished():
    task = hognose.load_task("find-a-way")
    found = edits.take_route(np.insert(task.way_points, 1, (0.01, 0, 0.5), axis=0))(task.spec)
    asked = edits.validated(edits.ask_for_route(edits.validated(found, "")), "")
    assert asked == task.spec
    assert edits.ask_for_route(task.spec) is task.spec
    plain = edits.validated(edits.ask_for_route(small().spec), "")
    assert (plain.path.entrance, plain.path.target) == (small().spec.path.way_points[0], (0.03, 0.04, 0.4))


@pytest.mark.parametrize(
    ("table", "key"),
    [("tolerance", "cad"), ("motion", "step"), ("path", "tip_cone_deg"), ("base", "radius")],
)
def test_every_table_is_checked_like_a_file_s(table, key):
    spec = small().spec
    assert key in type(getattr(spec, table)).model_fields
    wrong = spec.model_copy(update={table: getattr(spec, table).model_copy(update={key: -1.0})})
    with pytest.raises(InputError, match=f"{table}.{key}"):
        edits.validated(wrong, "")
