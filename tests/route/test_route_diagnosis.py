"""When there is no route: what the error says, what it says would help, and the insertion that comes with it."""

import dataclasses
import re

import numpy as np
import pytest

import hognose
from hognose.planning import Task, TaskSpec, run_checks
from hognose.planning.checks.mechanics import why_it_cannot_begin
from hognose.robot import Robot, RobotSpec
from hognose.route import Search
from hognose.route.fit.objective import Objective, judge
from hognose.route.search.bottleneck import narrowest
from hognose.route.search.clearance_grid import search_grid
from hognose.route.search.search import BLOCKED
from hognose.route.why.causes import likely_cause, plain_cause
from hognose.route.why.changes import bendier, further, longer, narrower_margin, slower, thinner, together, wider_cone
from hognose.route.why.diagnosis import DiagnosisInterrupted, explained, faults
from hognose.route.why.relaxations import Relaxations
from hognose.wording import at_least_mm

pytestmark = pytest.mark.slow


def wall(hole=None, name="wall", size=1.0):
    """A wall across the way at 350 mm, with a hole aside or none."""
    board = {"kind": "board", "name": name, "center": [0, 0, 0.35], "size": [size, size], "thickness": 0.01}
    return board if hole is None else {**board, "hole": [{"center": [0.05, 0], "diameter": hole}]}


def task_with(*obstacles, robot=None, target=(0.08, 0.03, 0.7), **more):
    path = {"target": target, **more.pop("path", {})}
    spec = {"name": "behind", "robot": "sjtu-25dof", "path": path, "obstacle": obstacles, **more}
    return Task(TaskSpec.model_validate(spec), robot or hognose.load_robot("sjtu-25dof"))


def arm_with(bend_limit_deg=None, feed_max=None):
    """The bundled arm with other limits."""
    data = hognose.load_robot("sjtu-25dof").spec.model_dump(by_alias=True)
    for section in data["section"]:
        section["bend_limit_deg"] = bend_limit_deg or section["bend_limit_deg"]
    data["feed"]["max"] = feed_max or data["feed"]["max"]
    return Robot.from_spec(RobotSpec.model_validate(data))


def limited(**limits):
    """The bundled arm with other limits of motion."""
    data = hognose.load_robot("sjtu-25dof").spec.model_dump(by_alias=True)
    data["limits"] |= limits
    return Robot.from_spec(RobotSpec.model_validate(data))


def weightless():
    """The bundled arm as if it had no weight: a longer one is not too heavy for its cables."""
    return Robot.from_spec(
        RobotSpec.model_validate(hognose.load_robot("sjtu-25dof").spec.model_dump(by_alias=True) | {"cables": None})
    )


def refusal(task):
    """What is said where nothing was searched yet, and the search."""
    search = Search(task, None, 0)
    return explained(search), search


@pytest.fixture(scope="module")
def narrow():
    """A search that tried a hole which is too narrow, and what is said of it."""
    search = Search(task_with(wall(0.05)), None, 0)
    search.run()
    assert search.closest is not None
    # It was seen that all ways are too narrow: nothing is left to try.
    assert (search.attempts, search.cut_short) == (BLOCKED, "")
    return explained(search), search


def test_a_hole_that_is_too_narrow_is_named_with_what_is_there_and_what_is_needed(narrow):
    said = str(narrow[0])
    found = re.search(r"narrows to ([\d.]+) mm at \(50, 0, (\d+)\) mm, beside 'wall'; (.*)", said)
    assert found is not None, said
    assert float(found[1]) == pytest.approx(50, abs=0.5)
    assert 344 <= int(found[2]) <= 356
    assert found[3] == "the body of 45 mm with 5 mm margin needs 55 mm"


def test_the_insertion_ends_before_the_hole_and_is_good(narrow):
    part = narrow[0].plan
    assert all(check.ok for check in run_checks(part))
    assert 0.25 < part.body[-1, -1, 2] < 0.345
    assert part.task.name == "behind, only as far as a way was found"
    ends = re.search(r"feeds (\d+) mm and ends at \(.*\) mm, (\d+) mm from the target", str(narrow[0]))
    assert ends is not None
    assert int(ends[1]) == round(1e3 * part.feed[-1])
    assert int(ends[2]) == round(1e3 * np.linalg.norm(part.body[-1, -1] - narrow[1].task.way_points[-1]))


def test_what_is_said_to_help_was_planned_and_checked(narrow):
    said, search = str(narrow[0]), narrow[1]
    found = re.search(r"with (\d+) mm less body diameter \((\d+) mm\) a route is found \(([\d.]+) mm certified\)", said)
    assert found is not None, said
    assert int(found[1]) + int(found[2]) == 45
    assert 5 <= int(found[1]) <= 8  # 5 mm are missing straight through, and links do not pass straight
    less, margin = Relaxations(search).run(likely_cause(search.task, search_grid(search.task), search.closest))
    assert (less.sentence in said, margin.sentence in said) == (True, True)
    assert 2e3 * less.plan.robot.body_radii == pytest.approx(np.full(12, float(found[2])))
    assert less.plan.robot.bend_limits == pytest.approx(search.task.robot.bend_limits)
    assert margin.plan.task.margin in (0.002, 0.001)
    for relaxation in (less, margin):
        assert all(check.ok for check in run_checks(relaxation.plan))
        assert relaxation.clearance >= relaxation.plan.task.margin
        assert relaxation.plan.task.spec.path.target == search.task.spec.path.target
        assert relaxation.plan.scene.names == search.task.scene.names


def test_nothing_is_said_of_a_hole_that_is_wide_enough():
    task = task_with(wall(0.056))
    assert plain_cause(task) is None
    assert narrowest(task, search_grid(task)) is None


@pytest.mark.parametrize(("hole", "proven"), [(0.054, False), (0.044, False), (0.03, True)])
def test_the_width_of_a_hole_is_found(hole, proven):
    task = task_with(wall(hole))
    gap = narrowest(task, search_grid(task))
    assert gap is not None
    assert hole - 5e-4 <= 2 * gap.half <= hole
    assert gap.missing == pytest.approx(0.0275 - gap.half)
    assert (gap.proven, gap.closed) == (proven, False)


def test_an_arm_that_is_too_short_is_told_by_how_much_and_how_many_sections_help():
    error, search = refusal(task_with(target=(0, 0.2, 1.25)))
    assert f"{1e3 * (np.hypot(0.2, 1.25) - 1.092):.1f} mm too short" in str(error)
    assert "there is no route" in str(error)
    found = re.search(
        r"with (two|3) more sections \((182|273) mm, and (\d+) mm more slider travel\) a route", str(error)
    )
    assert found is not None, error
    assert int(found[3]) == int(found[2]) - 8  # the slider's travel is 8 mm longer than the arm
    assert error.plan.feed[-1] > 0.9 * search.task.robot.length
    assert all(check.ok for check in run_checks(error.plan))


def test_a_slider_that_ends_too_early_is_told_by_how_much():
    error, _ = refusal(task_with(robot=arm_with(feed_max=0.7), target=(0, 0.05, 0.79)))
    found = re.search(r"with (\d+) mm more slider travel a route is found", str(error))
    assert found is not None, error
    assert 91.6 <= int(found[1]) <= 120  # the straight way is 791.6 mm long


def test_a_target_at_a_hundred_times_the_distance_is_a_matter_of_units():
    error, _ = refusal(task_with(target=(0, 0, 70)))
    assert "68908.0 mm too short" in str(error)
    assert "are `units` and `target` right?" in str(error)
    assert "section" not in str(error)


def test_what_closes_the_target_off_is_named_and_nothing_is_tried():
    error, _ = refusal(task_with(wall(name="lid", size=4.0)))
    assert "there is no route to the target.\n  the target is closed off" in str(error)
    assert re.search(r"'lid' is in the way at \(\d+, \d+, 345\) mm", str(error))
    assert " with " not in str(error)
    assert all(check.ok for check in run_checks(error.plan))
    assert 0.25 < error.plan.body[-1, -1, 2] < 0.345


def test_a_wall_that_the_arm_is_too_short_to_go_round_closes_nothing_off():
    """What bounds the search is the arm's reach: round the wall there is a way, for a longer arm."""
    error, _ = refusal(task_with(wall(name="lid"), robot=weightless()))
    found = re.search(
        r"no route to the target\.\n  the way round 'lid' is too long: at \(\d+, \d+, 345\) mm it bars the way, and "
        r"round it are at least about (\d+) mm; arm and slider reach 1092\.0 mm",
        str(error),
    )
    assert found is not None, error
    shortest = np.hypot(0.5275, 0.345) + np.hypot(0.4475, 0.345)  # by the nearer edge, which the body keeps away from
    assert 0.93 * shortest < int(found[1]) / 1e3 < shortest
    assert "closed off" not in str(error)
    assert re.search(r"with \d more sections .* a route is found", str(error))


def test_a_search_cut_short_says_so_first():
    """Whatever else is wrong: with more time there may be a route."""
    task = task_with(wall(0.08), target=(-0.1, 0, 0.75), robot=arm_with(bend_limit_deg=6))
    search = Search(task, 1e-9, 0)
    search.run()
    lines = str(explained(search)).split("\n  ")
    assert lines[0] == "behind: no route to the target was found."
    assert lines[1] == "the search was cut short: its 1e-09 s were over after 0 attempts; more time may find a route"
    search = Search(task, None, 0, most=1)
    search.run()
    assert search.cut_short.startswith("the search was cut short: its fixed amount of work was done after one attempt")


def test_a_search_that_is_interrupted_says_how_far_it_was():
    def interrupt(stage):
        if stage.endswith("passage 2"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match="the search was cut short: it was interrupted after 2 attempts"):
        hognose.plan(task_with(wall(0.05)), progress=interrupt)


def test_what_is_certain_is_not_blamed_on_time():
    search = Search(task_with(wall(name="lid", size=4.0)), None, 0)
    search.run()
    assert (search.attempts, search.passages, search.cut_short) == (3, 0, "")


def judged(task, way_points, **changes):
    """What the arm makes of a spline, with other things in what is wanted."""
    points = np.array(way_points)
    path = task.path_through(points)
    guide = path.point(np.linspace(task.robot.length, path.length, 100))
    speed = task.spec.motion.step / task.spec.motion.period_s
    objective = Objective(
        task.robot,
        task.base,
        task.scene,
        task.path_through,
        3,
        speed,
        task.margin,
        guide,
        np.ones(len(points) - 1, bool),
    )
    found = judge(dataclasses.replace(objective, **changes), points)
    assert found is not None
    return list(faults(task, found))


GENTLE = [[0, 0, 0], [0.03, 0, 0.3], [0.1, 0, 0.6]]


@pytest.mark.parametrize(
    ("way_points", "more", "limits", "said"),
    [
        (GENTLE, {}, {}, None),
        (GENTLE, {}, {"joint_speed_deg_s": 0.5}, r"a joint would have to turn at [\d.]+ deg/s; it can at 0.5 deg/s"),
        (
            [[0, 0, 0], [0.3, 0, 0.55], [0, 0, 1.05]],
            {},
            {},
            r"the arm is \d+\.\d mm too short for the way that was found",
        ),
        (
            [[0, 0, 0], [0.06, 0, 0.15], [0, 0, 0.3], [0.0, 0.0, 0.6]],
            {},
            {},
            r"section \d+ would have to bend [\d.]+ deg at \(.*\) mm, [\d.]+ deg more than it can",
        ),
        (
            GENTLE,
            {"tip_direction": np.array([0.0, 1.0, 0.0]), "tip_cone": np.radians(5.0)},
            {},
            r"the nose points [\d.]+ deg away from tip_direction; tip_cone_deg is 5",
        ),
    ],
)
def test_what_a_spline_exceeds_is_said(way_points, more, limits, said):
    robot = limited(**limits)
    task = task_with(robot=robot, path={"tip_direction": [0, 1, 0], "tip_cone_deg": 5.0} if more else {})
    found = judged(task, way_points, **more)
    if said is None:
        assert not found
    else:
        assert re.search(said, "; ".join(found)), found


@pytest.mark.parametrize(
    ("y", "margin", "said"),
    [
        (0.06, 0.02, r"a link would be 1\d\.\d+ mm from 'ball' at \(.*\) mm; 20 mm are wanted"),
        (0.0, 0.005, r"a link would run into 'ball' at \(.*\) mm"),
    ],
)
def test_what_a_link_comes_close_to_is_said(y, margin, said):
    ball = {"kind": "sphere", "name": "ball", "center": [0.03, y, 0.3], "diameter": 0.05}
    assert re.fullmatch(said, "; ".join(judged(task_with(ball, margin=margin), GENTLE)))


def test_a_target_too_close_to_an_obstacle_is_told_by_how_much():
    error, _ = refusal(task_with({"kind": "sphere", "name": "ball", "center": [0.12, 0.03, 0.7], "diameter": 0.03}))
    assert "there is no route to the target." in str(error)
    assert "the target at (80, 30, 700) mm is 24.969 mm from 'ball'" in str(error)
    assert "needs 27.5 mm: 2.5 mm more" in str(error)


def test_a_task_that_feeds_faster_than_the_slider_is_told_a_speed_that_does():
    error, _ = refusal(task_with(motion={"period_s": 0.05}))
    assert "the task feeds at 70 mm/s" in str(error)
    assert "the slider at most at 50 mm/s" in str(error)
    found = re.search(r"with a feed of (\d+) mm/s instead of 70 mm/s a route is found", str(error))
    assert found is not None
    assert int(found[1]) <= 50
    assert error.plan is None


def test_joints_that_bend_too_little_are_told_which_and_how_far_they_would_have_to():
    error, _ = refusal(task_with(wall(0.08), robot=arm_with(bend_limit_deg=6), target=(-0.1, 0, 0.75)))
    found = re.search(
        r"on the way found with ±(\d+)° joints: section (\d+) would have to bend ([\d.]+) deg at .*, ([\d.]+) deg more",
        str(error),
    )
    assert found is not None, error
    assert int(found[1]) in (10, 15, 20)
    assert 6 < float(found[3]) <= int(found[1])
    assert float(found[4]) == pytest.approx(float(found[3]) - 6, abs=0.11)
    assert f"with ±{found[1]}° joints a route is found" in str(error)


def test_a_route_found_at_last_is_the_searchs():
    """The smallest of changes leads to a spline that needs none."""
    error, search = refusal(task_with(wall(0.1)))
    assert search.best is not None
    assert error.plan is search.best.plan
    assert all(check.ok for check in run_checks(search.best.plan))
    assert search.best.plan.task is search.task
    assert f"a route was found at last, {at_least_mm(search.best.clearance, 1)} mm certified" in str(error)


def test_a_route_found_at_last_is_returned(monkeypatch):
    class Idle(Search):
        def run(self):
            """Find nothing."""

    monkeypatch.setattr("hognose.route.planning.Search", Idle)
    plan = hognose.plan(task_with(wall(0.1)))
    assert all(check.ok for check in run_checks(plan))
    assert plan.body[-1, -1] == pytest.approx([0.08, 0.03, 0.7])


def test_what_is_plainly_impossible_is_not_searched(monkeypatch):
    class Never(Search):
        def run(self):
            raise AssertionError("searched")

    monkeypatch.setattr("hognose.route.planning.Search", Never)
    with pytest.raises(hognose.InfeasibleError, match=r"68908\.0 mm too short"):
        hognose.plan(task_with(target=(0, 0, 70)))


@pytest.mark.parametrize(
    ("at", "known"),
    [("finding", []), (r"trying \d+ mm", ["blocked"]), ("trying a margin", ["blocked", "less body diameter"])],
)
def test_an_interrupt_says_what_is_known(narrow, at, known):
    error, search = narrow

    def interrupt(stage):
        if re.match(at, stage):
            raise KeyboardInterrupt

    again = dataclasses.replace(search, progress=interrupt)
    with pytest.raises(DiagnosisInterrupted) as caught:
        explained(again)
    first, *between, last = str(caught.value).split("\n  ")
    assert re.fullmatch(r"behind: no route to the target was found among (one|\d) passages?\.", first)
    assert last == "interrupted before all was tried"
    lines = [line for line in between if "insertion" not in line]
    assert len(lines) == len(known)
    assert all(words in line and line in str(error) for words, line in zip(known, lines, strict=True))
    assert (caught.value.plan is not None) == bool(known)


def test_without_time_it_says_what_was_not_tried(narrow):
    search = dataclasses.replace(narrow[1], seconds=1e-9, began=narrow[1].began - 100)
    said = str(explained(search))
    assert "beside 'wall'" in said
    assert re.search(r"no time was left to try \d+ mm less body diameter \(\d+ mm\); a margin of 1 mm; give more", said)
    assert "a route is found" not in said
    assert "not even with" not in said


def applied(change, task, amount):
    made = change.made(task, amount)
    assert made is not None
    return made


def test_changes_grow_and_are_what_they_say():
    task = task_with(path={"tip_direction": [0, 0, 1]})
    for change in (bendier(task), longer(task, 0.1), thinner(task, 0.004), slower(task), wider_cone(task)):
        assert change.amounts
        assert len(set(map(change.words, change.amounts))) == len(change.amounts)
        assert all(change.made(task, amount) is not None for amount in change.amounts)
    assert thinner(task, 0.004).amounts[0] == 8
    assert applied(thinner(task, 0.004), task, 9).robot.body_radii == pytest.approx(np.full(12, 0.018))
    assert np.degrees(applied(bendier(task), task, 35).robot.bend_limits) == pytest.approx(np.full((12, 2), 35))
    assert longer(task, 0.1).amounts[0] == 2
    assert applied(longer(task, 0.1), task, 2).robot.sections == 14
    assert longer(task, 0.1).words(1) == "one more section (91 mm, and 83 mm more slider travel)"
    assert narrower_margin(task, 0.026).amounts == (3, 2, 1)
    assert narrower_margin(task, 0.022).amounts == ()
    assert applied(slower(task), task, 10).spec.motion.period_s == pytest.approx(0.35)
    assert further(task, 0.0) is None
    shorter = task_with(robot=arm_with(feed_max=1.0))
    travel = further(shorter, 0.055)
    assert travel is not None
    assert travel.amounts == pytest.approx((60, 70, 80, 90, 92))
    assert applied(travel, shorter, 60).robot.spec.feed.max == pytest.approx(1.06)
    assert further(shorter, 0.1) is None


def test_no_change_is_more_than_the_cables_hold():
    """As far as the straight arm before the entrance stands, and no further; without a weight there is no such end."""
    task, light = task_with(), task_with(robot=weightless())
    for of in (lambda task: thinner(task, 0.004), lambda task: longer(task, 0.6)):
        held, all_of_them = of(task), of(light)
        assert 0 < len(held.amounts) < len(all_of_them.amounts)
        assert held.amounts == all_of_them.amounts[: len(held.amounts)]
        beyond = all_of_them.amounts[len(held.amounts)]
        assert not why_it_cannot_begin(applied(held, task, held.amounts[-1]))
        assert why_it_cannot_begin(applied(held, task, beyond))


@pytest.mark.parametrize(
    ("way", "said"), [(2.1, "it would not stand, or could not start"), (2.3, "are `units` and `target` right?")]
)
def test_an_arm_that_no_more_sections_help_is_told_why(way, said):
    cause = plain_cause(task_with(target=(0, 0, way)))
    assert cause is not None
    assert cause.changes == ()
    assert cause.sentences[0].endswith(said)


def test_two_changes_grow_together():
    task = task_with()
    both = together(thinner(task, 0.004), bendier(task))
    assert both is not None
    assert both.words(both.amounts[0]) == "8 mm less body diameter (37 mm) and ±30° joints"
    last = applied(both, task, both.amounts[-1])
    assert np.degrees(last.robot.bend_limits.min()) == pytest.approx(60)
    assert last.robot.body_radii.max() < 0.0185
    assert last.scene is task.scene
    assert both.then is not None
    less = both.then(both.amounts[-1])
    assert less.words(less.amounts[0]) == "8 mm less body diameter (37 mm) and ±60° joints"
    assert less.then is not None
    least = less.then(less.amounts[0])
    assert [least.words(amount)[36:] for amount in least.amounts[:2]] == ["±30° joints", "±35° joints"]
    assert least.words(least.amounts[-1]) == less.words(less.amounts[0])
    assert np.degrees(applied(least, task, 35).robot.bend_limits.max()) == pytest.approx(35)
    assert least.then is None
    assert together(thinner(task, 0.004), narrower_margin(task, 0.0)) is None
