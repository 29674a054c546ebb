"""Routes of arms that no slider takes along: what is searched is what the base reaches, and the words are its own."""

import dataclasses
import re

import numpy as np
import pytest

import hognose
from hognose.errors import InfeasibleError, InputError
from hognose.planning import Task, TaskSpec
from hognose.route import Search
from hognose.route.fit.objective import Objective, judge
from hognose.route.lengths import longest_way
from hognose.route.search.bottleneck import narrowest
from hognose.route.search.clearance_grid import search_grid
from hognose.route.why.causes import plain_cause
from hognose.route.why.changes import further, longer, roomier, slower
from hognose.route.why.diagnosis import faults
from hognose.route.why.partial import along
from hognose.route.why.relaxations import objective_of

pytestmark = pytest.mark.slow

ARM = hognose.load_robot("sjtu-25dof")
WALL = {
    "kind": "board",
    "name": "wall",
    "center": [0, 0, 0.35],
    "size": [1, 1],
    "thickness": 0.01,
    "hole": [{"center": [0.05, 0], "diameter": 0.1}],
}
DRUM = {"kind": "drum", "radius": 0.28, "nozzle": 0.2}
BOX = {"low": (-0.3, -0.3, -1.3), "high": (0.3, 0.3, 0.4)}
CARRIER = {"kind": "arm"}
BOXED = {"kind": "arm", "workspace": BOX}


def to(base, target, *obstacles, **more):
    spec = {"name": "in", "robot": "sjtu-25dof", "base": base, "path": {"target": target}, "obstacle": obstacles}
    return Task(TaskSpec.model_validate({**spec, **more}), ARM)


class Never(Search):
    def run(self):
        raise AssertionError("searched")


@pytest.mark.parametrize(
    ("base", "target"),
    [(DRUM, (-0.03, 0.1, 0.7)), (CARRIER, (0.06, 0.02, 1.5)), (BOXED, (0.06, 0.02, 1.35))],
)
def test_a_route_to_what_the_base_reaches_is_found(base, target):
    plan = hognose.plan(to(base, target, WALL))
    assert plan.good
    np.testing.assert_allclose(plan.body[-1, -1], target, rtol=0, atol=1e-9)
    assert not plan.task.base.outside(plan.joints[:, 0]).any()
    assert plan.feed[-1] <= plan.task.base.feed_limit(ARM)
    assert (plan.feed[-1] > ARM.length) == (base["kind"] == "arm")


def test_a_base_reaches_what_its_straight_path_does():
    """With the first joint as far as it can be, the straight arm ends there."""
    for base in ({}, {"kind": "cart", "position": (0, 0, -1.2)}, DRUM):
        task = to(base, (0, 0, 0.5))
        stand = task.base
        first = stand.feed_limit(ARM) - stand.run
        assert stand.reach(ARM) == pytest.approx(first + ARM.length, abs=1e-12)
    assert to(CARRIER, (0, 0, 0.5)).base.reach(ARM) == np.inf


def test_a_slider_that_ends_early_reaches_less_and_a_drum_does_not():
    data = ARM.spec.model_dump(by_alias=True)
    data["feed"]["max"] = 0.5
    early = hognose.Robot.from_spec(type(ARM.spec).model_validate(data))
    for base in ({}, DRUM):
        stand = Task(to(base, (0, 0, 0.4)).spec, early).base
        assert stand.reach(early) == (0.5 if not base else pytest.approx(ARM.length - 0.2))
        assert stand.feed_limit(early) == (0.5 if not base else stand.farthest)


def test_a_target_beyond_the_drum_is_refused_before_the_search(monkeypatch):
    monkeypatch.setattr("hognose.route.planning.Search", Never)
    with pytest.raises(InfeasibleError) as caught:
        hognose.plan(to(DRUM, (0, 0, 60.0), WALL))
    said = str(caught.value)
    assert "in a straight line the way is 60000.0 mm, arm and drum reach 892.0 mm" in said
    assert "slider" not in said


def test_what_would_help_a_drum_is_no_slider():
    cause = plain_cause(to(DRUM, (0, 0, 1.0)))
    assert cause is not None
    assert [change.words(change.amounts[0]) for change in cause.changes] == ["two more sections (182 mm)"]
    task = to(DRUM, (0, 0, 1.0))
    assert further(task, 0.0) is None
    # With five more sections the coil pulls a cable farther than it goes.
    assert longer(task, 0.108).amounts == (2.0, 3.0, 4.0)
    tight = longer(to({**DRUM, "radius": 0.19}, (0, 0, 0.95)), 0.06)
    assert tight.amounts == ()


def test_a_target_beyond_a_workspace_is_refused_before_the_search(monkeypatch):
    monkeypatch.setattr("hognose.route.planning.Search", Never)
    task = to(BOXED, (0, 0, 3.5), WALL)
    with pytest.raises(InfeasibleError, match=r"there is no route to the target") as caught:
        hognose.plan(task)
    assert "the target at (0, 0, 3500) mm is 3100 mm from base.workspace" in str(caught.value)
    assert "slider" not in str(caught.value)
    assert roomier(task, 0.12).amounts[0] == 150
    assert roomier(to(CARRIER, (0, 0, 1)), 0.1).amounts == ()


def test_a_way_along_way_points_that_ends_beyond_a_workspace_is_refused_too():
    spec = to(BOXED, (0, 0, 1.4)).spec
    path = spec.path.model_copy(update={"target": None, "way_points": ((0, 0, 0), (0, 0.1, 1.0), (0, 0, 1.6))})
    with pytest.raises(InfeasibleError, match=r"is 1200 mm from base\.workspace, in which the first joint stays"):
        hognose.plan(Task(spec.model_copy(update={"path": path}), ARM))


@pytest.mark.parametrize("path", [{"target": (0, 0, 0.9)}, {"way_points": [(0, 0, 0), (0, 0, 0.9)]}])
def test_a_workspace_without_the_start_is_told_at_once(path, monkeypatch):
    monkeypatch.setattr("hognose.route.planning.Search", Never)
    base = {"kind": "arm", "workspace": {"low": (-0.3, -0.3, -1.0), "high": (0.3, 0.3, 0.4)}}
    with pytest.raises(
        InputError, match=r"base\.workspace: at feed 0 the first joint, at \(0, 0, -1092\) mm, is 92 mm"
    ):
        hognose.plan(to(base, (0, 0, 1), path=path))


def judged(task, way_points):
    points = np.array(way_points)
    guide = task.path_through(points).point(np.linspace(task.base.run, task.path_through(points).length, 50))
    free = np.arange(1, len(points)) < len(points) - 1
    objective = Objective(task.robot, task.base, task.scene, task.path_through, 3, 0.0233, 0.005, guide, free)
    found = judge(objective, points)
    assert found is not None
    return found


def test_a_way_whose_base_leaves_the_workspace_is_not_feasible_and_says_so():
    base = {"kind": "arm", "workspace": {"low": (-0.02, -0.02, -1.3), "high": (0.02, 0.02, 0.5)}}
    task = to(base, (0, 0, 1.45))
    found = judged(task, [[0, 0, 0], [0.05, 0, 0.3], [0.0, 0, 0.9], [0, 0, 1.45]])
    assert not found.feasible
    assert found.overruns["workspace"] > 1
    (said,) = faults(task, found)
    named = re.fullmatch(r"the first joint would have to be at (.*) mm, ([\d.]+) mm outside base\.workspace", said)
    assert named is not None, said
    assert float(named[2]) == pytest.approx(1e3 * np.linalg.norm(found.outside, axis=1).max(), abs=0.06)


def test_the_search_moves_a_way_back_into_the_workspace():
    """The derivatives of what is outside are those of the places of the first joint."""
    base = {"kind": "arm", "workspace": {"low": (-0.02, -0.02, -1.3), "high": (0.02, 0.02, 0.5)}}
    task = to(base, (0, 0, 1.45))
    points = np.array([[0, 0, 0], [0.05, 0, 0.3], [0.0, 0, 0.9], [0, 0, 1.45]])
    found = judged(task, points)
    values, rows = found._workspace_rows()
    assert len(values) > 5
    moved = points.copy()
    moved[1, 0] -= 1e-6
    after, _ = judged(task, moved)._workspace_rows()
    expected = (after - values[: len(after)]) / -1e-6
    np.testing.assert_allclose(expected, rows[: len(after), 0], rtol=0.2)  # they hold the spline's parameters


def test_a_carrier_is_as_fast_as_it_is_said_to_be():
    assert plain_cause(to(CARRIER, (0, 0, 1.0), motion={"period_s": 0.01})) is None
    task = to({"kind": "arm", "speed": 0.1}, (0, 0, 1.0), motion={"period_s": 0.02})
    cause = plain_cause(task)
    assert cause is not None
    assert cause.sentences[0].endswith("the carrier at most at 100 mm/s")
    assert slower(task).amounts[0] == 100


def test_what_is_searched_for_a_carrier_is_bounded():
    task = to(CARRIER, (0, 0, 1.5))
    assert longest_way(task) == pytest.approx(1.5 + ARM.length / 2)


def test_what_shuts_a_carried_arm_out_of_what_is_searched_is_no_proof():
    """Round the wall there is a way; it is only longer than those that are looked for."""
    lid = {"kind": "board", "name": "lid", "center": [0, 0, 0.3], "size": [1.6, 1.6], "thickness": 0.01}
    task = to(CARRIER, (0, 0, 0.6), lid)
    search = Search(task, None, 0)
    search.run()
    gap = narrowest(task, search_grid(task))
    assert search.best is None
    assert gap is not None
    assert not gap.proven
    assert "Give places `via` that lead round it" in gap.sentences[0]


def test_what_is_too_far_for_a_grid_is_refused_before_the_search(monkeypatch):
    monkeypatch.setattr("hognose.route.planning.Search", Never)
    with pytest.raises(InfeasibleError) as caught:
        hognose.plan(to(CARRIER, (0, 0, 70), WALL))
    assert str(caught.value) == (
        "in: no route to the target was found.\n  in a straight line the way is 70000.0 mm; no way longer than 10 arms "
        "of 1092 mm is searched. Give `way_points` (or are `units` and `target` right?)"
    )


TURNING = [[0, 0, 0], [0.05, 0, 0.3], [-0.05, 0, 0.6], [0.05, 0, 0.9], [0, 0, 1.45]]


@pytest.mark.parametrize("share", [1.05, 0.95])
def test_a_way_is_feasible_only_if_the_carrier_turns_so_fast(share):
    task = to(CARRIER, (0, 0, 1.45))
    found = judged(task, TURNING)
    assert found.feasible
    most = share * float(found.turn_rates.max())
    slower = judge(dataclasses.replace(found.objective, turn_speed=most), found.way_points)
    assert slower is not None
    assert slower.overruns["turn"] == pytest.approx(1 / share)
    assert slower.feasible == (share > 1)
    said = [words for words in faults(task, slower) if "carrier" in words]
    expected = f"the carrier would have to turn the arm at {np.degrees(most / share):.1f} deg/s; it can at "
    assert [words.startswith(expected) for words in said] == ([] if share > 1 else [True])


def test_the_search_makes_a_way_turn_the_carrier_more_slowly():
    """The derivatives of how fast it turns are those of the first link."""
    task = to(CARRIER, (0, 0, 1.45))
    points = np.array(TURNING)
    found = judged(task, points)
    objective = dataclasses.replace(found.objective, turn_speed=0.5 * float(found.turn_rates.max()))
    here = judge(objective, points)
    assert here is not None
    values, rows = here._turn_rows()
    assert len(values) > 3
    slope = 2 * rows.T @ values
    step = 1e-5 * (slope / np.linalg.norm(slope)).reshape(3, 3)
    both = [judge(objective, points + np.pad(sign * step, ((1, 1), (0, 0)))) for sign in (1, -1)]
    squares = [float(np.sum(each._turn_rows()[0] ** 2)) for each in both if each is not None]
    assert squares[0] - squares[1] == pytest.approx(2 * slope @ step.ravel(), rel=0.3)


def test_a_search_knows_how_fast_the_carrier_of_its_task_turns():
    task = to({"kind": "arm", "turn_speed_deg_s": 7.0}, (0, 0, 1.45))
    assert objective_of(task, judged(task, TURNING).objective).turn_speed == pytest.approx(np.radians(7.0))


@pytest.mark.parametrize("base", [{}, {"kind": "cart", "position": (0, 0, -1.25)}])
def test_the_beginning_of_a_way_is_good_as_far_as_its_bends_are(base):
    task = to(base, (0.25, 0, 0.55))
    points = [*task.way_points[:-1], (0, 0, 0.3), (0, 0, 0.5), (0.25, 0, 0.55)]  # a bend that no joint takes
    spline = judged(task, points)
    assert not spline.feasible
    part = along(task, spline)
    assert part is not None
    assert part.good
    assert part.body[-1, -1, 2] > 0.3
