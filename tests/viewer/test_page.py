"""The page without a browser: what it shows of which version of the task, by a clock of the test's own."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from workbench_makers import LONG, ROBOT, move, ours, small

import hognose
from hognose.following import METHODS, OF_SECTIONS
from hognose.planning import Task, TaskSpec
from hognose.planning.base_spec import BaseSpec
from hognose.planning.base_words import base_words
from hognose.report.camera import Camera, view_axes
from hognose.scene import Scene
from hognose.scene.shapes.obstacles import Box
from hognose.viewer.model import edits, replanner
from hognose.viewer.model.arm_state import ArmState
from hognose.viewer.model.freshness import CALM
from hognose.viewer.model.replanner import Question
from hognose.viewer.model.workbench import Verdict, Workbench
from hognose.viewer.page import NO_CABLES, Page, with_space
from hognose.viewer.shapes import rgb
from hognose.viewer.sharing import recording
from hognose.viewer.stage import OUTDATED

GREY = rgb(OUTDATED)


@dataclass
class Planner:
    """A planner that waits where it is told to, and counts."""

    go: threading.Event = field(default_factory=threading.Event)
    begun: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.go.set()
        self._plan = replanner.judged

    def judged(self, question: Question) -> Verdict:
        self.begun.append(question.number)
        assert self.go.wait(LONG)
        return self._plan(question)


@pytest.fixture
def planner(monkeypatch: pytest.MonkeyPatch) -> Planner:
    made = Planner()
    monkeypatch.setattr(replanner, "judged", made.judged)
    return made


@pytest.fixture
def page(planner: Planner, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Page]:
    monkeypatch.setenv("HOGNOSE_CACHE", str(tmp_path / "cache"))
    made = Page(Workbench(small()), port=0)
    made.said = []  # pyright: ignore[reportAttributeAccessIssue]
    made.say = made.said.append  # pyright: ignore[reportAttributeAccessIssue]
    for part in (made.editing, made.steering, made.sharing):
        part._say = made.say
    settled(made)
    yield made
    planner.go.set()
    made.close()
    assert not ours()


def settled(page: Page) -> Verdict:
    """Time passes until the newest verdict is shown."""
    assert page.bench is not None
    verdict = page.bench.settle(LONG)
    page.update(0.0)
    page.update(CALM)
    return verdict


def words(page: Page) -> str:
    return page._verdict_panel._words.content


def grey(page: Page) -> bool:
    colours = page.stage._links.batched_colors
    return bool((colours == GREY).all())


def seen(page: Page, *names: str) -> list[bool]:
    """Whether parts of the stage are there to be seen."""
    parts = [getattr(page.stage, f"_{name}") for name in names]
    return [part is not None and bool(part.visible) for part in parts]


INTO_THE_BALL, BESIDE_THE_BALL = move(1, 0.1, 0.0, 0.2), move(1, 0.07, 0.0, 0.2)


def test_the_old_verdict_is_not_shown_while_a_new_edit_is_planned(page, planner):
    assert words(page).startswith("### GOOD: ")
    assert not grey(page)
    planner.go.clear()
    page.bench.edit(edits.set_margin(0.04))
    page.update(0.01)
    assert words(page).startswith("### planning …")
    assert "### GOOD" not in words(page)
    assert r"*before: GOOD: " in words(page)
    page.update(CALM)
    page.update(CALM)
    assert words(page).startswith("### planning …")
    assert grey(page)
    assert seen(page, "closest", "said", "bend") == [False] * 3
    assert page.timeline._slider.disabled
    assert "no motion of the current task" in page.timeline._said.content
    planner.go.set()
    assert not settled(page).good
    assert words(page).startswith("### NOT GOOD")
    assert not grey(page)
    assert not page.timeline._slider.disabled


def test_red_dots_ghost_and_time_line_go_with_the_motion_they_are_of(page):
    page.stage.with_ghost = True
    page.bench.edit(edits.set_margin(0.04))
    assert settled(page).plan is not None
    page._drawn = None
    page.update(0.0)
    assert seen(page, "contacts", "ghost", "links") == [True] * 3
    page.timeline.press("play / stop")
    page.bench.edit(INTO_THE_BALL)
    assert settled(page).plan is None
    assert words(page).startswith("### NO MOTION")
    assert "does not belong to this task" in words(page)
    assert grey(page)
    assert seen(page, "contacts", "ghost", "closest") == [False] * 3
    assert not page.timeline.clock.playing
    row = page.timeline.clock.row
    for button in ("play / stop", ">", ">|"):
        page.timeline.press(button)
        page.update(1.0)
    assert page.timeline.clock.row == row
    page.bench.undo()
    settled(page)
    assert not grey(page)
    assert seen(page, "contacts", "ghost", "links") == [True] * 3


def test_only_the_motion_of_the_task_as_it_is_now_is_shared(page, planner):
    event: Any = SimpleNamespace(client=object())
    before = page.bench.verdict
    assert page.sharing._asked_by(event) == (event.client, before.plan)
    planner.go.clear()
    page.bench.edit(INTO_THE_BALL)
    assert page.sharing._asked_by(event) is None
    assert "still being planned" in page.said[-1]
    planner.go.set()
    verdict = settled(page)
    assert page.sharing._asked_by(event) is None
    assert page.said[-1] == f"there is no motion to share: {verdict.headline}"


def test_a_recording_is_of_the_plan_that_was_the_tasks_when_it_was_asked_for(page, monkeypatch):
    got: list[tuple[str, bytes]] = []
    client: Any = SimpleNamespace(send_file_download=lambda name, data, **_: got.append((name, data)))
    drawn: list[object] = []
    monkeypatch.setattr("hognose.viewer.sharing.recording", lambda server, stage, plan: drawn.append(plan) or b"page")
    asked = page.bench.verdict.plan
    page.sharing._recording_asked(SimpleNamespace(client=client))
    page.sharing._recording_asked(SimpleNamespace(client=client))
    page.bench.edit(edits.set_margin(0.001))
    later = settled(page)
    assert drawn == [asked]
    assert got == [("small-recording.html", b"page")] * 2
    assert page.plan is later.plan
    assert not grey(page)


def test_an_edit_ends_the_steering_and_says_so(page):
    page.steering.active.value = True
    page.update(0.0)
    steered = page.steering.steered
    assert page.stick.steering
    steered.advance(0.05)
    page.update(0.0)
    assert words(page).startswith("### Steered by hand")
    page.bench.edit(edits.set_margin(0.001))
    page.update(0.0)
    assert (page.steering.steered, page.steering.active.value, page.stick.steering) == (None, False, False)
    assert "steer again from the entrance" in page.said[-1]
    settled(page)
    assert page.stage._links.batched_positions[-1][2] != pytest.approx(steered.joints[-2][2], abs=1e-3)
    page.steering.active.value = True
    page.update(0.0)
    assert page.steering.steered is not steered
    assert page.steering.steered.margin == 0.001


def test_what_is_steered_becomes_the_task_it_was_steered_in_or_none(page, monkeypatch):
    page.steering.active.value = True
    page.update(0.0)
    page.steering.steered.advance(0.1)
    make = page.steering.steered.task

    def edited_meanwhile(name: str) -> Any:
        page.bench.edit(edits.set_margin(0.002))
        return make(name)

    monkeypatch.setattr(page.steering.steered, "task", edited_meanwhile)
    page.steering._keep_asked = True
    before = page.bench.spec
    page.update(0.0)
    assert page.bench.spec == before.model_copy(update={"margin": 0.002})
    assert "edited meanwhile" in page.said[-1]


def test_what_was_asked_of_the_way_is_checked_of_what_was_steered(page):
    box = {"center": (0.3, 0.3, 0.2), "size": (0.1, 0.1, 0.1)}
    said = {"tip_direction": (1.0, 0.0, 0.2), "tip_cone_deg": 20.0, "keep_out": (box,)}
    path = small().spec.path.model_dump() | said
    page.bench.edit(lambda spec: spec.model_copy(update={"path": type(spec.path).model_validate(path)}))
    settled(page)
    page.steering.active.value = True
    page.update(0.0)
    page.steering.steered.advance(0.1)
    page.steering._keep_asked = True
    page.update(0.0)
    assert not page.steering.active.value
    verdict = settled(page)
    assert verdict.plan is not None
    assert page.bench.spec.path.keep_out == verdict.task.spec.path.keep_out != ()
    assert verdict.plan.scene.names == ("ball", "keep-out 1")
    assert [problem.partition(":")[0] for problem in verdict.problems] == ["tip direction"]


def test_an_arm_of_other_sections_is_steered_by_a_method_that_steers_and_drawn_along_its_curve(page):
    fitted = hognose.load_task("baffled-tank")
    assert fitted.spec.motion.method == "fitted"
    motion = fitted.spec.motion.model_copy(update={"method": "aim"})
    task = Task(fitted.spec.model_copy(update={"motion": motion}), fitted.robot)
    steered = page.steering._at_entrance(fitted)
    assert steered.method == "aim"
    assert page.said[-1] == "no arm is steered by fitted, which needs a path that is known to its end: steered by aim"
    said = len(page.said)
    assert page.steering._at_entrance(task).method == "aim"
    assert len(page.said) == said, "the method of the task is nothing to be said"
    for _ in range(10):
        steered.advance(0.001, (10.0, 0.0))
    state = ArmState.of_steered(steered)
    assert len(state.vertices) == len(task.robot.chord_radii) + 1 > 4
    assert np.array_equal(state.outline, state.vertices)
    assert state.clearance.shape == (3,)
    ends = np.searchsorted(task.robot.chord_sections, [1, 2])
    assert np.abs(state.vertices[[0, *ends, -1]] - state.joints).max() < 1e-12


def test_the_methods_to_choose_from_are_those_for_the_kind_of_the_arm(page):
    field = page.editing._method
    assert (tuple(field.options), field.value) == (tuple(METHODS), "exact")
    page.bench.edit(edits.set_method("fitted"))
    page.update(0.0)
    assert (tuple(field.options), field.value) == ((*METHODS, "fitted"), "fitted")
    page.bench.edit(edits.set_robot("metabot-3arc"))
    page.update(0.0)
    assert (tuple(field.options), field.value) == (tuple(OF_SECTIONS), "fitted")
    page.bench.edit(edits.set_method("exact"))
    page.bench.edit(edits.set_robot("sjtu-25dof"))
    page.update(0.0)
    assert (tuple(field.options), field.value) == (tuple(METHODS), "exact")


def test_leaving_the_steering_takes_the_steered_arm_away(page):
    page.bench.edit(INTO_THE_BALL)
    settled(page)
    page._plan = None  # as on a page that never had a motion
    page.steering.active.value = True
    page.update(0.0)
    page.steering.steered.advance(0.05)
    page.update(0.0)
    assert seen(page, "links", "path") == [True, True]
    page.steering.active.value = False
    page.update(0.0)
    assert seen(page, "links", "ahead", "said", "closest", "bend") == [False] * 5
    page.steering.active.value = True
    page.update(0.0)
    assert seen(page, "links") == [True]


def test_to_steer_ends_a_search(page):
    page.bench.search(LONG)
    page.steering.active.value = True
    page.update(0.0)
    assert not page.bench.searching


def test_what_a_search_said_is_not_said_of_another_version(page):
    page.bench.search(LONG)
    page.bench.stop_search()
    said = page.bench.search_said
    assert "before" not in said
    page.bench.edit(edits.set_margin(0.001))
    assert page.bench.search_said.startswith("before the last edit: ")


@pytest.mark.parametrize("drags", [1, 100])
def test_drags_and_undos_in_a_row_leave_no_backlog(page, planner, drags):
    first = page.bench.spec
    planner.go.clear()
    begun = len(planner.begun)
    moves = 0
    for drag in range(drags):
        page.editing.choose(1)
        for place in np.linspace(0.0, 0.01, 20):
            page.editing.moved(1, np.array([0.02 + place, 1e-4 * drag, 0.2]))
            moves += 1
        page.update(0.03)
    for _ in range(drags):
        page.editing._back(True)
        page.update(0.03)
    assert page.bench.spec == first
    assert page.bench.number >= moves
    assert len(planner.begun) <= begun + 1  # the first one is being planned all the while
    planner.go.set()
    verdict = settled(page)
    assert verdict.number == page.bench.number
    assert len(planner.begun) <= begun + 2
    assert planner.begun[-1] == page.bench.number
    assert words(page).startswith("### GOOD")


def test_a_task_of_another_robot_is_drawn_as_that(page):
    page.bench.edit(edits.set_robot("sjtu-25dof-99"))
    verdict = settled(page)
    assert verdict.plan is not None
    assert verdict.plan.robot is not ROBOT
    assert isinstance(verdict.task, Task)
    assert len(page.stage._links.batched_positions) == verdict.plan.robot.sections


def test_cables_that_are_not_drawn_yet_are_refused_in_words(page):
    page._cables.value = True
    page.update(0.0)
    assert page.stage.with_cables
    assert seen(page, "cables", "disks") == [True, True]
    page.bench.edit(edits.set_robot("metabot-3arc"))
    settled(page)
    assert (page._cables.value, page.stage.with_cables, page.said.pop()) == (False, False, NO_CABLES)
    page._cables.value = True
    page.update(0.0)
    assert (page._cables.value, page.stage.with_cables, page.said.pop()) == (False, False, NO_CABLES)


def with_cart(*places: tuple[float, float, float]) -> Task:
    """The small task, through some places, with a cart that moves from (1, 0, 0) m off where it is placed on."""
    spec = small().spec.model_dump(by_alias=True, exclude_unset=True)
    motion = [{"time_s": 0.0, "position": (1.0, 0.0, 0.0)}, {"time_s": 10.0, "position": (3.0, 0.0, 0.0)}]
    cart = {"kind": "sphere", "name": "cart", "center": (1, 0, 0), "diameter": 0.1, "motion": motion}
    spec["obstacle"] = [*spec["obstacle"], cart]
    spec["path"] = {**spec["path"], "way_points": places or spec["path"]["way_points"]}
    return Task(TaskSpec.model_validate(spec), small().robot)


@pytest.fixture
def cart_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[Task], Page]]:
    monkeypatch.setenv("HOGNOSE_CACHE", str(tmp_path / "cache"))
    pages: list[Page] = []

    def opened(task: Task) -> Page:
        pages.append(Page(Workbench(task), port=0))
        settled(pages[-1])
        return pages[-1]

    yield opened
    for page in pages:
        page.close()


def test_where_there_is_no_motion_what_moves_is_seen_where_it_is_at_time_0(cart_page):
    page = cart_page(with_cart((0, 0, 0), (0.1, 0, 0.2), (0.1, 0, 0.4)))  # into the ball
    assert page.plan is None
    np.testing.assert_allclose(page.stage.walls.parts["cart"].position, (1, 0, 0), atol=1e-12)


def test_what_moves_is_seen_where_it_is_at_the_step_and_no_edit_puts_it_back(cart_page):
    page = cart_page(with_cart())
    row = 4
    page.timeline.go(row)
    page.update(0.0)
    there = (1 + 0.2 * page.plan.time[row], 0, 0)
    np.testing.assert_allclose(page.stage.walls.parts["cart"].position, there, atol=1e-9)
    page.bench.edit(INTO_THE_BALL)
    assert settled(page).plan is None
    np.testing.assert_allclose(page.stage.walls.parts["cart"].position, there, atol=1e-9)


def test_backwards_in_time_is_not_a_retraction_and_is_said_to_be_none(cart_page):
    for task, said in ((with_cart(), True), (small(), False)):
        shown = cart_page(task)
        shown.timeline.go(0)
        shown.update(0.0)
        assert "obstacles go backwards" not in shown.timeline._said.content
        shown.timeline.clock = replace(shown.timeline.clock, outwards=True, row=2)
        shown.update(0.0)
        shown.update(0.0)
        assert ("obstacles go backwards" in shown.timeline._said.content) == said


def test_what_moves_moves_in_a_recording(cart_page):
    page, moved = cart_page(with_cart()), []
    part = page.stage.walls.parts["cart"]
    page.stage.show = lambda *_: moved.append(np.array(part.position)[0])
    recording(page.server, page.stage, page.plan)
    np.testing.assert_allclose(moved, 1 + 0.2 * np.minimum(page.plan.time, 10.0), atol=1e-9)


def test_steering_past_what_moves_is_refused_with_a_sentence(cart_page):
    page, said = cart_page(with_cart()), []
    page.steering._say = said.append
    page.steering.active.value = True
    page.update(0.1)
    assert said
    assert "'cart' moves" in said[0]
    assert page.steering.steered is None


@pytest.mark.parametrize("base", [{}, {"kind": "arm"}, {"kind": "drum", "radius": 0.28}, {"direction": [0, -1, 0]}])
def test_the_first_picture_holds_the_whole_motion(tmp_path, monkeypatch, base):
    monkeypatch.setenv("HOGNOSE_CACHE", str(tmp_path / "cache"))
    said = small().spec
    turned = {"base": BaseSpec.model_validate(base), "obstacle": ()}
    page = Page(Workbench(Task(said.model_copy(update=turned), small().robot)), port=0)
    try:
        plan = settled(page).plan
        assert plan is not None
        camera = page.server.initial_camera
        eye, sight = np.array(camera.position), np.array(camera.look_at) - np.array(camera.position)
        seen = Camera(eye, view_axes(-sight), float(np.tan(0.5 * camera.fov)))
        places = np.concatenate([plan.joints.reshape(-1, 3), plan.way_points])
        pixels, depth = seen.project(places, (110, 100))
        assert (depth > 0.01).all()
        assert (pixels > 0).all()
        assert (pixels < (110, 100)).all()
        assert base_words(plan.task) in words(page).replace("\\", "")
    finally:
        page.close()


@pytest.mark.parametrize(("side", "held"), [(0.3, True), (30.0, False)])
def test_the_first_picture_holds_the_space_if_it_is_not_much_larger(side, held):
    scene = Scene.from_obstacles([Box(center=(0.0, 0.5 * side, 0.0), size=(side, side, side))])
    places = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    seen = with_space(places, scene)
    np.testing.assert_array_equal(seen[:2], places)
    if held:
        np.testing.assert_allclose(seen[2:].min(axis=0), scene.bounds[0, 0])
        np.testing.assert_allclose(seen[2:].max(axis=0), scene.bounds[0, 1])
        assert len(np.unique(seen[2:], axis=0)) == 8
    else:
        assert len(seen) == 2
