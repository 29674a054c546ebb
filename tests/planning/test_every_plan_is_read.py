"""Every plan that can be made can be written and read; what cannot be is refused while planning, and soon."""

from __future__ import annotations

import dataclasses
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planning_makers import assert_same_cells, outcome, variant
from pydantic import ValidationError

import hognose
from hognose.planning import Plan, Task
from hognose.planning.motion_spec import LONGEST_MOTION, SHORTEST_PERIOD
from hognose.planning.planner import MOST_POSITIONS
from hognose.route.why.partial import _towards

#: Values that people and programs come up with, most of them wrong.
EXTREMES: dict[str, list[Any]] = {
    "motion.period_s": [5e-324, 1e-300, 1e-9, SHORTEST_PERIOD, 0.15, 1e4, LONGEST_MOTION, 1e9, 1e300],
    "motion.step": [5e-324, 1e-300, 1e-9, 0.003, 0.3, 1.0, 1.092, 100.0, 9999.0, 1e300],
    "motion.spacing": [1e-300, 1e-9, 1e-4, 0.005],
    "motion.tip_tolerance": [5e-324, 1e-300, 1.0, 9999.0],
    "margin": [0.0, 5e-324, 1e-12, 0.04, 1.0, 9999.0],
    "name": ["x" * 80, "“Ä”\u2028", "\U0001f40d", "a\tb"],
    "description": ["\n" * 100, "ü" * 10_000],
    "report.times_s": [[1e308, -1e308], [5e-324]],
    "path.order": [1, 2, 5, 9],
    "path.kind": ["bezier", "bspline"],
    "path.detour": [True, False],
    "obstacle": [[]],
}
#: The same of the robot.
ROBOTS: dict[str, list[Any]] = {
    "limits.joint_speed_deg_s": [5e-324, 1e-300, 1e300],
    "limits.joint_acceleration_deg_s2": [1e-300, 1e300],
    "limits.cable_speed": [5e-324, 9999.0],
    "limits.cable_travel": [[-5e-324, 5e-324], [-9999.0, 9999.0]],
    "limits.motor_counts": [[-1, 1], [-(2**63), 2**63 - 1]],
    "feed.speed": [5e-324, 9999.0],
    "feed.min": [-9999.0],
    "feed.max": [5e-324, 9999.0],
    "base_length": [9999.0],
    "section.0.link_mass": [5e-324, 1e300],
    "section.0.bend_limit_deg": [5e-324, 89.9999],
    "section.0.transmission.counts_per_turn": [1, 10**7],
    "name": ["\u2028" * 80],
    "source": ["\x00" * 3],
}


def comes_back(plan: Plan, folder: Any) -> None:
    """Bit for bit, and with the same verdict."""
    plan.save(folder / "plan.parquet")
    read = hognose.Plan.load(folder / "plan.parquet")
    assert read.task.spec == plan.task.spec
    assert read.robot.spec == plan.robot.spec
    assert_same_cells(read, plan)
    assert read.good == plan.good
    assert read.summary() == plan.verified().summary()


def made_of(spec: dict[str, Any], robot: dict[str, Any], task: Task) -> Plan | None:
    """The plan of a task, good or not; None if the task is refused."""
    try:
        changed = variant(task, spec, robot)
    except (ValidationError, hognose.InputError):
        return None
    made = outcome(lambda: hognose.plan(changed))
    return made.plan if isinstance(made, hognose.InfeasibleError) else made if isinstance(made, Plan) else None


#: A coarse motion, so that the whole table is quick.
COARSE = {"motion.step": 0.15, "motion.period_s": 15.0}


@pytest.mark.parametrize("key", list(EXTREMES))
def test_every_extreme_of_a_task(tasks, tmp_path, key):
    for value in EXTREMES[key]:
        plan = made_of(COARSE | {key: value}, {}, tasks["pipe-tank"])
        if plan is not None:
            comes_back(plan, tmp_path)


@pytest.mark.parametrize("key", list(ROBOTS))
def test_every_extreme_of_a_robot(tasks, tmp_path, key):
    for value in ROBOTS[key]:
        plan = made_of(COARSE, {key: value}, tasks["pipe-tank"])
        if plan is not None:
            comes_back(plan, tmp_path)


@given(data=st.data())
@settings(max_examples=15, deadline=None)
def test_extremes_together(tasks, tmp_path_factory, data):
    keys = data.draw(st.lists(st.sampled_from(list(EXTREMES)), max_size=4, unique=True))
    robots = data.draw(st.lists(st.sampled_from(list(ROBOTS)), max_size=3, unique=True))
    spec = {key: data.draw(st.sampled_from(EXTREMES[key])) for key in keys}
    plan = made_of(COARSE | spec, {key: data.draw(st.sampled_from(ROBOTS[key])) for key in robots}, tasks["pipe-tank"])
    if plan is not None:
        comes_back(plan, tmp_path_factory.mktemp("extremes"))


@pytest.mark.parametrize("period", [0.0, 5e-324, 1e-300, 0.99e-6, 1.01e6, 1e300, float("inf"), float("nan")])
def test_a_period_that_no_plan_could_keep_is_refused_in_the_task(tasks, period):
    with pytest.raises(ValidationError, match="period_s"):
        variant(tasks["pipe-tank"], {"motion.period_s": period})


def test_a_motion_of_months_is_refused_with_its_length(tasks):
    with pytest.raises(hognose.InputError, match=r"motion\.period_s: 5000 s for each of 303 steps is a motion of 1\.5"):
        hognose.plan(variant(tasks["pipe-tank"], {"motion.period_s": 5000.0}))


def test_a_plan_that_could_not_be_read_is_not_written(boards, tmp_path):
    late = dataclasses.replace(boards, time=boards.time * 1e6)
    with pytest.raises(hognose.InputError, match=r"column 'time_s' holds 4\.68e\+07 s, more than any plan can"):
        late.save(tmp_path / "late.parquet")
    spec = boards.task.spec.model_copy(update={"name": "x" * 81})
    with pytest.raises(hognose.InputError, match=r"could not be read: task\.name"):
        dataclasses.replace(boards, task=Task(spec, boards.robot)).save(tmp_path / "long.parquet")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("length", [1, 52, 79, 80])
def test_the_name_of_a_way_that_ends_early_is_a_name(tasks, length):
    task = variant(tasks["pipe-tank"], {"name": "n" * length, "path": {"target": [0.0, 0.0, 0.5]}})
    named = _towards(_towards(task, np.zeros(3)), np.ones(3)).name
    assert len(named) <= 80
    assert named.startswith("n")
    assert named.endswith(", only as far as a way was found")
    assert named.count("only as far") == 1


@pytest.mark.parametrize("step", [1.0921, 5.0, 100.0, 9999.0])
@pytest.mark.parametrize("name", ["obstacle-array", "detour"])
def test_a_step_longer_than_the_arm_is_refused_before_anything_is_led_round_by_it(tasks, name, step):
    stages: list[str] = []
    with pytest.raises(hognose.InputError, match=re.escape(f"motion.step: {1e3 * step:g} mm is longer than the arm")):
        hognose.plan(variant(tasks[name], {"motion.step": step}), stages.append)
    assert stages == ["drawing the path"]


@pytest.mark.parametrize("step", [0.3, 0.6, 1.0])
def test_a_detour_that_grows_with_every_round_ends(tasks, step):
    """Each evades by a step more than it must; with long steps the way only gets longer."""
    made = outcome(lambda: hognose.plan(variant(tasks["detour"], {"motion.step": step, "motion.period_s": 30.0})))
    assert isinstance(made, hognose.InfeasibleError)
    assert re.search(r"detour|too far|no good motion", str(made))


def test_a_detour_says_how_long_the_way_became(tasks, monkeypatch):
    monkeypatch.setattr("hognose.planning.planner.MOST_ROUNDABOUT", 0.9)
    with pytest.raises(
        hognose.InfeasibleError, match=r"the detour round '.+' at \(.+\) mm makes the way [\d,]+ mm long"
    ):
        hognose.plan(tasks["detour"])


def test_no_step_makes_more_set_points_than_can_be_planned(tasks):
    finest = 1.0 / (MOST_POSITIONS // 13)
    with pytest.raises(hognose.InputError, match=r"motion\.step: .* at most 230,769 steps"):
        hognose.plan(variant(tasks["obstacle-array"], {"motion.step": finest}))


def test_a_plan_of_one_check_only_has_no_certified_clearance(boards):
    lost = dataclasses.replace(boards, feed=boards.feed + 10.0).verified()
    assert [check.key for check in lost.checks] == ["feed_on_path"]
    assert lost.certified_clearance is None
