"""The twin and obstacles that move: where they are, and what they do to the arm."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from twin_makers import boards, robot_of

import hognose
from hognose.rotations import rotations_of_vectors, vector_of_rotation
from hognose.scene import Board, MovingObstacle, Scene
from hognose.scene.rigid_motion import RigidMotion
from hognose.sim import Changes, Twin, simulate
from hognose.sim.contact import DAMPING, STIFFNESS, Contact
from hognose.sim.moving_frame import MovingFrame


def random_motion(rng: np.random.Generator, repeats: bool) -> RigidMotion:
    count = int(rng.integers(2, 6))
    turned = rotations_of_vectors(rng.uniform(-1.5, 1.5, (count, 3)))
    places = rng.uniform(-0.1, 0.1, (count, 3))
    if repeats:
        turned[-1], places[-1] = turned[0], places[0]
    spins = np.array([vector_of_rotation(b @ a.T) for a, b in pairwise(turned)])
    times = np.cumsum(rng.uniform(0.1, 2.0, count)) - 0.5
    return RigidMotion(times, rng.uniform(-0.1, 0.1, 3), places, turned, spins, repeats)


@given(st.integers(0, 2**32 - 1), st.booleans())
def test_an_obstacle_sees_the_arm_as_its_motion_says(seed, repeats):
    rng = np.random.default_rng(seed)
    motion, points = random_motion(rng, repeats), rng.uniform(-1, 1, (5, 3))
    frame = MovingFrame.of(motion, 5)
    for time in [*rng.uniform(-2, 30, 8), *motion.times]:
        seen = frame.seen(points, float(time))
        np.testing.assert_allclose(seen, motion.into_frame(points[None], [time])[0], rtol=0, atol=1e-12)
        np.testing.assert_allclose(frame.R_task_placed, motion.poses([time])[0][0], rtol=0, atol=1e-12)


def test_what_moves_is_touched_where_it_is_at_the_time():
    """An independent way: the same obstacle as a new scene at each time."""
    rng, robot = np.random.default_rng(4), robot_of(4)
    joints = robot.joint_positions(np.zeros((4, 2)))
    scene = Scene.from_obstacles([Board(center=(0, 0, 0.2), size=(0.1, 0.1), thickness=0.01)])
    motion = random_motion(rng, True)
    motion = replace(motion, pivot=np.array([0.0, 0.0, 0.2]), places=0.5 * motion.places + np.array([0.03, 0.0, 0.2]))
    board = MovingObstacle("gate", scene, motion, 0.0)
    contact, seen = Contact(robot, Scene.from_parts([]), [board]), 0
    for time in np.arange(0.0, 6.0, 0.01).tolist():
        contact.crossed = None
        found = contact.touches(joints, time)
        still = Contact(robot, Scene.from_parts(board.parts_at(time)))
        expected = still.touches(joints)
        assert [(t.link, t.obstacle) for t in found] == [(t.link, "gate") for t in expected]
        assert (contact.crossed is None) == (still.crossed is None)
        for one, other in zip(found, expected, strict=True):
            assert one.depth == pytest.approx(other.depth, abs=1e-9)
            if other.depth > 1e-5:  # where it only just touches, the closest point may be another one
                np.testing.assert_allclose(one.normal, other.normal, atol=1e-5)
                np.testing.assert_allclose(one.place, other.place, atol=1e-6)
            on_mesh = one.place - (robot.body_radii[one.link] - one.depth) * one.normal
            there = motion.into_frame(on_mesh[None, None], [time])[0]
            drift = motion.out_of_frame(there, time + 1e-4)[0] - on_mesh
            np.testing.assert_allclose(one.velocity, drift / 1e-4, atol=1e-6)
        seen += len(found)
    assert seen > 50


def test_what_comes_towards_the_arm_pushes_harder_than_what_stands_there():
    plan = boards()
    link = 0.5 * (plan.joints[0, 5] + plan.joints[0, 6])
    touching = float(plan.robot.body_radii[5]) + 0.005 - 0.001  # 1 mm deep
    above = tuple(link + np.array([0.0, touching, 0.0]))
    board = Board(center=above, normal=(0, 1, 0), up=(0, 0, 1), size=(0.1, 0.03), thickness=0.01)
    scene, found = Scene.from_obstacles([board]), {}
    for name, end in (("still", 0.0), ("comes", -0.1), ("goes", 0.1)):
        places = np.array([[0.0, 0.0, 0.0], [0.0, end, 0.0]])
        motion = RigidMotion(np.array([0.0, 10.0]), np.zeros(3), places, np.stack([np.eye(3)] * 2), np.zeros((1, 3)))
        task = plan.task.with_obstacles(Scene.from_parts([]), (MovingObstacle("gate", scene, motion, 0.0),))
        twin = Twin(task)
        twin.put(plan.at[0], plan.angles[0])
        twin.step(plan.commanded_lengths[0], np.zeros(36), plan.at[0], np.zeros(1), 0.0)
        assert {touch.obstacle for touch, _ in twin.touches} == {"gate"}
        found[name] = twin.pressed[5] / len([touch for touch, _ in twin.touches if touch.link == 5])
    assert found["still"] == pytest.approx(STIFFNESS * 1e-3, rel=1e-3)
    assert found["comes"] - found["still"] == pytest.approx(DAMPING * 0.01, rel=1e-3)
    assert found["goes"] - found["still"] == pytest.approx(-DAMPING * 0.01, rel=1e-3)


def test_a_plan_past_what_moves_goes_well_and_not_if_it_moves_elsewhere():
    plan = hognose.plan(hognose.load_task("moving-obstacles"))
    done = simulate(plan)
    assert done.good
    assert "remarks" not in done.to_json()
    assert done.tip_errors.max() < 0.3e-3
    lower = simulate(plan, Changes(shifted={"wheel": (0.0, -0.05, 0.0)}))
    assert lower.touched == ("wheel",)
    begin = lower.touches["wheel"].first
    wheel = next(each for each in plan.task.moving if each.name == "wheel")
    motion = replace(wheel.motion, places=wheel.motion.places + np.array([0.0, -0.05, 0.0]))
    parts = replace(wheel, motion=motion).parts_at(begin)
    row = int(np.searchsorted(plan.time, begin))
    ends = plan.body[row, :-1], plan.body[row, 1:]
    gap = (Scene.from_parts(parts).distance(*ends).value - plan.robot.body_radii).min()
    assert abs(gap) < 0.005  # the planned arm is about to touch it there, too
