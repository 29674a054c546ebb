"""What is certified of obstacles that move holds at every time, and whenever they are early or late."""

from __future__ import annotations

import numpy as np
import pytest
from certificate_oracles import halved_at_most
from hypothesis import event, given, settings
from hypothesis import strategies as st
from planning_makers import between, random_robot
from scipy.spatial.transform import Rotation

from hognose.following import follow
from hognose.path import Path
from hognose.planning.certificate import certify_passing, gliding_motion, interpolated_motion
from hognose.planning.certificate.bound import TIGHTNESS
from hognose.planning.penetration import section_clearance
from hognose.robot import Robot
from hognose.robot.base import Slider
from hognose.scene import Box, Cylinder, MovingObstacle, Sphere
from hognose.scene.moving import parted

PIECES = 400
BASE = Slider(np.zeros(3), 1.0, 0.0, 0.0)
HORIZON = 0.3
seeds = st.integers(0, 2**32 - 1)


def wandering_path(rng: np.random.Generator, robot: Robot) -> Path:
    """A straight run a little longer than the arm, and a gently winding way beyond."""
    run = np.array([[0, 0, 0], [0, 0, robot.length * 1.1]])
    beyond = run[-1] + np.cumsum(rng.normal(0, 0.04, (3, 3)), axis=0) + np.outer([1, 2, 3], [0, 0, 0.3])
    return Path.through(np.concatenate([run, beyond]), 3)


def random_obstacle(rng: np.random.Generator, reach: np.ndarray, until: float, timing: float) -> MovingObstacle:
    """A box, a rod or a ball near a point (3,) m that moves through random poses."""
    place, poses = tuple(reach + rng.normal(0, 0.15, 3)), int(rng.integers(2, 5))
    axis, repeats = rng.integers(2) == 0, rng.integers(3) == 0
    times = np.sort(rng.uniform(-0.3 * until, 1.3 * until, poses)) + 1e-3 * np.arange(poses)
    motion = []
    for time in times:
        turn = {"angle_deg": rng.uniform(-500, 500)} if axis else {"rotation_deg": tuple(rng.uniform(-50, 50, 3))}
        motion.append({"time_s": time, "position": tuple(rng.normal(0, 0.1, 3)), **turn})
    if repeats:
        motion[-1] = {**motion[0], "time_s": times[-1]}
    keys = {
        "motion": motion,
        "motion_pivot": tuple(reach + rng.normal(0, 0.2, 3)),
        "motion_axis": tuple(rng.normal(size=3)) if axis else None,
        "motion_repeats": bool(repeats),
        "timing_s": timing,
    }
    kind = rng.integers(3)
    if kind == 0:
        item = Box(center=place, size=tuple(rng.uniform(0.01, 0.1, 3)), **keys)
    elif kind == 1:
        item = Cylinder(start=place, end=tuple(np.add(place, rng.normal(0, 0.1, 3))), diameter=0.02, **keys)
    else:
        item = Sphere(center=place, diameter=rng.uniform(0.01, 0.1), **keys)
    return parted([item])[1][0]


def sampled(robot, obstacle: MovingObstacle, times: np.ndarray, dense: np.ndarray, shift: float) -> float:
    """The smallest clearance at bodies (m, n+1, 3) if the obstacle is late by `shift` s, by moving its mesh."""
    seen = obstacle.motion.into_frame(dense, times - shift)
    return float(section_clearance(obstacle.scene, robot, np.ascontiguousarray(seen), HORIZON).min())


@given(
    seed=seeds,
    sections=st.integers(1, 5),
    steps=st.integers(2, 5),
    timing=st.sampled_from([0.0, 0.02, 0.3]),
    glides=st.booleans(),
    halvings=st.sampled_from([0, 16]),
)
@settings(max_examples=120, deadline=None)
def test_no_moving_obstacle_comes_closer_than_certified(seed, sections, steps, timing, glides, halvings):
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, sections)
    times = np.cumsum(rng.uniform(0.05, 0.5, steps))
    feeds = np.cumsum(rng.uniform(0.0, 0.04, steps))
    if glides:
        path = wandering_path(rng, robot)
        moving = gliding_motion(path, robot, feeds)
        if moving is None:
            return
        vertices = follow(path, robot.link_lengths, feeds)
        dense = follow(path, robot.link_lengths, between(feeds, PIECES))
    else:
        angles = np.cumsum(rng.uniform(-0.2, 0.2, (steps, sections, 2)), axis=0)
        moving = interpolated_motion(robot, BASE, feeds[:, None], angles)
        vertices = robot.joint_positions(angles, feeds)
        dense = robot.joint_positions(between(angles, PIECES), between(feeds, PIECES))
    obstacle = random_obstacle(rng, vertices[0, rng.integers(sections + 1)], times[-1], timing)
    with halved_at_most(halvings):
        proof = certify_passing(moving, robot, obstacle, times, vertices, HORIZON, 0.0)
    at = between(times, PIECES)
    shifts = np.unique([0.0, -timing, timing, timing / 3])
    smallest = min(sampled(robot, obstacle, at, dense, shift) for shift in shifts)
    event("touches" if smallest <= 0 else "far" if smallest >= HORIZON else "near")
    assert proof.clearance <= max(smallest, 0.0) + 1e-9
    if halvings and not timing:  # tight, as far as sampling tells
        moved = np.linalg.norm(np.diff(obstacle.motion.into_frame(dense, at), axis=0), axis=2).max()
        assert proof.clearance >= smallest - TIGHTNESS - moved / 2


@given(seed=seeds)
@settings(max_examples=40, deadline=None)
def test_poses_are_those_of_scipy_and_go_no_farther_than_said(seed):
    rng = np.random.default_rng(seed)
    motion = random_obstacle(rng, np.zeros(3), 3.0, 0.0).motion
    at = np.sort(rng.uniform(-2.0, 6.0, 50))
    turned, places = motion.poses(at)
    for time, R, place in zip(at, turned, places, strict=True):
        first, last = motion.times[[0, -1]]
        if motion.repeats and time > first:
            time = first + (time - first) % (last - first)
        time = min(max(time, first), last)
        k = min(int(np.searchsorted(motion.times, time, "right")) - 1, len(motion.times) - 2)
        share = (time - motion.times[k]) / (motion.times[k + 1] - motion.times[k])
        expected = Rotation.from_rotvec(share * motion.spins[k]) * Rotation.from_matrix(motion.R_task_placed[k])
        np.testing.assert_allclose(R, expected.as_matrix(), atol=1e-9)
        straight = motion.places[k] + share * (motion.places[k + 1] - motion.places[k])
        np.testing.assert_allclose(place, straight, atol=1e-9)
    slid, angle = motion.gone(at)
    assert np.all(np.linalg.norm(np.diff(places, axis=0), axis=1) <= np.diff(slid) + 1e-9)
    between_two = Rotation.from_matrix(turned[1:]) * Rotation.from_matrix(turned[:-1]).inv()
    assert np.all(between_two.magnitude() <= np.diff(angle) + 1e-9)


def test_points_go_into_the_frame_of_an_obstacle_and_out_again():
    rng = np.random.default_rng(5)
    motion = random_obstacle(rng, np.zeros(3), 3.0, 0.0).motion
    points = rng.normal(size=(6, 4, 3))
    times = rng.uniform(-1, 4, 6)
    seen = motion.into_frame(points, times)
    for k, time in enumerate(times):
        np.testing.assert_allclose(motion.out_of_frame(seen[k], time), points[k], atol=1e-12)


@pytest.mark.parametrize("timing", [0.0, 0.1])
def test_timing_takes_off_what_it_moves(timing):
    """A wall that comes towards an arm at rest at 0.1 m/s, as close as 20 mm, may be 10 mm closer."""
    robot = random_robot(np.random.default_rng(1), 2)
    radius, times = float(robot.body_radii.max()), np.array([0.0, 1.0, 1.7])
    poses = [{"time_s": 0.0}, {"time_s": 10.0, "position": (0.0, -1.0, 0.0)}]
    far = radius + 0.02 + 0.17
    said = {"center": (0, far + 0.05, 0), "size": (9, 0.1, 9), "motion": poses, "timing_s": timing}
    wall = Box.model_validate(said)
    angles = np.zeros((3, 2, 2))
    moving = interpolated_motion(robot, BASE, np.zeros((3, 1)), angles)
    vertices = robot.joint_positions(angles, np.zeros(3))
    proof = certify_passing(moving, robot, parted([wall])[1][0], times, vertices, HORIZON, 0.0)
    assert proof.clearance == pytest.approx(0.02 - 0.1 * timing, abs=TIGHTNESS)
    assert proof.clearance <= 0.02 - 0.1 * timing + 1e-12
    assert proof.obstacle == "box 1"
    assert (proof.step, proof.time) == (2, 1.7)


def test_an_arm_that_swings_past_needs_all_of_its_way():
    """A ball that stands still for now, before the straight arm: at both ends of the step the arm is beside it."""
    robot = random_robot(np.random.default_rng(3), 1)
    angles = np.array([[[-0.3, 0.0]], [[0.3, 0.0]]])
    poses = [{"time_s": 5.0}, {"time_s": 6.0, "position": (0.0, 1.0, 0.0)}]
    radius = float(robot.body_radii[0])
    said = {"center": (0, 0, robot.length + radius + 0.025), "diameter": 0.02, "motion": poses}
    ball = Sphere.model_validate(said)
    moving = interpolated_motion(robot, BASE, np.zeros((2, 1)), angles)
    vertices, times = robot.joint_positions(angles, np.zeros(2)), np.array([0.0, 1.0])
    obstacle = parted([ball])[1][0]
    passed = sampled(robot, obstacle, np.zeros(101), robot.joint_positions(between(angles, 100), np.zeros(101)), 0.0)
    assert passed == pytest.approx(0.015, abs=1e-3)
    for halvings in (0, 1, 16):
        with halved_at_most(halvings):
            assert certify_passing(moving, robot, obstacle, times, vertices, HORIZON, 0.0).clearance <= passed


def test_a_ball_that_slides_past_between_two_steps_needs_all_of_its_way():
    """An arm at rest, and a ball that is far on one side at one set-point and far on the other side at the next."""
    robot = random_robot(np.random.default_rng(5), 2)
    angles, times = np.zeros((2, 2, 2)), np.array([0.0, 1.0])
    poses = [{"time_s": 0.0}, {"time_s": 1.0, "position": (0.4, 0.0, 0.0)}]
    middle = 0.5 * robot.length
    (ball,) = parted([Sphere.model_validate({"center": (-0.2, 0, middle), "diameter": 0.02, "motion": poses})])[1]
    moving = interpolated_motion(robot, BASE, np.zeros((2, 1)), angles)
    vertices = robot.joint_positions(angles, np.zeros(2))
    for halvings in (0, 1, 16):
        with halved_at_most(halvings):
            proof = certify_passing(moving, robot, ball, times, vertices, 1.0, 0.0)
        assert proof.clearance <= -robot.body_radii.max()
