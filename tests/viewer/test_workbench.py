"""The workbench: edits, undo, the newest verdict and searches."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from workbench_makers import LONG, ROBOT, eventually, move, ours, small

import hognose
from hognose.errors import HognoseError, InputError
from hognose.planning import Task, TaskSpec
from hognose.viewer.model import edits, replanner
from hognose.viewer.model.arm_state import too_close
from hognose.viewer.model.replanner import Question
from hognose.viewer.model.workbench import Verdict, Workbench
from hognose.wording import at_least_mm


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A folder for drafts, and no thread left behind."""
    monkeypatch.setenv("HOGNOSE_CACHE", str(tmp_path / "cache"))
    yield
    assert not ours()


@pytest.fixture
def bench() -> Iterator[Workbench]:
    with Workbench(small()) as made:
        yield made


sideways = st.floats(-0.03, 0.03)
todos = st.one_of(
    st.tuples(st.integers(0, 4), sideways, sideways, st.floats(0.1, 0.4)).map(lambda a: move(*a)),
    st.integers(0, 4).map(edits.add_way_point),
    st.integers(0, 4).map(edits.remove_way_point),
    st.integers(1, 5).map(edits.set_order),
    st.floats(0, 0.01).map(edits.set_margin),
    st.sampled_from([0.02, 0.05, -1.0]).map(edits.set_step),
    st.sampled_from(["exact", "prediction", "nonsense"]).map(edits.set_method),
    st.sampled_from(["sjtu-25dof", "sjtu-25dof-99", "nobody"]).map(edits.set_robot),
)


@given(st.lists(st.tuples(todos, st.sampled_from(["", "", "a", "b"])), max_size=12))
@settings(max_examples=25, deadline=None)
def test_undo_leads_back_to_the_very_same_specs_and_redo_forth(sequence):
    with Workbench(small()) as bench:
        states, merged = [bench.task], ""
        for change, merge in sequence:
            before, number = bench.task, bench.number
            try:
                bench.edit(change, merge)
            except InputError:
                assert bench.task is before
                assert bench.number == number
                continue
            if bench.task is before:
                continue
            if merge and merge == merged:
                states[-1] = bench.task
            else:
                states.append(bench.task)
            merged = merge
        for expected in states[-2::-1]:
            assert bench.can_undo
            bench.undo()
            assert bench.task is expected
            assert bench.task.robot.name == bench.spec.robot
        assert not bench.can_undo
        assert not bench.dirty
        for expected in states[1:]:
            assert bench.can_redo
            bench.redo()
            assert bench.task is expected
        assert not bench.can_redo
        verdict = bench.settle(LONG)
        assert verdict.number == bench.number
        assert verdict.plan is None or verdict.plan.task is bench.task


def test_undo_without_anything_to_undo_does_nothing(bench):
    number = bench.number
    bench.undo()
    bench.redo()
    assert bench.number == number


def test_a_drag_is_one_step_and_an_edit_after_undo_is_another(bench):
    first = bench.spec
    for k in range(20):
        bench.edit(move(1, 0.02, 0.001 * k, 0.2), "drag 1")
    bench.edit(move(2, 0.03, 0.04, 0.39), "drag 2")
    bench.undo()
    assert bench.spec.path.way_points[1] == (0.02, 0.019, 0.2)
    bench.edit(move(1, 0.0, 0.0, 0.2), "drag 1")
    assert not bench.can_redo
    bench.undo()
    bench.undo()
    assert bench.spec is first
    bench.redo()
    again = bench.spec
    bench.edit(move(1, 0.0, 0.01, 0.2), "drag 1")
    bench.undo()
    assert bench.spec is again


def test_the_verdict_is_the_planners(bench):
    verdict = bench.settle(LONG)
    plan = hognose.plan(small())
    assert verdict.good
    assert (verdict.problems, verdict.step) == ((), None)
    assert len(too_close(verdict.plan)) == 0
    assert np.array_equal(verdict.plan.angles, plan.angles)
    assert plan.certified_clearance is not None
    assert verdict.headline.startswith(f"GOOD: {at_least_mm(plan.certified_clearance)} mm certified, closest to ball")
    assert bench.settle(LONG) is verdict


def test_a_bad_plan_is_shown_with_what_fails_and_by_most(bench):
    bench.edit(lambda spec: spec.model_copy(update={"path": spec.path.model_copy(update={"detour": False})}))
    bench.edit(move(1, 0.06, 0.0, 0.2))
    verdict = bench.settle(LONG)
    assert not verdict.good
    failed = [check for check in verdict.checks if check.failed]
    assert sorted(verdict.problems) == sorted(check.sentence for check in failed)
    assert verdict.headline == f"NOT GOOD: {verdict.problems[0]}"
    worst = next(check for check in failed if check.sentence == verdict.problems[0])
    assert worst.step is not None
    assert verdict.step == worst.step


def test_where_no_detour_helps_the_motion_is_shown_as_it_is(bench):
    bench.edit(move(1, 0.07, 0.0, 0.2))
    verdict = bench.settle(LONG)
    assert not verdict.good
    assert "does not fit" in verdict.headline
    assert np.array_equal(verdict.plan.way_points, bench.task.way_points)
    assert not verdict.plan.good
    assert verdict.plan.clearance[verdict.step].min() == verdict.plan.clearance.min() < bench.spec.margin
    close = too_close(verdict.plan)
    assert len(close) > 10
    # Each lies on the ball, and on the way of a body that comes closer to it than the margin.
    np.testing.assert_allclose(np.linalg.norm(close - (0.1, 0, 0.2), axis=1), 0.025, atol=2e-4)
    assert verdict.plan.path.distance_to(close).max() < verdict.plan.robot.body_radii.max() + bench.spec.margin + 0.005


def test_what_cannot_be_planned_is_said_and_the_next_edit_is_planned(bench):
    bench.edit(move(1, 0.1, 0.0, 0.2))
    verdict = bench.settle(LONG)
    assert (verdict.good, verdict.plan, verdict.step) == (False, None, None)
    assert "lies inside the obstacle 'ball'" in verdict.headline
    bench.undo()
    assert bench.settle(LONG).good


def test_a_fault_of_the_planner_does_not_end_the_thread(bench, monkeypatch, caplog):
    bench.settle(LONG)
    with monkeypatch.context() as patched:
        patched.setattr(replanner, "plan_along", lambda task: 1 / 0)
        bench.edit(edits.set_margin(0.001))
        assert "ZeroDivisionError" in bench.settle(LONG).headline
    assert "planning failed" in caplog.text
    bench.undo()
    assert bench.settle(LONG).good


@pytest.mark.parametrize("count", [1, 2, 50])
def test_of_a_flood_of_edits_only_the_newest_is_planned(monkeypatch, count):
    begun, go, judged = threading.Event(), threading.Event(), []
    plan = replanner.judged

    def slow(question: Question) -> Verdict:
        begun.set()
        assert go.wait(LONG)
        judged.append(question.number)
        return plan(question)

    monkeypatch.setattr(replanner, "judged", slow)
    with Workbench(small()) as bench:
        assert begun.wait(LONG)
        for k in range(count):
            bench.edit(move(1, 0.02, 1e-4 * k, 0.2), "drag")
        with pytest.raises(HognoseError, match="takes longer"):
            bench.settle(0.001)
        go.set()
        verdict = bench.settle(LONG)
        assert judged == [0, bench.number]
        assert bench.verdicts == 2
        assert verdict.plan is not None
        assert verdict.plan.task is bench.task


def test_the_space_is_built_once_while_it_stays_the_same(bench, monkeypatch):
    built = []
    make = hognose.Scene.from_obstacles
    monkeypatch.setattr(hognose.Scene, "from_obstacles", lambda *given: built.append(1) or make(*given))
    bench.settle(LONG)
    scene = bench.task.scene
    before = len(built)
    for change in (
        move(1, 0.0, 0.0, 0.2),
        edits.set_margin(0.001),
        edits.set_order(4),
        edits.set_robot("sjtu-25dof-99"),
    ):
        bench.edit(change)
        bench.settle(LONG)
        assert bench.task.scene is scene
    assert len(built) == before
    bench.edit(lambda spec: spec.model_copy(update={"obstacle": ()}))
    assert bench.settle(LONG).plan is None or bench.task.scene.names == ()
    assert bench.task.scene.names == ()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (move(1, 0.0, 0.0, 0.0), "path.way_points"),
        (move(7, 0.0, 0.0, 0.0), "there is no way-point 8; there are 3"),
        (move(1, np.nan, 0.0, 0.0), "finite"),
        (edits.remove_way_point(0), "entrance cannot be removed"),
        (edits.remove_way_point(2), "target cannot be removed"),
        (edits.set_step(0.0), "motion.step"),
        (edits.set_margin(-1.0), "margin"),
        (edits.set_order(0), "path.order"),
        (edits.set_method("x"), "motion.method"),
        (edits.set_robot("no-such-robot"), "no-such-robot"),
    ],
)
def test_an_edit_that_makes_no_sense_changes_nothing(bench, change, words):
    before, verdict = bench.task, bench.settle(LONG)
    with pytest.raises(InputError, match=words):
        bench.edit(change)
    assert bench.task is before
    assert bench.settle(LONG) is verdict
    assert not bench.dirty
    assert not bench.can_undo


def test_an_edit_without_effect_is_none(bench):
    bench.edit(edits.set_margin(bench.spec.margin))
    assert not bench.can_undo


def test_a_search_is_one_step_can_be_stopped_and_its_route_dragged():
    task = hognose.load_task("find-a-way")
    with Workbench(task) as bench:
        assert bench.settle(LONG).headline == "NOT GOOD: no route yet: press Find a route"
        bench.search(LONG)
        with pytest.raises(InputError, match="a search is running"):
            bench.search(1.0)
        eventually(lambda: bench.spec.path.target is None)
        bench.stop_search()
        assert not bench.searching
        assert bench.task.scene is task.scene
        verdict = bench.settle(LONG)
        assert verdict.good
        route = bench.spec
        bench.undo()
        assert bench.task is task
        assert not bench.can_undo
        assert bench.settle(LONG).good  # the last route, judged as the search's
        bench.redo()
        assert bench.spec is route
        inner = np.add(route.path.way_points[1], (1e-4, 0, 0))
        bench.edit(edits.move_way_point(1, inner))
        assert bench.settle(LONG).plan is not None
        assert "around the lance" in bench.task.scene.names


def test_what_was_asked_of_a_search_is_asked_of_its_way_points_when_they_are_dragged():
    wished = np.array((0.0, 0.2, 1.0))
    box = {"center": (0.15, 0.2, 0.2), "size": (0.05, 0.05, 0.05)}
    asked = {"target": (0.03, 0.04, 0.4), "via": ((0.02, 0.01, 0.2),), "keep_out": (box,)}
    asked |= {"tip_direction": tuple(wished.tolist()), "tip_cone_deg": 5.0}
    data = small().spec.model_dump(by_alias=True) | {"path": asked}
    with Workbench(Task(TaskSpec.model_validate(data), ROBOT)) as bench:
        way = [(0.0, 0.0, 0.0), (0.02, 0.01, 0.2), (0.025, 0.02, 0.3), (0.03, 0.04, 0.4)]
        bench.edit(edits.take_route(way))  # as a search does
        assert bench.settle(LONG).good
        assert bench.task.scene.names == ("ball", "keep-out 1")
        outcomes = set()
        for y in np.linspace(0.012, 0.03, 7):
            bench.edit(move(2, 0.025, y, 0.3), "drag")
            verdict = bench.settle(LONG)
            assert verdict.plan is not None
            tip = verdict.plan.body[-1, -1] - verdict.plan.body[-1, -2]
            angle = np.degrees(np.arccos(tip @ wished / np.linalg.norm(tip) / np.linalg.norm(wished)))
            failed = [problem.partition(":")[0] for problem in verdict.problems]
            assert failed == (["tip direction"] if angle > 5 else [])
            outcomes.add(verdict.good)
        assert outcomes == {True, False}
        bench.edit(move(2, 0.025, 0.02, 0.3), "drag")
        bench.edit(move(1, 0.021, 0.01, 0.2))
        problems = bench.settle(LONG).problems
        assert [problem.partition(":")[0] for problem in problems] == ["path through via"]


def test_an_edit_ends_a_search_and_nothing_comes_of_it_any_more():
    with Workbench(hognose.load_task("find-a-way")) as bench:
        bench.search(LONG)
        assert bench.searching
        bench.edit(edits.set_margin(0.004))
        assert not bench.searching
        spec = bench.spec
        eventually(lambda: "stopped" in bench.search_said)
        assert bench.spec is spec


def test_a_search_in_vain_says_why():
    task = hognose.load_task("find-a-way")
    far = task.spec.path.model_copy(update={"target": (0.0, 0.0, 9.0)})
    with Workbench(Task(task.spec.model_copy(update={"path": far}), task.robot)) as bench:
        bench.search(5.0)
        eventually(lambda: not bench.searching)
        assert "too short" in bench.search_said
        for seconds in (0.0, -1.0, float("nan")):
            with pytest.raises(InputError, match="time"):
                bench.search(seconds)


def test_closing_twice_is_harmless_and_nothing_settles_then(bench):
    bench.settle(LONG)
    bench.close()
    bench.close()
    bench.edit(edits.set_margin(0.001))
    with pytest.raises(HognoseError, match="closed"):
        bench.settle(LONG)


def test_many_threads_may_edit_at_once(bench):
    def work(k: int) -> None:
        for j in range(20):
            bench.edit(move(1, 0.001 * k, 1e-4 * j, 0.2))
            if j % 3 == 0:
                bench.undo()

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    verdict = bench.settle(LONG)
    assert verdict.number == bench.number
    assert verdict.plan.task is bench.task
    while bench.can_undo:
        bench.undo()
    assert not bench.dirty
