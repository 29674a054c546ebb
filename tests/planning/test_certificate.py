"""The heart of the product: what is certified holds for the whole continuous motion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, event, given, settings
from hypothesis import strategies as st
from planning_makers import between, clearances, random_robot, random_scene, rod
from scipy.spatial.transform import Rotation, Slerp

from hognose.errors import InfeasibleError
from hognose.following import follow
from hognose.path import Path
from hognose.planning.certificate import Certificate, certify, gliding_motion, interpolated_motion
from hognose.robot import Robot
from hognose.robot.base import Base, Slider, joints_on
from hognose.robot.carrier import Carrier
from hognose.robot.drum import Drum
from hognose.robot.sections import RIGID_LINK
from hognose.scene import Scene

PIECES = 100
#: How close the certificate comes to what was seen, m: docs/certificate.md.
TIGHTNESS = 2.5e-4
seeds = st.integers(0, 2**32 - 1)
START = np.array([0.1, -0.2, 0.3])
BASE = Slider(START, 1.0, 0.0, 0.0)


def interpolated(
    robot: Robot, scene: Scene, feeds: np.ndarray, angles: np.ndarray, horizon: float = 0.05
) -> tuple[Certificate, np.ndarray, np.ndarray]:
    """The certificate, what dense sampling finds (T', n), and how far a sub-step moves at most."""
    body = robot.joint_positions(angles, feeds) + START
    at_steps = clearances(scene, robot, body, horizon)
    moving = interpolated_motion(robot, BASE, feeds[:, None], angles)
    proof = certify(moving, robot, scene, body, at_steps, horizon)
    dense = robot.joint_positions(between(angles, PIECES), between(feeds, PIECES)) + START
    moved = np.linalg.norm(np.diff(dense, axis=0), axis=2).max()
    return proof, np.minimum(clearances(scene, robot, dense), horizon), moved


def gliding(
    robot: Robot, scene: Scene, path: Path, feeds: np.ndarray, horizon: float = 0.05
) -> tuple[Certificate | None, np.ndarray, np.ndarray]:
    joints = follow(path, robot.link_lengths, feeds)
    at_steps = clearances(scene, robot, joints, horizon)
    moving = gliding_motion(path, robot, feeds)
    proof = None if moving is None else certify(moving, robot, scene, joints, at_steps, horizon)
    dense = follow(path, robot.link_lengths, between(feeds, PIECES))
    moved = np.linalg.norm(np.diff(dense, axis=0), axis=2).max()
    return proof, np.minimum(clearances(scene, robot, dense), horizon), moved


def assert_sound_and_tight(proof: Certificate, sampled: np.ndarray, moved: np.ndarray) -> None:
    smallest = float(sampled.min())
    assert proof.clearance <= max(smallest, 0.0) + 1e-12
    # No sample comes as low as the true minimum, but the minimum is at most half a sub-step away.
    assert proof.clearance >= smallest - TIGHTNESS - moved / 2
    event("touches" if smallest <= 0 else "clear" if proof.clearance > 0 else "undecided")
    assert proof.clearance > 0 or smallest < TIGHTNESS + moved / 2


@given(
    seed=seeds,
    sections=st.integers(1, 6),
    steps=st.integers(2, 5),
    swing=st.floats(1e-3, 0.5),
    feed=st.floats(0.0, 0.06),
    horizon=st.sampled_from([0.02, 0.05, 1.0]),
)
@settings(max_examples=60, deadline=None)
def test_no_interpolated_motion_comes_closer_than_certified(seed, sections, steps, swing, feed, horizon):
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, sections)
    angles = np.cumsum(rng.uniform(-swing, swing, (steps, sections, 2)), axis=0)
    feeds = np.cumsum(rng.uniform(-feed, feed, steps))
    reach = robot.joint_positions(angles, feeds) + START
    scene = random_scene(rng, reach.min(axis=(0, 1)) - 0.1, reach.max(axis=(0, 1)) + 0.1)
    assert_sound_and_tight(*interpolated(robot, scene, feeds, angles, horizon))


@given(
    seed=seeds,
    sections=st.integers(1, 6),
    order=st.integers(1, 5),
    width=st.floats(0.005, 0.1),
    step=st.floats(0.002, 0.06),
    horizon=st.sampled_from([0.02, 0.05, 1.0]),
)
@settings(max_examples=60, deadline=None)
def test_no_gliding_motion_comes_closer_than_certified(seed, sections, order, width, step, horizon):
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, sections)
    forward = np.cumsum(rng.uniform(0.2, 0.5, 4))
    way_points = np.column_stack([rng.uniform(-width, width, (4, 2)), forward])
    path = Path.through(way_points, order, (0.0, 0.0, 1.0)).with_run(robot.length)
    begin = rng.uniform(0, path.length - 0.9 * robot.length)
    feeds = begin + np.cumsum(np.append(0.0, rng.uniform(0.1, 1.0, 4) * step))
    try:
        reach = follow(path, robot.link_lengths, feeds)
    except (InfeasibleError, ValueError):
        assume(False)
        return
    scene = random_scene(rng, reach.min(axis=(0, 1)) - 0.05, reach.max(axis=(0, 1)) + 0.05)
    proof, sampled, moved = gliding(robot, scene, path, feeds, horizon)
    # Nothing is certified where joints may jump, and only there.
    assert (proof is None) == (path.sharpest[0] * robot.link_lengths.max() > math.sqrt(2))
    if proof is not None:
        assert_sound_and_tight(proof, sampled, moved)


def test_a_hairpin_of_the_path_within_one_step_is_not_overlooked():
    """Between two steps the tip goes 20 mm aside and back; a rod stands where it turns."""
    robot = random_robot(np.random.default_rng(1), 2)
    length, (first, last) = robot.length, robot.body_radii
    path = Path.through([[0, 0, 0], [0, 0, 0.3], [0.02, 0, 0.305], [0, 0, 0.31], [0, 0, 0.6]], 1)
    feeds = np.array([0.25, 0.2995, 0.3105]) - length
    beside = [(0.019 + last, 0.305), (-0.003 - first, 0.25 - length)]
    # The second comes closest, at the first step; so nothing calls for a closer look later.
    rods = [rod(x, 0.0, z, 0.001) for x, z in beside]
    proof, sampled, _ = gliding(robot, Scene.from_obstacles(rods), path, feeds)
    assert sampled.min() < 0 < 0.002 < sampled[::PIECES].min()
    assert proof is None, "nothing is certified where joints may jump"


@given(seed=seeds, sections=st.integers(1, 8), swing=st.floats(1e-4, 1.5))
@settings(max_examples=150, deadline=None)
def test_no_joint_leaves_its_chord_by_more_than_the_bulge(seed, sections, swing):
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, sections)
    low = rng.uniform(-1.5, 1.5, (1, sections, 2))
    high = low + rng.uniform(-swing, swing, low.shape)
    bulge = RIGID_LINK.bulges(low, high, robot.link_lengths, np.zeros((len(low), 3)), np.zeros(len(low)))
    motion = robot.joint_positions(between(np.concatenate([low, high]), 256))
    fraction = np.linspace(0, 1, 257)[:, None, None]
    chord = motion[0] + fraction * (motion[-1] - motion[0])
    assert (np.linalg.norm(motion - chord, axis=2).max(axis=0) <= bulge[0] + 1e-14).all()


@pytest.mark.parametrize("axis", [0, 1])
def test_the_bulge_of_one_link_turning_is_the_sagitta(axis):
    turn, length = 1e-3, 0.3
    low, high = np.zeros((1, 1, 2)), np.zeros((1, 1, 2))
    high[0, 0, axis] = turn
    bulge = RIGID_LINK.bulges(low, high, np.array([length]), np.zeros((len(low), 3)), np.zeros(len(low)))
    assert bulge[0, 0] == 0
    assert bulge[0, 1] == pytest.approx(length * (1 - math.cos(turn / 2)), rel=1e-6)


@pytest.mark.parametrize("swing", [0.05, 0.3, 1.2])
def test_a_needle_between_two_clear_steps_is_not_certified(swing):
    """One link swings across a rod of 0.2 mm; at both steps it is clear by any measure."""
    robot = random_robot(np.random.default_rng(3), 1)
    radius = robot.body_radii[0]
    ahead = 0.5 * robot.length + 2 * radius / swing
    length = 4 * ahead
    robot = Robot.from_spec(
        robot.spec.model_copy(update={"section": (robot.spec.section[0].model_copy(update={"pitch": length}),)})
    )
    x, y, z = START
    scene = Scene.from_obstacles([rod(x, y, z + ahead, 0.0002)])
    angles = np.array([[[-swing, 0.0]], [[swing, 0.0]]])
    proof, sampled, _ = interpolated(robot, scene, np.zeros(2), angles)
    assert sampled[[0, -1]].min() > 0.1 * radius
    assert proof.clearance <= sampled.min() < 0
    assert (proof.step, proof.link) == (0, 0)


def test_a_plate_between_two_clear_feeds_is_not_certified():
    """Set-points one link apart put every joint where another was; in between the chords cut the corner."""
    robot = random_robot(np.random.default_rng(5), 1)
    link = robot.spec.section[0].model_copy(update={"pitch": 0.08, "body_diameter": 0.02, "count": 4})
    robot = Robot.from_spec(robot.spec.model_copy(update={"section": (link,)}))
    bend = 0.15
    turns = np.linspace(0, math.pi / 2, 12)[1:]
    arc = np.column_stack([bend * (1 - np.cos(turns)), 0 * turns, bend * np.sin(turns)])
    path = Path.through(np.concatenate([[[0, 0, -0.5], [0, 0, -0.25], [0, 0, 0]], arc]), 3, (0, 0, 1))
    run_to = path.length - robot.length - 0.09
    first = follow(path, robot.link_lengths, [run_to])[0]
    # On the (almost) straight run joint 0 then stands where joint 1 stood, one link further.
    feeds = np.array([run_to, run_to + 0.08])
    second = follow(path, robot.link_lengths, feeds[1:])[0]
    np.testing.assert_allclose(second[:-1], first[1:], rtol=0, atol=1e-6)
    corner = first[3]
    inward = np.array([bend, 0, 0]) - corner
    place = corner + (0.01 + 0.0012) * inward / np.linalg.norm(inward)
    x, y, z = place.tolist()
    proof, sampled, _ = gliding(robot, Scene.from_obstacles([rod(x, y, z, 0.0002)]), path, feeds)
    assert sampled[[0, -1]].min() > 0
    assert proof is not None
    assert sampled.min() < 0
    assert -robot.body_radii.max() <= proof.clearance <= 0


def test_a_motion_of_one_step_is_certified_for_what_it_is():
    robot = random_robot(np.random.default_rng(7), 3)
    scene = random_scene(np.random.default_rng(8), START - 0.3, START + 0.3)
    angles, feeds = np.full((1, 3, 2), 0.1), np.zeros(1)
    body = robot.joint_positions(angles, feeds) + START
    found = clearances(scene, robot, body)
    proof = certify(interpolated_motion(robot, BASE, feeds[:, None], angles), robot, scene, body, found, 1.0)
    assert proof == Certificate(float(found.min()), 0, int(found.argmin()), 0)


@pytest.mark.parametrize("spare", [1e-4, 3e-5])
def test_a_margin_that_is_kept_by_little_is_proven(spare):
    robot = random_robot(np.random.default_rng(5), 4)
    feeds, angles = np.linspace(0.0, 0.2, 60), np.zeros((60, 4, 2))
    body = robot.joint_positions(angles, feeds) + START
    scene = Scene.from_obstacles([rod(0.15, -0.2, 0.5, 0.004)])  # beside the arm, which slides past it
    found = clearances(scene, robot, body, 1.0)
    arguments = (interpolated_motion(robot, BASE, feeds[:, None], angles), robot, scene, body, found, 1.0)
    margin = float(found.min()) - spare
    assert certify(*arguments).clearance < margin
    assert margin <= certify(*arguments, margin).clearance <= found.min()


@given(seed=seeds, sections=st.integers(1, 5), kind=st.sampled_from(["drum", "carrier"]), turn=st.floats(0.01, 0.6))
def test_no_motion_on_a_base_that_turns_comes_closer_than_certified(seed, sections, kind, turn):
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, sections)
    axes = Rotation.random(rng=rng).as_matrix()
    angles = np.cumsum(rng.normal(0, 0.1, (4, sections, 2)), axis=0)
    if kind == "drum":
        base: Base = Drum(START, 0.2, 0.05, 2.0, axes)
        at = np.linspace(0.0, 0.2 * turn * 3, 4)[:, None]
    else:
        base = Carrier(START, 0.5, 0.1, 0.02, axes)
        turns = Rotation.from_rotvec(np.cumsum(rng.normal(0, turn / 2, (4, 3)), axis=0))
        at = np.concatenate([np.cumsum(rng.normal(0, 0.02, (4, 3)), axis=0), turns.as_quat(scalar_first=True)], axis=1)
        at[1:, 3:] *= np.cumprod(np.sign((at[1:, 3:] * at[:-1, 3:]).sum(axis=1)))[:, None]
    joints = joints_on(base, robot, angles, at)
    scene = random_scene(rng, joints.min(axis=(0, 1)), joints.max(axis=(0, 1)))
    found = clearances(scene, robot, joints, 1.0)
    proof = certify(interpolated_motion(robot, base, at, angles), robot, scene, joints, found, 1.0)
    where = between(at, PIECES) if kind == "drum" else _poses_between(at)
    dense = joints_on(base, robot, between(angles, PIECES), where)
    moved = float(np.linalg.norm(np.diff(dense, axis=0), axis=2).max())
    assert_sound_and_tight(proof, np.minimum(clearances(scene, robot, dense, 1.0), 1.0), np.array(moved))


def _poses_between(at: np.ndarray) -> np.ndarray:
    """Places on straight lines, turns at a steady rate: by SciPy."""
    steps = np.arange(len(at))
    turns = Slerp(steps, Rotation.from_quat(at[:, 3:], scalar_first=True))
    parts = between(steps.astype(float), PIECES)
    return np.concatenate([between(at[:, :3], PIECES), turns(parts).as_quat(scalar_first=True)], axis=1)
