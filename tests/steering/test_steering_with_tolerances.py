"""Steering keeps what tolerances take, besides the margin."""

from __future__ import annotations

import numpy as np
import pytest

import hognose
from hognose.errors import InputError
from hognose.planning.tolerance.allowance import Allowance
from hognose.steering import SteeredPath


@pytest.mark.parametrize("seed", range(3))
def test_wherever_the_arm_is_steered_its_budget_and_the_margin_are_left(seed):
    task, rng = hognose.load_task("tolerances"), np.random.default_rng(seed)
    steered, held = SteeredPath.of(task), None
    assert task.budget is not None
    while held is None and steered.depth < 0.6:
        held = steered.advance(0.015, rng.normal(0.0, 0.4, 2)).held_by
        at = task.base.coordinates(np.array([steered.feed]), steered.joints[None])
        allowance = Allowance.of(task.budget, task.base, steered.angles[None], at, steered.joints[None])
        taken = allowance.at_steps(steered.joints[None])[0]
        assert (steered.clearance >= np.minimum(task.margin + taken, steered.horizon)).all()
    assert held is not None
    assert held.reason == "clearance"
    assert held.section is not None
    taken = float(task.taken_at_most[held.section - 1])
    assert f"tolerances take up to {1e3 * taken:.2f} mm" in held.sentence
    assert held.limit == pytest.approx(1e3 * (task.margin + taken))


def test_what_is_steered_is_a_task_with_the_same_tolerances_and_its_plan_is_good():
    task = hognose.load_task("tolerances")
    steered = SteeredPath.of(task)
    for _ in range(15):
        steered.advance(0.015, (0.05, 0.1))
    made = steered.task("steered")
    assert made.plan.good
    assert made.plan.task.spec.tolerance == task.spec.tolerance


def test_tolerances_are_one_figure_for_each_link():
    task = hognose.load_task("tolerances")
    with pytest.raises(InputError, match=r"tolerances: .*\(12,\)"):
        SteeredPath(task.robot, task.scene, tolerances=[0.001])
