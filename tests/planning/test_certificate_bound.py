"""The certificate's bound itself, without the halving that hides it: every term of it, against dense samples."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest
from certificate_oracles import bulges, needed, taken_off
from hypothesis import assume, given
from hypothesis import strategies as st
from planning_makers import altered, between, clearances, random_robot

from hognose.errors import InfeasibleError
from hognose.following import follow
from hognose.path import Path
from hognose.planning.certificate import certify, gliding_motion, interpolated_motion
from hognose.robot import Robot
from hognose.robot.base import Slider
from hognose.robot.own_body import OwnBody
from hognose.robot.sections import RIGID_LINK
from hognose.scene import Scene, Sphere
from hognose.steering import SteeredPath
from hognose.steering.clearance import Surroundings

PIECES = 64
EMPTY, STILL = Scene.from_obstacles([]), Slider(np.zeros(3), 1.0, 0.0, 0.0)
ROUNDING = 1e-12
seeds = st.integers(0, 2**32 - 1)
#: Steps of all sizes, those that are small as often as those that are large.
sizes = st.floats(-3.0, 0.0).map(lambda exponent: 10.0**exponent)


def arm(*lengths: float) -> Robot:
    """An arm of links of these lengths, m."""
    made = random_robot(np.random.default_rng(0), len(lengths))
    pitches = {f"section.{k}.pitch": length for k, length in enumerate(lengths)}
    halves = {f"section.{k}.half_lengths": [0.1 * length] * 2 for k, length in enumerate(lengths)}
    return Robot.from_spec(altered(made.spec, pitches | halves))


def interpolated(robot: Robot, feeds: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What one step of the drives needs and what the certificate takes off for it, (n,) m each."""
    body, start = robot.joint_positions(angles, feeds), np.zeros(3)

    moving = interpolated_motion(robot, Slider(start, 1.0, 0.0, 0.0), feeds[:, None], angles)
    motion = robot.joint_positions(between(angles, PIECES), between(feeds, PIECES))
    return needed(motion), taken_off(partial(certify, moving, robot, EMPTY, body, horizon=math.inf), robot.sections)


def gliding(robot: Robot, path: Path, feeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What one step along a path needs and what the certificate takes off for it, (n,) m each.

    All that there is where nothing is certified.
    """
    joints = follow(path, robot.link_lengths, feeds)
    moving = gliding_motion(path, robot, feeds)
    if moving is None:
        return np.full(robot.sections, math.inf), np.full(robot.sections, math.inf)
    motion = follow(path, robot.link_lengths, between(feeds, PIECES))
    return needed(motion), taken_off(partial(certify, moving, robot, EMPTY, joints, horizon=math.inf), robot.sections)


@given(seed=seeds, sections=st.integers(1, 6), swing=sizes, feed=sizes)
def test_an_interpolated_step_needs_no_more_than_is_taken_off(seed, sections, swing, feed):
    rng = np.random.default_rng(seed)
    low = rng.uniform(-1.4, 1.4, (sections, 2))
    angles = np.array([low, low + rng.uniform(-1.5, 1.5, low.shape) * swing])
    need, off = interpolated(random_robot(rng, sections), np.array([0.0, 0.2 * feed * rng.integers(-1, 2)]), angles)
    assert (need <= off + ROUNDING).all()


@given(seed=seeds, sections=st.integers(1, 5), order=st.integers(1, 5), stretch=st.floats(1, 30), step=sizes)
def test_a_gliding_step_needs_no_more_than_is_taken_off(seed, sections, order, stretch, step):
    rng = np.random.default_rng(seed)
    robot, width = random_robot(rng, sections), rng.uniform(0, 0.2)
    way_points = np.column_stack([rng.uniform(-width, width, (4, 2)), np.cumsum(rng.uniform(0.2, 0.6, 4))])
    path = Path.through(stretch * way_points, order, (0.0, 0.0, 1.0)).with_run(robot.length)
    begin = rng.uniform(0, path.length - robot.length)
    try:
        need, off = gliding(robot, path, np.array([begin, begin + 0.5 * stretch * step]))
    except (InfeasibleError, ValueError):
        assume(False)
        return
    assume(np.isfinite(off).all())
    assert (need <= off + ROUNDING).all()


@given(seed=seeds, step=sizes)
def test_a_step_of_the_steered_nose_is_not_taken_for_less_than_it_needs(seed, step):
    """With the least clearance at both ends that would do for the motion, less a little, nothing is proven."""
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, int(rng.integers(1, 5)))
    steered = SteeredPath(robot, EMPTY)
    for _ in range(30):
        steered.advance(robot.length / 30, rng.normal(size=2) * 20)
    curve = steered._curve
    start = rng.uniform(0, 0.9 * curve.end)
    end = min(curve.end, start + 2 * robot.length * step)
    motion = curve.place(np.linspace(start, end, PIECES + 1))[1]
    need = needed(motion)
    for link in range(robot.sections):
        found = np.full((1, robot.sections), math.inf)

        class Space(Surroundings):
            def clearance(self, vertices, found=found):
                return np.repeat(found, len(vertices), axis=0)

        space = Space(robot, steered._base, EMPTY, 0.005, np.zeros(robot.sections))
        space._own_body = OwnBody.chain(np.ones(1), np.ones(1))  # a body of one link, which cannot touch itself
        found[0, link] = space.least[link] + need[link] * (1 - 1e-6) - ROUNDING
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("hognose.steering.clearance.FINEST", math.inf)
            assert space.proven(curve, start, found[0], end) == (start, link)


# A case for every term: with the term left out, or the motion weakened by a tenth, less is taken off than is needed.


def test_a_straight_advance_needs_all_of_the_motion():
    """Links much shorter than the step, towards a point half-way and on: nothing less than the whole way will do."""
    robot, feeds = arm(0.02, 0.03), np.array([0.0, 0.7])
    path = Path.through([[0, 0, 0], [0, 0, 1.5]], 1)
    for need, off in (interpolated(robot, feeds, np.zeros((2, 2, 2))), gliding(robot, path, feeds)):
        assert need == pytest.approx([0.35, 0.35], rel=1e-9)
        assert off == pytest.approx([0.35, 0.35], rel=1e-9)


@pytest.mark.parametrize("kind", ["interpolated", "gliding"])
def test_a_ball_met_half_way_is_met_by_the_bound_too(kind):
    """Both steps are a third of a metre clear of it; a tenth less of the motion, and the step would pass as clear."""
    robot, feeds, angles = arm(0.02), np.array([0.0, 0.7]), np.zeros((2, 1, 2))
    radius = robot.body_radii[0]
    scene = Scene.from_obstacles([Sphere(center=(0.0, 0.0, 0.36), diameter=1e-4)])
    body = robot.joint_positions(angles, feeds)
    found = clearances(scene, robot, body)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hognose.planning.certificate.bound.MOST_HALVINGS", 0)
        if kind == "interpolated":
            moving = interpolated_motion(robot, Slider(np.zeros(3), 1.0, 0.0, 0.0), feeds[:, None], angles)
        else:
            path = Path.through([[0, 0, 0], [0, 0, 1.5]], 1)
            moving = gliding_motion(path, robot, feeds)
        assert moving is not None
        proof = certify(moving, robot, scene, body, found, math.inf)
    assert found.min() > 0.3
    assert -radius - 0.011 < proof.clearance <= -radius


@pytest.mark.parametrize("still", [1, 2])
def test_the_end_that_moves_more_counts(still):
    """The last link turns about its near end, or about its far end: elbow up and elbow down."""
    robot, turn = arm(0.1, 0.1), 0.2
    low, high = ([0.0, 0.0], [0.0, turn]) if still == 1 else ([turn, -2 * turn], [-turn, 2 * turn])
    angles = np.zeros((2, 2, 2))
    angles[:, :, 0] = low, high
    moved = np.linalg.norm(np.diff(robot.joint_positions(angles), axis=0)[0], axis=1)
    assert moved[still] < 1e-12 < 0.18 * 0.1 < moved[3 - still]
    need, off = interpolated(robot, np.zeros(2), angles)
    assert 0.48 * moved.max() < need[1] <= off[1]


def test_where_a_path_bends_the_arc_counts_not_the_chord():
    robot = arm(0.02)
    turns = np.linspace(-math.pi / 2, math.pi / 2, 40)
    arc = 0.3 * np.column_stack([1 + np.sin(turns), 0 * turns, np.cos(turns)])
    path = Path.through(arc, 3)
    feeds = np.array([0.2, 0.7])
    need, off = gliding(robot, path, feeds)
    chord = np.linalg.norm(np.diff(follow(path, robot.link_lengths, feeds), axis=0)[0], axis=1)
    assert off == pytest.approx([0.25], rel=1e-3)
    assert 0.5 * chord.max() < need[0] - 0.005


@pytest.mark.parametrize("which", ["near", "far"])
def test_on_a_path_the_end_that_goes_farther_counts(which):
    """Into a bend the far end of a link goes a tenth farther than the near one, out of it the near end."""
    robot, bend, turn = arm(0.18), 0.165, 1.5
    turns, straight = np.linspace(0, turn, 40), np.zeros((40, 3))
    arc = bend * np.column_stack([1 - np.cos(turns), 0 * turns, np.sin(turns)])
    straight[:, 2] = np.linspace(-1.0, -0.01, 40)
    way_points = np.concatenate([straight, arc])
    path = Path.through(way_points if which == "far" else way_points[::-1], 3)
    begin = 1.0 - 0.08 if which == "far" else bend * turn - 0.12
    need, off = gliding(robot, path, np.array([begin, begin + 0.02]))
    joints = follow(path, robot.link_lengths, [begin, begin + 0.02])
    less = np.linalg.norm(np.diff(joints, axis=0)[0], axis=1).min()
    assert 0.53 * less < need[0] <= off[0] < 0.6 * less


TELLING = {
    "carried round": ([[0.7, 0.1], [-1.5, 1.1]], [[0.7, -0.9], [-1.5, -0.4]]),
    "own turn": ([[0.7, -0.5]], [[1.4, -1.5]]),
    "growth": ([[-1.5, -1.2], [1.2, -1.5], [-1.5, -1.5]], [[1.5, -1.5], [-1.2, 1.5], [-0.4, 0.4]]),
    "angular acceleration": (
        [[-0.72, 0.94], [-1.37, 0.48], [1.24, 0.04]],
        [[-0.73, 0.93], [0.56, -0.91], [0.98, 1.15]],
    ),
    "centripetal": ([[0.0, 0.0]], [[0.5, 0.0]]),
    "beta": ([[0.0, 0.0]], [[0.0, 0.5]]),
}


def accelerations(low: np.ndarray, high: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """The largest acceleration (n+1,) of the joints that second differences over a step see: never too large."""
    robot = arm(*lengths)
    motion = robot.joint_positions(between(np.array([low, high]), PIECES))
    return np.linalg.norm(np.diff(motion, 2, axis=0), axis=2).max(axis=0) * PIECES**2


def bulges_of(low: np.ndarray, high: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    return RIGID_LINK.bulges(low[None], high[None], lengths, np.zeros((1, 3)), np.zeros(1))[0]


@pytest.mark.parametrize("term", TELLING)
def test_without_this_term_a_motion_is_faster_than_the_bulge_allows_for(term):
    low, high = (np.array(side) for side in TELLING[term])
    lengths = np.full(len(low), 0.3)
    seen = accelerations(low, high, lengths)
    assert (seen[1:] > 1.05 * 8 * bulges(low, high, lengths, without=term)[1:]).any(), "the case tells nothing"
    assert (seen <= 8 * bulges_of(low, high, lengths) * (1 + 1e-9)).all()


@given(seed=seeds, sections=st.integers(1, 6), swing=sizes)
def test_the_bulge_is_what_the_derivation_says_and_allows_for_every_acceleration(seed, sections, swing):
    rng = np.random.default_rng(seed)
    low = rng.uniform(-1.5, 1.5, (sections, 2))
    high, lengths = low + 3 * swing * rng.uniform(-1, 1, low.shape), rng.uniform(0.05, 0.3, sections)
    found = bulges_of(low, high, lengths)
    np.testing.assert_allclose(found, bulges(low, high, lengths), rtol=1e-9, atol=1e-15)
    assert (accelerations(low, high, lengths) <= 8 * found * (1 + 1e-9) + PIECES**2 * 1e-14).all()


def test_of_many_steps_the_worst_counts_and_is_named():
    robot = arm(0.1, 0.1, 0.1)
    feeds = np.array([0.0, 0.01, 0.03, 0.04])
    angles = np.zeros((4, 3, 2))
    body, found = robot.joint_positions(angles, feeds), np.full((4, 3), 0.05)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hognose.planning.certificate.bound.MOST_HALVINGS", 0)
        moving = interpolated_motion(robot, Slider(np.zeros(3), 1.0, 0.0, 0.0), feeds[:, None], angles)
        proof = certify(moving, robot, EMPTY, body, found, math.inf)
        assert (proof.clearance, proof.step, proof.halvings) == (pytest.approx(0.04), 1, 0)
        found[3, 2] = 0.01
        proof = certify(moving, robot, EMPTY, body, found, math.inf)
        # What has been seen at a step is a bound too, and the smaller one counts.
        assert (proof.clearance, proof.step, proof.link) == (0.01, 2, 2)


def test_steps_of_a_plan_need_no_more_than_is_taken_off(boards):
    robot = boards.robot
    for step in range(0, len(boards.feed) - 1, 40):
        rows = slice(step, step + 2)
        for need, off in (
            interpolated(robot, boards.feed[rows], boards.angles[rows]),
            gliding(robot, boards.path, boards.feed[rows]),
        ):
            assert np.isfinite(off).all()
            assert (need <= off + ROUNDING).all()


def test_a_body_that_just_touches_at_a_step_is_looked_at_between_the_steps():
    robot = arm(0.1, 0.1)
    angles = np.array([np.zeros((2, 2)), np.full((2, 2), 0.2)])
    body = robot.joint_positions(angles, np.zeros(2))
    moving = interpolated_motion(robot, STILL, np.zeros((2, 1)), angles)
    proof = certify(moving, robot, EMPTY, body, np.zeros((2, 2)), math.inf, 0.0)
    assert proof.halvings > 0
    assert proof.clearance <= 0.0
