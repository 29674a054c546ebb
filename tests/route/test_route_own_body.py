"""A search takes no route along which the body touches itself, and says which links do."""

import math

import numpy as np
import pytest
from planning_makers import outcome

import hognose
from hognose.planning import Task, TaskSpec
from hognose.planning.planner import plan_along
from hognose.robot import Robot, RobotSpec
from hognose.robot.own_body import MOUNT
from hognose.route import Search
from hognose.route.fit.objective import Objective, judge
from hognose.route.why.diagnosis import faults

#: Radius of the round that the way makes, m.
RADIUS = 0.15


def round_way(turned: float) -> np.ndarray:
    """Way-points (14, 3) of so much of a round, deg, that leaves the entrance forwards."""
    around = np.radians(np.linspace(0.0, turned, 14))
    sideways, ahead = RADIUS * (1 - np.cos(around)) / math.sqrt(2), RADIUS * np.sin(around)
    return np.column_stack([sideways, sideways, ahead])


@pytest.fixture(scope="module")
def task() -> Task:
    """The bundled arm with joints that bend 40 degrees, slowly, in an empty space."""
    return task_of(12)


def task_of(links: int, base_length: float = 0.143) -> Task:
    """Of so many links and such a mount, m."""
    data = hognose.load_robot("sjtu-25dof").spec.model_dump(mode="json", by_alias=True)
    data["base_length"] = base_length
    data["section"] = [section | {"bend_limit_deg": 40.0, "count": links} for section in data["section"]]
    data["feed"]["max"] = 0.091 * links
    spec = {
        "name": "round",
        "robot": "sjtu-25dof",
        "margin": 0.005,
        "path": {"way_points": [tuple(place) for place in round_way(318.0).tolist()], "detour": False},
        "motion": {"step": 0.0035, "period_s": 1.0},
    }
    return Task(TaskSpec.model_validate(spec), Robot.from_spec(RobotSpec.model_validate(data)))


def judged(task: Task, turned: float):
    way_points = round_way(turned)
    free = np.ones(len(way_points) - 1, bool)
    found = judge(
        Objective(task.robot, task.base, task.scene, task.path_through, 3, 0.0035, 0.005, way_points, free), way_points
    )
    assert found is not None
    return found


def test_a_spline_on_which_the_body_touches_itself_is_not_feasible(task):
    clear, touching = judged(task, 290.0), judged(task, 318.0)
    assert max(touching.overruns.values()) < 0.98
    assert clear.feasible
    assert clear.touching is None
    assert not touching.feasible
    assert touching.touching is not None
    assert touching.touching[1:] == (1, 11)
    assert touching.score < clear.score
    assert "the arm would touch itself: section 2 and section 12, at (14, 14, -100) mm" in list(faults(task, touching))


def test_what_the_coarse_look_refuses_the_plan_refuses_too(task):
    for turned in (290.0, 300.0, 318.0):
        try:
            failed = set()
            plan_along(task, way_points=round_way(turned))
        except hognose.InfeasibleError as error:
            failed = {check.key for check in error.plan.checks if check.failed}
        assert ("own_body" in failed) == (judged(task, turned).touching is not None)


def test_a_search_keeps_no_plan_whose_body_touches_itself(task):
    search = Search(task, None, 0)
    search._verify(judged(task, 318.0), 1)
    assert search.best is None
    (refused,) = search.refused
    assert refused.check("own_body").failed
    assert search.unmendable is None


def test_a_spline_that_comes_back_upon_the_mount_is_not_feasible_and_the_plan_agrees():
    """An arm so short that its first joint is past the place where the round ends."""
    task = task_of(10, base_length=0.7)
    found = judged(task, 318.0)
    assert found.touching is not None
    assert found.touching[1:] == (MOUNT, 9)
    assert not found.feasible
    said = "the arm would touch itself: the mount and section 10, at ("
    assert any(words.startswith(said) for words in faults(task, found))
    error = outcome(lambda: plan_along(task, way_points=round_way(318.0)))
    assert isinstance(error, hognose.InfeasibleError)
    assert "(the mount and link 10 at (" in error.plan.check("own_body").sentence
