"""The twin of arms of other makes, and of bodies that only just pass."""

import numpy as np
import pytest
from twin_makers import bent_plan, robot_of

import hognose
from hognose.errors import InfeasibleError
from hognose.planning import Task, TaskSpec
from hognose.sim import simulate

#: [assumed] As the arm of 24 cables at Zhejiang, its two hinges in one place: 90 mm thick, cables on a circle of 40 mm.
THICK = {
    "pitch": 0.15,
    "half_lengths": (0.03, 0.03),
    "body_diameter": 0.09,
    "cable_radius": 0.04,
    "cable_azimuths_deg": (0.0, 120.0, 240.0),
    "cable_azimuth_step_deg": 15.0,
    "link_mass": 0.5,
}


@pytest.mark.parametrize(
    ("robot", "length"),
    [
        pytest.param(robot_of(8, THICK), 0.8, id="eight thick sections"),
        pytest.param(robot_of(30, cables={"axial_stiffness_N": 300e3}), 0.3, id="30 sections"),
    ],
)
def test_other_arms_go_where_they_are_planned_to(robot, length):
    plan = bent_plan(robot, length, 0.25 * length)
    done = simulate(plan)
    assert done.good
    assert np.sqrt(np.mean(done.tip_errors**2)) < 0.03e-3
    assert np.degrees(np.sqrt(np.mean((done.angles - done.commanded) ** 2))) < 0.005
    assert not done.slack.any()


@pytest.mark.parametrize(("wider", "touches"), [(1e-3, False), (-1e-3, True)])
def test_a_body_passes_a_hole_that_is_a_millimetre_wider(wider, touches):
    """Straight through, at every step and not only in one pose."""
    robot = robot_of(6)
    hole = {"center": (0.0, 0.0), "diameter": 2 * (float(robot.body_radii[0]) + wider)}
    board = {"kind": "board", "center": (0, 0, 0.06), "size": (0.3, 0.3), "thickness": 0.004, "hole": [hole]}
    spec = {
        "name": "hole",
        "robot": robot.name,
        "margin": 0.0,
        "gravity_m_s2": (0, 0, 0),
        "path": {"way_points": [(0, 0, 0), (0, 0, 0.06), (0, 0, 0.15)], "detour": False},
        "obstacle": [board],
    }
    try:
        plan = hognose.plan(Task(TaskSpec.model_validate(spec), robot))
    except InfeasibleError as error:
        plan = error.plan
    assert plan is not None
    done = simulate(plan)
    assert done.touched == (("board 1",) if touches else ())
    if touches:
        assert done.contact.max() > 1.0
    else:
        assert not done.stopped
        assert plan.clearance[-1].min() == pytest.approx(wider, abs=0.1e-3)
