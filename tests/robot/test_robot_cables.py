import math
from typing import Any

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robot_oracles import (
    BUNDLED,
    DRUM,
    SCREW,
    cable_lengths,
    mjcf,
    random_angles,
    robot_of,
    section,
    tapered_robot,
)

import hognose
from hognose.errors import InputError
from hognose.robot.spec import Transmission

mj: Any = mujoco  # its names are made at run time
seeds = st.integers(0, 2**32 - 1)
some = settings(deadline=None, max_examples=40)


@pytest.fixture(scope="module", params=[*BUNDLED, "tapered 1", "tapered 2"])
def robot(request):
    name = request.param
    return tapered_robot(int(name[-1])) if name.startswith("tapered") else hognose.load_robot(name)


@pytest.fixture(scope="module", params=["casia-coiled", "changing 1", "changing 2"])
def changing(request):
    """Arms whose cables change their circles on the way."""
    name = request.param
    return tapered_robot(int(name[-1]), passing=True) if name.startswith("changing") else hognose.load_robot(name)


def test_cable_lengths_are_mujocos_tendon_lengths(robot):
    assert_mujoco_agrees(robot)


def test_cable_lengths_are_mujocos_tendon_lengths_where_circles_change(changing):
    assert not changing.plain_cables
    assert_mujoco_agrees(changing)


def assert_mujoco_agrees(robot):
    model = mj.MjModel.from_xml_string(mjcf(robot))
    data = mj.MjData(model)
    angles = random_angles(robot, np.random.default_rng(5), (40,), 1.5)
    angles[0] = 0.0
    lengths, joints = robot.cable_lengths(angles), robot.joint_positions(angles)
    for row, (cables, places) in enumerate(zip(lengths, joints, strict=True)):
        data.qpos[:] = angles[row].ravel()
        mj.mj_forward(model, data)
        np.testing.assert_allclose(cables, data.ten_length, rtol=0, atol=1e-13)
        # The same model is a third opinion on the joints.
        np.testing.assert_allclose(places[:-1], data.xpos[1:], rtol=0, atol=1e-13)
        np.testing.assert_allclose(places[-1], data.site("tip").xpos, rtol=0, atol=1e-13)


@some
@given(seeds, st.integers(1, 9), st.floats(0, 3), st.booleans())
def test_cable_lengths_are_the_distances_between_holes_in_space(seed, sections, share, passing):
    arm = tapered_robot(seed, sections, passing)
    angles = random_angles(arm, np.random.default_rng(seed), share=share)
    np.testing.assert_allclose(arm.cable_lengths(angles), cable_lengths(arm, angles), rtol=0, atol=1e-14)


def test_the_straight_arm_has_cables_of_the_summed_distances(robot):
    pitches = robot.link_lengths.copy()
    pitches[-1] -= robot.spec.tool_length
    ends = np.cumsum(pitches) - np.append(robot.joint_before[1:], robot.joint_before[-1])
    expected = robot.joint_before[0] + ends[robot.cable_sections]
    np.testing.assert_allclose(robot.straight_cable_lengths, expected, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(robot.cable_lengths(np.zeros((robot.sections, 2))), robot.straight_cable_lengths)


def test_small_angles_change_lengths_by_minus_r_times_alpha_cos_less_beta_sin(robot):
    step, n = 1e-5, robot.sections
    moved = np.concatenate([np.eye(2 * n), -np.eye(2 * n)]).reshape(-1, n, 2) * step
    forward, backward = np.split(robot.cable_lengths(moved), 2)
    slopes = ((forward - backward) / (2 * step)).reshape(n, 2, robot.cables)
    passes = np.arange(n)[:, None] <= robot.cable_sections
    by_alpha = np.where(passes, -robot.cable_radii * np.cos(robot.cable_azimuths), 0.0)
    by_beta = np.where(passes, robot.cable_radii * np.sin(robot.cable_azimuths), 0.0)
    np.testing.assert_allclose(slopes, np.stack([by_alpha, by_beta], axis=1), rtol=0, atol=2e-10)


@some
@given(seeds)
def test_a_joint_beyond_a_cables_end_does_not_move_it_and_every_joint_before_does(seed):
    arm = tapered_robot(seed)
    rng = np.random.default_rng(seed)
    angles = random_angles(arm, rng)
    joint = int(rng.integers(arm.sections))
    other = angles.copy()
    other[joint] = random_angles(arm, rng)[joint]
    moved = arm.cable_lengths(angles) != arm.cable_lengths(other)
    np.testing.assert_array_equal(moved, arm.cable_sections >= joint)


@some
@given(st.floats(-math.radians(25), math.radians(25)), st.floats(-math.radians(25), math.radians(25)))
def test_turning_the_arm_and_its_holes_together_changes_nothing(alpha, beta):
    # A quarter turn about z takes a bend about y into the opposite bend about x, and moves every hole by 90°.
    here = robot_of([section(cable_azimuths_deg=(10.0, 100.0, 230.0))])
    there = robot_of([section(cable_azimuths_deg=(100.0, 190.0, 320.0))])
    np.testing.assert_allclose(
        here.cable_lengths([[alpha, 0.0]]), there.cable_lengths([[0.0, -alpha]]), rtol=0, atol=1e-15
    )
    # Mirrored in the x-z plane, beta and the azimuths change their signs.
    mirrored = robot_of([section(cable_azimuths_deg=(-10.0, -100.0, -230.0))])
    np.testing.assert_allclose(
        here.cable_lengths([[alpha, beta]]), mirrored.cable_lengths([[alpha, -beta]]), rtol=0, atol=1e-15
    )


def test_the_three_cables_of_a_section_do_not_keep_their_sum():
    arm = hognose.load_robot("sjtu-25dof")
    angles = np.zeros((4, 12, 2))
    angles[:, 0] = np.radians([[20, 20], [20, -20], [-20, 20], [-20, -20]])
    first = arm.cable_sections == 0
    sums = (arm.cable_lengths(angles) - arm.straight_cable_lengths)[:, first].sum(axis=1)
    assert (sums < -1.2e-3).all()
    assert (sums > -1.8e-3).all()
    # One after the other, every section of the same bend takes its share.
    bent = np.tile(np.radians([20, 20]), (12, 1))
    changes = (arm.cable_lengths(bent) - arm.straight_cable_lengths).reshape(12, 3).sum(axis=1)
    assert (np.diff(changes) < 0).all()


def test_counts_are_zero_for_the_straight_arm(robot):
    counts = robot.motor_counts(robot.straight_cable_lengths)
    assert counts.dtype == np.int64
    assert not counts.any()


@some
@given(seeds)
def test_counts_are_travel_rounded_to_the_nearest_count_and_positive_pays_out(seed):
    arm = tapered_robot(seed)
    rng = np.random.default_rng(seed)
    lengths = arm.cable_lengths(random_angles(arm, rng, (5,)))
    travel = lengths - arm.straight_cable_lengths
    counts = arm.motor_counts(lengths)
    # Half a count, and what rounding of a length of decimetres leaves.
    assert (np.abs(counts * arm.travel_per_count - travel) <= 0.5 * arm.travel_per_count + 1e-15).all()
    wanted = rng.integers(-(10**6), 10**6, arm.cables)
    exact = arm.straight_cable_lengths + wanted * arm.travel_per_count
    np.testing.assert_array_equal(arm.motor_counts(exact), wanted)
    np.testing.assert_array_equal(arm.motor_counts(exact + 0.49 * arm.travel_per_count), wanted)
    np.testing.assert_array_equal(arm.motor_counts(exact - 0.49 * arm.travel_per_count), wanted)
    np.testing.assert_array_equal(arm.motor_counts(exact + 0.51 * arm.travel_per_count), wanted + 1)


def test_counts_that_a_number_does_not_hold_exactly_are_refused():
    fine = {"screw_lead": 0.001, "gear_ratio": 100.0, "counts_per_turn": 10_000_000}  # 1e-12 m a count
    arm = robot_of([section(transmission=SCREW), section(transmission=fine)])
    straight = arm.straight_cable_lengths
    np.testing.assert_array_equal(arm.motor_counts(straight + 9000.0)[3:], round(9000.0 / 1e-12))
    with pytest.raises(InputError, match=r"9999 m of cable 4 are 1e\+16 counts of its motor"):
        arm.motor_counts(np.stack([straight, np.full(6, 9999.0)]))
    for length in (1e300, 1.7e308, -1e300):
        with pytest.raises(InputError, match="none beyond 10,000 m"):
            arm.motor_counts(np.full(6, length))


def test_one_turn_of_a_screw_or_drum_behind_its_gear_moves_the_cable_by_its_lead_or_girth():
    arm = robot_of([section(transmission=SCREW), section(transmission=DRUM)])
    turns = np.array([4.8 * 2000] * 3 + [25 * 65536] * 3)
    travel = np.array([0.004] * 3 + [math.pi * 0.027] * 3)
    np.testing.assert_array_equal(arm.motor_counts(arm.straight_cable_lengths + travel), turns)
    np.testing.assert_array_equal(arm.motor_counts(arm.straight_cable_lengths - travel), -turns)
    assert Transmission(**SCREW).travel_per_count == pytest.approx(0.004 / 9600, rel=1e-15)
    assert Transmission(**DRUM).travel_per_count == pytest.approx(math.pi * 0.027 / (25 * 65536), rel=1e-15)


@settings(deadline=None, max_examples=10)
@given(seeds)
def test_angles_come_back_from_cables_that_change_their_circles(seed):
    arm, rng = tapered_robot(seed, passing=True), np.random.default_rng(seed)
    angles = random_angles(arm, rng, (3,))
    found = arm.angles_from_cables(arm.cable_lengths(angles), angles + rng.uniform(-0.1, 0.1, angles.shape))
    np.testing.assert_allclose(found, angles, rtol=0, atol=1e-9)


def test_a_passing_circle_that_is_the_cables_own_changes_nothing():
    arm = hognose.load_robot("sjtu-25dof")
    spec = arm.spec.model_copy(
        update={"section": tuple(g.model_copy(update={"passing_cable_radius": 0.019}) for g in arm.spec.section)}
    )
    other = hognose.robot.Robot.from_spec(spec)
    angles = random_angles(arm, np.random.default_rng(0), (20,))
    assert other.plain_cables
    np.testing.assert_array_equal(other.cable_lengths(angles), arm.cable_lengths(angles))
    assert other.fingerprint != arm.fingerprint  # what the file says of its disks is another thing


def test_a_distal_cable_changes_by_the_circle_of_the_disk_it_passes():
    """Joint 1 of the coiled arm at 20 degrees, hole planes 10 mm on either side: 12.46 mm, not the 8.12 of its own."""
    angles = np.array([[math.radians(20), 0.0], [0.0, 0.0]])
    for passing, change in ((0.035, 12.46), (None, 8.12)):
        first = section(
            body_diameter=0.078, cable_radius=0.035, passing_cable_radius=passing, half_lengths=(0.01, 0.01)
        )
        second = section(body_diameter=0.05, cable_radius=0.0225, cable_azimuths_deg=(0, 120, 240))
        arm = robot_of([first, second])
        radius = passing or 0.0225
        pulled = arm.straight_cable_lengths - arm.cable_lengths(angles)
        assert 1e3 * pulled[3] == pytest.approx(change, abs=5e-3)
        # From the planes 10 mm before and behind it, in the joint's plane of bending.
        c, s = math.cos(angles[0, 0]), math.sin(angles[0, 0])
        way = math.hypot(c * radius + 0.01 * s - radius, 0.01 * c - s * radius + 0.01)
        assert pulled[3] == pytest.approx(0.02 - way, abs=1e-16)
