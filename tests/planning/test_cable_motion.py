"""Cables that go linearly between set-points: angles, the bound of what they leave linear ones by, the certificate."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cable_oracles import bends, bound, fitted, slopes, through, turning
from hypothesis import given
from hypothesis import strategies as st
from planning_makers import between, clearances, random_scene

from hognose.planning.certificate import UndeterminedError, cables_motion, certify_cables
from hognose.planning.certificate import cables as certificate
from hognose.planning.certificate.bound import Certificate
from hognose.planning.certificate.cable_motion import deviations
from hognose.planning.certificate.moving import Pieces
from hognose.robot import Robot, RobotSpec
from hognose.robot.base import Slider
from hognose.scene import Scene

START = np.array([0.1, -0.2, 0.3])
HORIZON = 0.05
EMPTY = Scene.from_obstacles([])
seeds = st.integers(0, 2**32 - 1)


def random_arm(rng: np.random.Generator, sections: int, travel: float = 0.004) -> Robot:
    """An arm of different sections with three to five cables each; `travel` m a turn of 10,000 counts."""
    groups, radius = [], 0.02
    for _ in range(sections):
        pitch, radius = rng.uniform(0.06, 0.15), radius * rng.uniform(0.85, 1.0)
        cables = int(rng.integers(3, 6))
        groups.append(
            {
                "pitch": pitch,
                "half_lengths": rng.uniform(0.009, 0.02, 2).tolist(),
                "body_diameter": 0.045,
                "bend_limit_deg": 45.0,
                "link_mass": 0.1,
                "cable_radius": radius,
                "cable_azimuths_deg": (360 / cables * np.arange(cables) + rng.uniform(0, 25, cables)).tolist(),
                "transmission": {"screw_lead": travel, "gear_ratio": 5.0, "counts_per_turn": 2000},
            }
        )
    limits = {"joint_speed_deg_s": 10.0, "joint_acceleration_deg_s2": 100.0, "cable_speed": 0.05}
    said = {"name": "random", "feed": {"min": 0.0, "max": 1.0, "speed": 0.05}, "section": groups}
    return Robot.from_spec(RobotSpec.model_validate({**said, "limits": {**limits, "cable_travel": [-0.2, 0.2]}}))


def counted(robot: Robot, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The lengths (T, c) at the counts of angles (T, n, 2), and the angles that belong to these."""
    lengths = robot.lengths_of_counts(robot.motor_counts(robot.cable_lengths(angles)))
    return lengths, robot.angles_from_cables(lengths, angles)


@given(seed=seeds, sections=st.integers(1, 5))
def test_the_formulas_of_lengths_and_slopes_are_those_of_the_holes(seed, sections):
    rng = np.random.default_rng(seed)
    robot, angles = random_arm(rng, sections), rng.uniform(-0.6, 0.6, (sections, 2))
    found, jacobian = robot.cable_lengths(angles), np.zeros((robot.cables, sections, 2))
    for i in range(sections):
        own = robot.cable_sections == i
        bent = sum(through(robot, i, j, angles[j]) - through(robot, i, j, np.zeros(2)) for j in range(i + 1))
        np.testing.assert_allclose(found[own] - robot.straight_cable_lengths[own], bent, rtol=0, atol=1e-14)
        for j in range(i + 1):
            jacobian[own, j] = slopes(robot, i, j, angles[j])
    turn = rng.normal(size=angles.shape)
    seen = (robot.cable_lengths(angles + 1e-5 * turn) - robot.cable_lengths(angles - 1e-5 * turn)) / 2e-5
    np.testing.assert_allclose(np.einsum("kja,ja->k", jacobian, turn), seen, rtol=0, atol=1e-9)


@given(seed=seeds, sections=st.integers(1, 8))
def test_angles_come_back_from_their_cables(seed, sections):
    rng = np.random.default_rng(seed)
    robot, angles = random_arm(rng, sections), rng.uniform(-0.6, 0.6, (7, sections, 2))
    found = robot.angles_from_cables(robot.cable_lengths(angles), angles + rng.uniform(-0.1, 0.1, angles.shape))
    np.testing.assert_allclose(found, angles, rtol=0, atol=1e-9)


@given(seed=seeds, sections=st.integers(1, 4))
def test_lengths_that_fit_no_angles_give_those_of_least_squares(seed, sections):
    rng = np.random.default_rng(seed)
    robot, angles = random_arm(rng, sections), rng.uniform(-0.5, 0.5, (sections, 2))
    lengths = robot.cable_lengths(angles) + rng.uniform(-1e-3, 1e-3, robot.cables)
    found = robot.angles_from_cables(lengths[None], angles[None])[0]
    np.testing.assert_allclose(found, fitted(robot, lengths, angles), rtol=0, atol=2e-7)


def test_where_cables_determine_no_angles_there_are_none():
    robot = random_arm(np.random.default_rng(3), 4)
    lengths = np.array([robot.straight_cable_lengths, robot.straight_cable_lengths])
    lengths[0, robot.cable_sections == 2] += 0.2  # far longer than the joint lets them be
    found = robot.angles_from_cables(lengths, np.zeros((2, 4, 2)))
    assert np.isnan(found[0, 2:]).all()
    assert not np.isnan(found[0, :2]).any()
    np.testing.assert_allclose(found[1], 0.0, atol=1e-12)


@given(seed=seeds, sections=st.integers(1, 4), swing=st.floats(-4.0, -0.5), rough=st.floats(-6.5, -3.5))
def test_the_bound_is_what_the_derivation_says(seed, sections, swing, rough):
    rng = np.random.default_rng(seed)
    robot = random_arm(rng, sections, 10.0**rough * 1e4)
    low = rng.uniform(-0.5, 0.5, (sections, 2))
    lengths, angles = counted(robot, np.array([low, low + 10.0**swing * rng.uniform(-1, 1, low.shape)]))
    found = deviations(robot, angles[:1], angles[1:], lengths[:1], lengths[1:])[0]
    expected = bound(robot, *angles, *lengths)
    assert np.isinf(found[0]) == np.isinf(expected[0])
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-11)


@given(seed=seeds, sections=st.integers(1, 6), swing=st.floats(-4.0, -0.3), rough=st.floats(-6.5, -3.5))
def test_no_angles_are_farther_from_linear_ones_than_the_bound(seed, sections, swing, rough):
    rng = np.random.default_rng(seed)
    robot = random_arm(rng, sections, 10.0**rough * 1e4)
    low = rng.uniform(-0.5, 0.5, (sections, 2))
    lengths, angles = counted(robot, np.array([low, low + 10.0**swing * rng.uniform(-1, 1, low.shape)]))
    found = deviations(robot, angles[:1], angles[1:], lengths[:1], lengths[1:])[0]
    dense = robot.angles_from_cables(between(lengths, 64), between(angles, 64))
    off = np.linalg.norm(dense - between(angles, 64), axis=2).max(axis=0)
    assert np.isinf(found).all() or (off <= found + 1e-10).all()


def test_what_leaves_the_place_where_derivatives_are_bounded_has_no_bound():
    """Angles that stand still while the lengths say otherwise; the same are bounded beside a joint that swings."""
    robot = random_arm(np.random.default_rng(2), 1)
    low, lengths = np.full((1, 1, 2), 0.1), np.zeros((1, robot.cables))
    lengths[:] = robot.cable_lengths(low)
    off = 1e-5 * np.cos(robot.cable_azimuths)
    assert np.isinf(deviations(robot, low, low, lengths, lengths + off)).all()
    assert (deviations(robot, low, low + 0.01, lengths, robot.cable_lengths(low + 0.01) + off) > 3e-4).all()
    assert np.isfinite(deviations(robot, low, low + 0.01, lengths, robot.cable_lengths(low + 0.01) + off)).all()


def test_the_bound_is_of_the_size_of_what_it_bounds(boards):
    """Steps of the paper: within an order of magnitude, and far below what matters."""
    robot = boards.robot
    lengths, angles = counted(robot, boards.angles)
    found = deviations(robot, angles[:-1], angles[1:], lengths[:-1], lengths[1:])
    body = np.cumsum(np.cumsum(found, axis=1) * robot.link_lengths, axis=1)
    assert body.max() < 5e-6
    near, feeds = between(angles, 8), between(boards.feed, 8)
    dense = robot.angles_from_cables(between(lengths, 8), near)
    seen = np.linalg.norm(robot.joint_positions(dense, feeds) - robot.joint_positions(near, feeds), axis=2).max()
    assert 0.2 * body.max() < seen <= body.max()


@given(seed=seeds)
def test_derivatives_along_a_line_are_no_larger_than_the_constants(seed):
    """Of p = R_y(a t) R_x(b t) q: second and third; and of its length."""
    rng = np.random.default_rng(seed)
    start, way, q, a = rng.uniform(-1.5, 1.5, 2), rng.normal(size=2), rng.normal(size=3), rng.normal(size=3)
    way, q = way / np.linalg.norm(way), q / np.linalg.norm(q)
    t = 4e-3 * np.arange(-3, 4)
    p = turning(start[0] + way[0] * t, start[1] + way[1] * t) @ q
    second = np.linalg.norm(np.diff(p, 2, axis=0), axis=1).max() / 4e-3**2
    third = np.linalg.norm(np.diff(p, 3, axis=0), axis=1).max() / 4e-3**3
    assert second <= 1.5 + 1e-6
    assert third <= 2.885 + 1e-4
    length = np.linalg.norm(p - a, axis=1)
    if (shortest := length.min()) > 0.1:
        most = 2.885 + 4.5 / shortest + 2 / math.sqrt(3) / shortest**2
        assert abs(np.diff(length, 3)).max() / 4e-3**3 <= most + 1e-4


@given(seed=seeds)
def test_second_derivatives_bound_how_slopes_change(seed):
    rng = np.random.default_rng(seed)
    robot, at = random_arm(rng, 2), rng.uniform(-0.5, 0.5, 2)
    step = 1e-4 * rng.normal(size=2)
    seen = slopes(robot, 1, 0, at + step) - slopes(robot, 1, 0, at - step)
    np.testing.assert_allclose(seen, 2 * bends(robot, 1, 0, at) @ step, rtol=0, atol=1e-9)


def random_motion(rng: np.random.Generator, sections: int, steps: int, step: float):
    """An arm, feeds (T,) m, counted cable lengths (T, c) m, and their angles."""
    robot, shape = random_arm(rng, sections), (1, sections, 2)
    feeds = step * np.arange(steps)
    waves = np.sin(rng.uniform(0, 6, shape) + rng.uniform(2, 12) * feeds[:, None, None])
    lengths, angles = counted(robot, 0.5 * rng.uniform(0, 1, shape) * waves)
    return robot, feeds, lengths, angles


def certified(robot: Robot, scene: Scene, feeds, lengths, angles, margin: float = math.inf) -> Certificate | None:
    body = robot.joint_positions(angles, feeds) + START
    found = clearances(scene, robot, body, HORIZON)
    base, at = Slider(START, 1.0, 0.0, 0.0), feeds[:, None]
    try:
        moving = cables_motion(robot, base, at, angles, lengths)
    except UndeterminedError:
        return None
    return certify_cables(moving, robot, scene, body, found, HORIZON, margin)


def seen(robot: Robot, scene: Scene, feeds, angles) -> float:
    return min(HORIZON, float(clearances(scene, robot, robot.joint_positions(angles, feeds) + START).min()))


@pytest.mark.slow
def test_nothing_is_certified_above_a_dense_simulation_by_another_solver():
    """60 arms with steps of 3.5 to 90 mm; the angles of every sample are SciPy's."""
    proven = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        robot, feeds, lengths, angles = random_motion(rng, int(rng.integers(1, 5)), 2, rng.uniform(0.0035, 0.09))
        scene = random_scene(rng, START - 0.3, START + 0.5, 4)
        proof = certified(robot, scene, feeds, lengths, angles)
        if proof is None:
            continue
        near = between(angles, 12)
        dense = np.array([fitted(robot, *pair) for pair in zip(between(lengths, 12), near, strict=True)])
        proven += proof.clearance > 0
        assert proof.clearance <= max(seen(robot, scene, between(feeds, 12), dense), 0.0) + 1e-9
    assert proven > 30


@given(seed=seeds, sections=st.integers(1, 6), steps=st.integers(2, 5), step=st.floats(0.0035, 0.09))
def test_no_motion_of_cables_comes_closer_than_certified(seed, sections, steps, step):
    rng = np.random.default_rng(seed)
    robot, feeds, lengths, angles = random_motion(rng, sections, steps, step)
    scene = random_scene(rng, START - 0.3, START + 0.5, 4)
    proof = certified(robot, scene, feeds, lengths, angles)
    dense = robot.angles_from_cables(between(lengths, 100), between(angles, 100))
    smallest = seen(robot, scene, between(feeds, 100), dense)
    assert smallest <= 0 or proof is not None
    if proof is not None:
        assert proof.clearance <= max(smallest, 0.0) + 1e-12
        assert proof.clearance > smallest - 2.5e-4 - 0.5 * step / 100


def test_in_coarse_steps_linear_cables_leave_linear_angles_by_millimetres():
    """Else the tests above would tell nothing."""
    rng, found = np.random.default_rng(1), 0.0
    for _ in range(40):
        robot, feeds, lengths, angles = random_motion(rng, 6, 2, 0.09)
        near, at = between(angles, 50), between(feeds, 50)
        dense = robot.joint_positions(robot.angles_from_cables(between(lengths, 50), near), at)
        off = np.linalg.norm(dense - robot.joint_positions(near, at), axis=2)
        found = max(found, off.max())
    assert found > 1e-3


@pytest.mark.parametrize("swing", [1e-3, 0.05])
def test_what_angles_are_off_by_is_carried_to_the_tip(swing):
    """Into a whole step, and into its halves: twice that of the step where it is small, else a bound of their own."""
    rng = np.random.default_rng(4)
    robot, low = random_arm(rng, 4), rng.uniform(-0.4, 0.4, (4, 2))
    lengths, angles = counted(robot, np.array([low, low + swing * rng.uniform(-1, 1, low.shape)]))
    parameters = np.concatenate([np.zeros((2, 1)), angles.reshape(2, -1), lengths], axis=1)
    turned = deviations(robot, angles[:1], angles[1:], lengths[:1], lengths[1:])[0]
    off = certificate._carried(robot, turned[None])
    expected = [sum(robot.link_lengths[k] * turned[: k + 1].sum() for k in range(i)) for i in range(5)]
    np.testing.assert_allclose(off, [expected], rtol=1e-9)

    motion = certificate._Motion(robot, Slider(np.zeros(3), 1.0, 0.0, 0.0), 1, off)
    step = Pieces.between(parameters, robot.joint_positions(angles), np.zeros((2, 4)))
    middle, body = motion.place(0.5 * (step.low + step.high))
    found = middle[:, 1:9].reshape(1, 4, 2)
    np.testing.assert_allclose(found[0], fitted(robot, lengths.mean(axis=0), angles.mean(axis=0)), rtol=0, atol=1e-8)
    np.testing.assert_allclose(body, robot.joint_positions(found), rtol=0, atol=1e-12)

    def added(pieces: Pieces) -> np.ndarray:
        low, high = (side[:, 1:9].reshape(-1, 4, 2) for side in (pieces.low, pieces.high))
        return motion.travel(pieces)[1] - robot.model.bulges(
            low, high, robot.link_lengths, np.zeros((len(low), 3)), np.zeros(len(low))
        )

    np.testing.assert_allclose(added(step), off, rtol=1e-6, atol=1e-12)
    halves = added(step.halved(middle, body, np.zeros((1, 4))))
    assert (off[0, -1] <= 5e-6) == (swing == 1e-3)
    if swing == 1e-3:
        np.testing.assert_allclose(halves, 2 * np.repeat(off, 2, axis=0), rtol=1e-6, atol=1e-12)
    else:
        assert (halves[:, -1] < 0.5 * off[0, -1]).all()


def test_of_cables_that_determine_nothing_nothing_is_proven():
    robot = random_arm(np.random.default_rng(3), 2)
    lengths, angles = counted(robot, np.zeros((2, 2, 2)))
    lengths[1, robot.cable_sections == 1] += 0.2
    assert certified(robot, EMPTY, np.zeros(2), lengths, angles) is None
