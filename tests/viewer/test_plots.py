"""What the page's charts draw is what the plan holds."""

import dataclasses

import numpy as np
import pytest

import hognose
from hognose.planning import Task
from hognose.planning.base_limits import BaseLimits
from hognose.planning.base_spec import BaseSpec
from hognose.viewer.plots import KINDS, series_of


@pytest.fixture(scope="module")
def plan():
    return hognose.plan(hognose.load_task("pipe-tank"))


@pytest.mark.parametrize("kind", KINDS)
def test_every_line_has_a_name_and_a_value_a_row(plan, kind):
    names, values, _ = series_of(plan, kind)
    assert values.shape == (len(plan.time), len(names))
    assert np.isfinite(values).all()
    assert len(set(names)) == len(names)


def test_the_lines_are_those_of_the_plan_in_the_units_that_are_named(plan):
    clearance, bends, cables, speeds, feed, feed_speed = (series_of(plan, kind) for kind in KINDS)
    assert clearance[1].min() == 1e3 * plan.clearance.min()
    assert clearance[2] == [5.0]
    assert np.abs(bends[1]).max() == pytest.approx(np.degrees(plan.check("bend_limits").value))
    assert bends[2][0] == pytest.approx(28.6479, abs=1e-4)
    assert (cables[1][0] < 0).all()  # motors have pulled in until the pretension is reached
    assert np.abs(cables[1]).max() == pytest.approx(1e3 * plan.check("cable_travel").value)
    assert np.abs(speeds[1]).max() <= 1e3 * plan.check("cable_speed").value * (1 + 1e-9)
    assert feed[1][-1, 0] == pytest.approx(1058.6, abs=0.1)
    assert feed_speed[1].max() == pytest.approx(1e3 * plan.check("feed_speed").value)
    assert feed_speed[2] == [50.0]


@pytest.mark.parametrize(
    ("base", "profile", "limits"),
    [
        ({}, "constant", [50.0]),
        ({"kind": "arm"}, "constant", []),
        ({"kind": "arm"}, "fastest", [50.0]),
        ({"kind": "arm", "speed": 0.02}, "constant", [20.0]),
    ],
)
def test_the_limit_of_the_feed_is_what_its_base_is_judged_by(plan, base, profile, limits):
    motion = plan.task.spec.motion.model_copy(update={"profile": profile})
    spec = plan.task.spec.model_copy(update={"base": BaseSpec(**base), "motion": motion})
    other = dataclasses.replace(plan, task=Task(spec, plan.robot), checks=())
    assert series_of(other, KINDS[-1])[2] == limits
    assert not limits or BaseLimits.of(other.task).speed == pytest.approx(1e-3 * limits[0])


def test_with_tolerances_the_chart_shows_what_they_leave():
    plan = hognose.plan(hognose.load_task("tolerances"))
    _, values, limits = series_of(plan, KINDS[0])
    assert values.min() == pytest.approx(1e3 * plan.check("clearance_at_steps").value)
    assert values.min() < 1e3 * plan.clearance.min() - 1.0
    assert limits == [1e3 * plan.task.margin]
    assert " mm as planned\n" in plan.summary()
