"""What is certified of obstacles that move is what tolerances leave: against dense poses with their own budgets."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planning_makers import altered, between, random_robot
from scipy.spatial.transform import Rotation
from test_passing import BASE, HORIZON, PIECES, random_obstacle, wandering_path

import hognose
from hognose.following import follow
from hognose.planning import run_checks
from hognose.planning.certificate import certify_passing, gliding_motion, interpolated_motion
from hognose.planning.certificate.bound import TIGHTNESS
from hognose.planning.checks.shared import Shared
from hognose.planning.drawn_arms import draw
from hognose.planning.link_budgets import timings, tolerances
from hognose.planning.penetration import section_clearance
from hognose.planning.tolerance.allowance import Allowance
from hognose.planning.tolerance.budget import Budget
from hognose.planning.tolerance.spec import ToleranceSpec
from hognose.robot.base import angles_on
from hognose.scene import Box
from hognose.scene.moving import parted

seeds = st.integers(0, 2**32 - 1)


def random_budget(rng: np.random.Generator, robot: hognose.Robot) -> Budget:
    """Tolerances of any kind, some of them none."""
    most = {
        "cad": 0.003,
        "sag": 0.005,
        "registration": 0.002,
        "registration_deg": 0.3,
        "calibration_deg": 0.5,
        "cable_zero": 0.0003,
    }
    said = {name: float(rng.uniform(0.1, 1.0) * size) for name, size in most.items() if rng.integers(3)}
    found = Budget.of(ToleranceSpec.model_validate({"cad": 1e-4, **said}), robot, BASE.start)
    assert found is not None
    return found


@given(
    seed=seeds,
    sections=st.integers(1, 5),
    steps=st.integers(2, 5),
    timing=st.sampled_from([0.0, 0.02, 0.3]),
    glides=st.booleans(),
)
@settings(max_examples=80, deadline=None)
def test_no_pose_leaves_less_than_certified(seed, sections, steps, timing, glides):
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, sections)
    times = np.cumsum(rng.uniform(0.05, 0.5, steps))
    feeds = np.cumsum(rng.uniform(0.0, 0.04, steps))
    at, dense_at = feeds[:, None], between(feeds, PIECES)[:, None]
    if glides:
        path = wandering_path(rng, robot)
        moving = gliding_motion(path, robot, feeds)
        if moving is None:
            return
        vertices, dense = (follow(path, robot.link_lengths, each) for each in (feeds, dense_at[:, 0]))
        angles, turned = angles_on(BASE, robot, vertices, at), angles_on(BASE, robot, dense, dense_at)
    else:
        angles = np.cumsum(rng.uniform(-0.2, 0.2, (steps, sections, 2)), axis=0)
        turned = between(angles, PIECES)
        moving = interpolated_motion(robot, BASE, at, angles)
        vertices, dense = robot.joint_positions(angles, feeds), robot.joint_positions(turned, dense_at[:, 0])
    obstacle = random_obstacle(rng, vertices[0, rng.integers(sections + 1)], times[-1], timing)
    budget = random_budget(rng, robot)
    allowance = Allowance.of(budget, BASE, angles, at, vertices)
    proof = certify_passing(moving, robot, obstacle, times, vertices, HORIZON, 0.0, allowance)
    taken, moments = Allowance.of(budget, BASE, turned, dense_at, dense).at_steps(dense), between(times, PIECES)
    for shift in np.unique([0.0, -timing, timing, timing / 3]):
        seen = np.ascontiguousarray(obstacle.motion.into_frame(dense, moments - shift))
        left = section_clearance(obstacle.scene, robot, seen, HORIZON + 0.2) - taken
        assert proof.clearance <= max(left.min(), 0.0) + 1e-9


def test_a_wall_that_comes_closer_is_as_close_as_the_budget_of_the_closest_link_says():
    """The arm is at rest: what is taken off is what the budget says at that pose, once."""
    robot = random_robot(np.random.default_rng(1), 2)
    radius, times = float(robot.body_radii.max()), np.array([0.0, 1.0, 1.7])
    poses = [{"time_s": 0.0}, {"time_s": 10.0, "position": (0.0, -1.0, 0.0)}]
    far = radius + 0.05 + 0.17
    wall = Box.model_validate({"center": (0, far + 0.05, 0), "size": (9, 0.1, 9), "motion": poses})
    angles, still = np.zeros((3, 2, 2)), np.zeros((3, 1))
    moving, vertices = interpolated_motion(robot, BASE, still, angles), robot.joint_positions(angles, np.zeros(3))
    budget = random_budget(np.random.default_rng(2), robot)
    allowance = Allowance.of(budget, BASE, angles, still, vertices)
    proof = certify_passing(moving, robot, parted([wall])[1][0], times, vertices, HORIZON, 0.0, allowance)
    expected = (0.05 + radius - robot.body_radii - allowance.at_steps(vertices)[0]).min()
    assert proof.clearance == pytest.approx(expected, abs=TIGHTNESS)
    assert proof.clearance <= expected + 1e-12


def test_all_certificates_of_a_plan_past_moving_obstacles_are_of_what_tolerances_leave():
    task = hognose.load_task("moving-obstacles")
    motion = {"motion.step": 0.02, "motion.period_s": 0.857}
    plain = hognose.plan(hognose.Task(altered(task.spec, motion), task.robot))
    spec = altered(plain.task.spec, {"tolerance": {"cad": 0.002}})
    tolerant = dataclasses.replace(plain, task=hognose.Task(spec, task.robot))
    before, after = Shared(plain), Shared(tolerant)
    for name in ("passing_along_path", "passing_interpolated", "passing_cables"):
        for one, other in zip(getattr(before, name), getattr(after, name), strict=True):
            far = one.clearance >= plain.horizon - 0.003
            assert far or other.clearance == pytest.approx(one.clearance - 0.002, abs=2 * TIGHTNESS)
    keys = {check.key: check.value for check in run_checks(tolerant)}
    assert keys["certified_cables"] < plain.check("certified_cables").value


@pytest.fixture(scope="module")
def wheeled():
    """A plan of few steps past a hatch and a wheel, with tolerances; the wheel's timing is that of the task."""
    task = hognose.load_task("moving-obstacles")
    wheel = task.spec.obstacle[-1].model_copy(update={"timing_s": None})
    said = {"registration": 0.001, "registration_deg": 0.1, "timing_s": 0.03, "assumed": ["timing_s"]}
    changes = {"motion.step": 0.02, "motion.period_s": 0.857, "margin": 0.001, "tolerance": said}
    spec = altered(task.spec.model_copy(update={"obstacle": (*task.spec.obstacle[:-1], wheel)}), changes)
    return hognose.plan(hognose.Task(spec, task.robot))


def test_arms_are_drawn_past_moving_obstacles_as_well(wheeled):
    task, count, rng = wheeled.task, 400, np.random.default_rng(2)
    found = draw(wheeled, task.budget, Shared(wheeled, wheeled.clearance).taken, 20_000, seed=1)
    exact = np.empty(count)
    for k in range(count):
        turned = Rotation.from_rotvec(rng.normal(0, np.radians(0.1), 3)).as_matrix()
        joints = (wheeled.body - task.base.start) @ turned.T + task.base.start + rng.normal(0, 0.001, 3)
        left = [section_clearance(task.scene, task.robot, joints, 1.0).min()]
        for each in task.moving:
            seen = np.ascontiguousarray(each.motion.into_frame(joints, wheeled.clock))
            left.append(section_clearance(each.scene, task.robot, seen, 1.0).min())
        exact[k] = min(left)
    for share in (0.05, 0.25, 0.5, 0.75):
        assert abs(found.quantile(share) - np.quantile(exact, share)) < 4e-4


def test_the_budget_says_what_timing_takes_and_from_where_it_is(wheeled):
    assert [(each.name, each.timing) for each in wheeled.task.moving] == [("hatch", 0.5), ("wheel", 0.03)]
    hatch, wheel = timings(wheeled)
    assert (hatch.assumed, wheel.assumed) == (False, True)
    late = wheel.timing * wheeled.task.moving[1].motion.fastest[1] * wheeled.task.moving[1].reach
    assert 0.0 < wheel.taken <= late + 2 * TIGHTNESS
    assert wheel.left + wheel.taken == pytest.approx(wheel.without)
    assert wheel.words.startswith("wheel: timing 0.03 s (assumed) takes ")
    assert wheel.words.endswith("mm are left.")
    interpolated = min(each.clearance for each in Shared(wheeled).passing_interpolated)
    assert min(hatch.left, wheel.left) == interpolated
    assert "on time" in tolerances(wheeled, 100).chances
