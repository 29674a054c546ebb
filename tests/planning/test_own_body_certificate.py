"""The certificate of a body against itself: no motion comes closer than certified, and what touches is named."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from certificate_oracles import halved_at_most
from hypothesis import given
from hypothesis import strategies as st
from planning_makers import altered, between, random_robot

from hognose.following import follow
from hognose.path import Path
from hognose.planning.certificate import certify_own_body, gliding_motion, interpolated_motion
from hognose.planning.certificate.moving import Moving
from hognose.planning.certificate.own_body import LOOSENESS, TIGHTNESS
from hognose.robot import Robot
from hognose.robot.base import Slider
from hognose.robot.own_body import OwnBody, bends_of
from tests.own_body_oracles import dense_clearance

PIECES = 64
ROUNDING = 1e-9
BASE = Slider(np.zeros(3), 1.0, 0.0, 0.0)
seeds = st.integers(0, 2**32 - 1)
sizes = st.floats(-3.0, 0.0).map(lambda exponent: 10.0**exponent)
kinds = st.sampled_from(["coil", "loop", "any"])


def arm(sections: int, pitch: float, width: float) -> Robot:
    """An arm of equal links."""
    made = random_robot(np.random.default_rng(0), 1)
    changes = {"pitch": pitch, "half_lengths": [0.1 * pitch] * 2, "body_diameter": width, "cable_radius": 0.3 * width}
    changes |= {"count": sections}
    return Robot.from_spec(altered(made.spec, {f"section.0.{key}": value for key, value in changes.items()}))


def shape(rng: np.random.Generator, kind: str, sections: int) -> np.ndarray:
    """Angles (n, 2) of an arm that lies close to itself, or may."""
    if kind == "coil":
        turn, rise = rng.uniform(0.3, 0.9), rng.uniform(-0.15, 0.15)
        return np.column_stack([np.full(sections, turn), np.full(sections, rise)])
    if kind == "loop":
        turn = rng.uniform(0.8, 1.3) * 2 * math.pi / sections
        return np.column_stack([np.full(sections, turn), rng.normal(0.0, 0.05, sections)])
    return rng.normal(0.0, 0.8, (sections, 2))


def motion_of(robot: Robot, kind: str, steps: int, swing: float, rng: np.random.Generator) -> np.ndarray:
    """Angles (T, n, 2) that change from step to step, about a shape."""
    changes = rng.normal(0.0, 0.3 * swing, (steps, robot.sections, 2))
    return shape(rng, kind, robot.sections) + np.cumsum(changes, axis=0)


def densest(robot: Robot, angles: np.ndarray, feeds: np.ndarray) -> float:
    """The smallest clearance within the body at many times."""
    motion = robot.joint_positions(between(angles, PIECES), between(feeds, PIECES))
    return float(OwnBody.of(robot).closest(motion)[0].min())


@given(seed=seeds, kind=kinds, sections=st.integers(1, 14), steps=st.integers(1, 8), swing=sizes, bent=st.booleans())
def test_no_interpolated_motion_comes_closer_to_itself_than_certified(seed, kind, sections, steps, swing, bent):
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, sections)
    angles, feeds = motion_of(robot, kind, steps, swing, rng), np.cumsum(rng.uniform(0.0, 0.01, steps))
    moving = interpolated_motion(robot, BASE, feeds[:, None], angles)
    vertices = robot.joint_positions(angles, feeds)
    proof = certify_own_body(moving, robot, vertices, bends_of(angles) if bent else None)
    dense = densest(robot, angles, feeds) if steps > 1 else float(OwnBody.of(robot).closest(vertices)[0].min())
    assert proof.clearance <= min(max(dense, 0.0), proof.horizon) + ROUNDING
    if dense > 2 * TIGHTNESS:  # the samples miss a little of what is between them
        assert proof.clearance >= min((1 - LOOSENESS) * dense - 2 * TIGHTNESS, proof.horizon)


@given(seed=seeds, kind=kinds, sections=st.integers(2, 8), swing=sizes)
def test_of_a_step_no_less_is_taken_off_than_it_needs(seed, kind, sections, swing):
    """The bound itself, without halving."""
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, sections)
    angles, feeds = motion_of(robot, kind, 2, 5 * swing, rng), np.zeros(2)
    moving = interpolated_motion(robot, BASE, feeds[:, None], angles)
    with halved_at_most(0):
        proof = certify_own_body(moving, robot, robot.joint_positions(angles, feeds))
    assert proof.clearance <= max(densest(robot, angles, feeds), 0.0) + ROUNDING


@given(seed=seeds, kind=kinds, sections=st.integers(2, 8), steps=st.integers(3, 30), swing=sizes)
def test_of_a_stride_over_many_steps_no_less_is_taken_off_than_it_needs(seed, kind, sections, steps, swing):
    """To and fro between few set-points, so that the ends of a stride say little of what is between them."""
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, sections)
    few = motion_of(robot, kind, 3, 5 * swing, rng)
    angles, feeds = few[rng.integers(0, 3, steps)], np.zeros(steps)
    moving = interpolated_motion(robot, BASE, feeds[:, None], angles)
    with halved_at_most(0):
        proof = certify_own_body(moving, robot, robot.joint_positions(angles, feeds))
    assert proof.clearance <= max(densest(robot, angles, feeds), 0.0) + ROUNDING


@given(seed=seeds, sections=st.integers(2, 10), turn=st.floats(0.5, 7.0), step=st.floats(0.001, 0.2))
def test_no_gliding_motion_comes_closer_to_itself_than_certified(seed, sections, turn, step):
    """Along a helix whose turns come close to each other."""
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, sections)
    radius, rise = rng.uniform(0.1, 0.3), rng.uniform(0.0, 0.03)
    around = np.linspace(0.0, turn, 40)
    way_points = np.column_stack([radius * (1 - np.cos(around)), rise * around, radius * np.sin(around)])
    path = Path.through(way_points, 3, (0.0, 0.0, 1.0)).with_run(robot.length)
    feeds = np.arange(0.0, max(step, path.length - 1.2 * robot.length), step)
    moving = gliding_motion(path, robot, feeds)
    if moving is None:
        return
    motion = (
        follow(path, robot.link_lengths, between(feeds, 16))
        if len(feeds) > 1
        else follow(path, robot.link_lengths, feeds)
    )
    dense = float(OwnBody.of(robot).closest(motion)[0].min())
    for halvings in (0, 16):
        with halved_at_most(halvings):
            proof = certify_own_body(moving, robot, follow(path, robot.link_lengths, feeds))
        assert proof.clearance <= max(dense, 0.0) + ROUNDING
    if dense > 2 * TIGHTNESS:
        assert proof.clearance >= min((1 - LOOSENESS) * dense - 2 * TIGHTNESS, proof.horizon)


@pytest.mark.parametrize("kind", ["coil", "loop", "any"])
def test_what_sampled_points_show_to_touch_is_never_certified(kind):
    """Second opinion on all of it: points of the axis every 5 mm at many times."""
    touching = 0
    for seed in range(12):
        rng = np.random.default_rng(seed)
        robot, feeds = random_robot(rng, 10), np.zeros(5)
        angles = motion_of(robot, kind, 5, 0.3, rng)
        moving = interpolated_motion(robot, BASE, feeds[:, None], angles)
        proof = certify_own_body(moving, robot, robot.joint_positions(angles, feeds), bends_of(angles))
        bodies = robot.joint_positions(between(angles, 10), between(feeds, 10))
        dense = min(dense_clearance(body, robot.link_lengths, robot.body_radii, 0.005)[0] for body in bodies)
        assert proof.clearance <= max(dense, 0.0) + ROUNDING
        touching += dense <= 0
    assert touching > 0


def test_a_loop_that_crosses_itself_is_named_by_the_numbers_of_its_links():
    """A little more than a whole round, whose end comes down through the first link between the two steps."""
    robot = arm(10, 0.1, 0.02)
    angles = np.zeros((2, 10, 2))
    angles[:, 1:, 0] = math.radians(42.0)
    angles[0, 6, 1], angles[1, 6, 1] = 0.5, -0.5
    moving = interpolated_motion(robot, BASE, np.zeros((2, 1)), angles)
    ends = robot.joint_positions(angles, np.zeros(2))
    assert OwnBody.of(robot).closest(ends)[0].min() > 0.008
    proof = certify_own_body(moving, robot, ends, bends_of(angles))
    middle = robot.joint_positions(angles.mean(axis=0))
    dense, links = dense_clearance(middle, robot.link_lengths, robot.body_radii, 0.001)
    assert dense < 0
    assert proof.clearance < 0
    assert links == (0, 9)
    crossed = {
        (0, 8): 0.0223,
        (0, 9): 0.0706,
    }  # both axes cross that of link 1; last bits decide
    assert proof.links in crossed
    assert proof.step == 0
    np.testing.assert_allclose(proof.place, [0.0, 0.0, crossed[proof.links]], atol=1e-4)


def test_an_arm_of_one_link_cannot_touch_itself():
    robot, angles = arm(1, 0.1, 0.02), np.zeros((3, 1, 2))
    moving = interpolated_motion(robot, BASE, np.zeros((3, 1)), angles)
    proof = certify_own_body(moving, robot, robot.joint_positions(angles, np.zeros(3)), bends_of(angles))
    assert (proof.clearance, proof.step) == (proof.horizon, None)


def test_the_straight_arm_needs_no_distance(monkeypatch):
    robot, angles = arm(60, 0.03, 0.05), np.zeros((4, 60, 2))
    feeds = np.linspace(0.0, 0.3, 4)
    monkeypatch.setattr("hognose.planning.certificate.own_body._strides", None)
    moving = interpolated_motion(robot, BASE, feeds[:, None], angles)
    proof = certify_own_body(moving, robot, robot.joint_positions(angles, feeds), bends_of(angles))
    assert (proof.clearance, proof.step) == (proof.horizon, None)


# A case for every term, of one pair of links 20 mm thick: with the term left out, too much is proven.


@pytest.fixture
def pair(monkeypatch):
    """Certifies the first of three links against the last one alone, at vertices that are given, without halving."""
    robot = arm(3, 0.1, 0.02)
    own = OwnBody.of(robot)
    (number,) = np.flatnonzero((own.pairs == (0, 2)).all(axis=1))
    alone = {name: getattr(own, name)[number : number + 1] for name in ("pairs", "aparts", "arcs", "thick")}
    monkeypatch.setattr(OwnBody, "of", lambda *_: dataclasses.replace(own, **alone))

    def certified(vertices: np.ndarray, bulge: np.ndarray | None = None, straight: bool = True) -> float:
        def travel(pieces):
            moved = np.linalg.norm(pieces.high_body - pieces.low_body, axis=2)
            return moved, np.zeros_like(moved) if bulge is None else bulge

        moving = Moving(
            np.linspace(0.0, 1.0, len(vertices))[:, None], lambda parameters: (parameters, vertices), travel, straight
        )
        with halved_at_most(0):
            return certify_own_body(moving, robot, vertices).clearance

    return certified


def crossing(*heights: float, share: float = 0.0) -> np.ndarray:
    """Link 3 over link 1 at right angles, at heights (T,); `share` of the height is that of link 1 below zero."""
    first = np.array([[-0.05, 0.0, 0.0], [0.05, 0.0, 0.0]])
    third = np.array([[0.0, -0.05, 0.0], [0.0, 0.05, 0.0]])
    up = np.array([0.0, 0.0, 1.0])
    return np.array([np.concatenate([first - share * h * up, third + (1 - share) * h * up]) for h in heights])


@pytest.mark.parametrize("height", [0.03, 0.3])
def test_two_links_that_pass_through_each_other_need_all_of_the_motion(pair, height):
    assert pair(crossing(height, -height)) == pytest.approx(-0.02, abs=1e-12)


@pytest.mark.parametrize("moves", range(4))
def test_of_a_pair_the_ends_that_move_most_count(pair, moves):
    """One end goes from one side of the other link to the other side; the other three ends stay."""
    vertices = crossing(0.0, 0.0)
    link = vertices[:, :2] if moves < 2 else vertices[:, 2:]
    link += 0.03 * (link[:, [1 - moves % 2]] - link[:, [moves % 2]]) / 0.1
    vertices[0, moves, 2], vertices[1, moves, 2] = 0.2, -0.2
    assert pair(vertices) < 0


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_of_gliding_links_both_ways_count(pair, share):
    assert pair(crossing(0.3, -0.3, share=share), straight=False) == pytest.approx(-0.02, abs=1e-12)


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_a_stride_counts_what_both_links_travel(pair, share):
    """At the fifth step they touch; at both ends of a stride over all of them they are far apart."""
    assert pair(crossing(0.3, 0.24, 0.18, 0.12, 0.06, 0.0, 0.06, share=share)) == pytest.approx(-0.02, abs=1e-12)


@pytest.mark.parametrize("vertex", range(4))
def test_a_stride_counts_the_largest_bulge(pair, vertex):
    bulge = np.zeros((5, 4))
    bulge[3, vertex] = 0.1
    assert pair(crossing(*[0.1] * 6), bulge) == pytest.approx(0.1 - 0.02 - 0.1, abs=1e-12)
