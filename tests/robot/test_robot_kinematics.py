import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robot_oracles import (
    BUNDLED,
    frames,
    product_of_exponentials,
    random_angles,
    robot_of,
    section,
    tapered_robot,
)
from scipy.spatial.transform import Rotation

import hognose
from hognose.errors import InputError

seeds = st.integers(0, 2**32 - 1)
many = settings(deadline=None, max_examples=40)
few = settings(deadline=None, max_examples=8)


@pytest.fixture(scope="module")
def arm():
    return hognose.load_robot("sjtu-25dof")


@few
@given(seeds, st.floats(-0.5, 1.0))
def test_tip_pose_is_the_papers_product_of_exponentials(seed, feed):
    arm = hognose.load_robot("sjtu-25dof")
    angles = random_angles(arm, np.random.default_rng(seed), share=2.5)
    pitch, n = 0.091, arm.sections
    heights = pitch * np.arange(n)  # table 1: (i - 1)(2h + L)
    pose = product_of_exponentials(angles, heights, n * pitch)
    pose[2, 3] += feed
    np.testing.assert_allclose(arm.tip_pose(angles, feed), pose, atol=2e-14)
    # The paper's own frame ends at the last joint, (n - 1)(2h + L): the joint before our nose.
    last_joint = product_of_exponentials(angles, heights, (n - 1) * pitch)
    np.testing.assert_allclose(arm.joint_positions(angles)[-2], last_joint[:3, 3], atol=2e-14)


@few
@given(seeds)
def test_tip_pose_is_the_product_of_exponentials_for_any_pitches_and_tool(seed):
    arm = tapered_robot(seed)
    angles = random_angles(arm, np.random.default_rng(seed), share=2)
    heights = np.append(0.0, np.cumsum(arm.link_lengths))
    expected = product_of_exponentials(angles, heights[:-1], heights[-1])
    np.testing.assert_allclose(arm.tip_pose(angles), expected, atol=2e-14)


@many
@given(seeds)
def test_joint_positions_are_those_of_a_plain_chain_of_rotations(seed):
    rng = np.random.default_rng(seed)
    arm = tapered_robot(seed, sections=int(rng.integers(1, 15)))
    angles, feed = rng.uniform(-np.pi, np.pi, (arm.sections, 2)), rng.uniform(-1, 1)
    places, turns = frames(arm, angles, feed)
    np.testing.assert_allclose(arm.joint_positions(angles, feed), places, atol=1e-14)
    pose = arm.tip_pose(angles, feed)
    np.testing.assert_allclose(pose[:3, :3], turns[-1], atol=1e-14)
    np.testing.assert_array_equal(pose[:3, 3], arm.joint_positions(angles, feed)[-1])
    np.testing.assert_array_equal(pose[3], [0, 0, 0, 1])


def test_scipys_intrinsic_rotations_give_the_same_orientation(arm):
    angles = random_angles(arm, np.random.default_rng(3), share=3)
    turn = Rotation.identity()
    for alpha, beta in angles:
        turn = turn * Rotation.from_euler("YX", [alpha, beta])
    np.testing.assert_allclose(arm.tip_pose(angles)[:3, :3], turn.as_matrix(), atol=1e-14)


@many
@given(seeds, st.sampled_from([0.1, 1.0, 10.0]))
def test_links_keep_their_length_whatever_the_angles(seed, size):
    arm = tapered_robot(seed)
    angles = size * np.random.default_rng(seed).normal(size=(20, arm.sections, 2))
    links = np.linalg.norm(np.diff(arm.joint_positions(angles, 0.3), axis=1), axis=2)
    np.testing.assert_allclose(links, np.broadcast_to(arm.link_lengths, links.shape), rtol=0, atol=1e-14)


@many
@given(seeds, st.sampled_from([1e-9, 1e-3, 0.5, 1.0]))
def test_angles_come_back_from_the_joints_they_make(seed, share):
    rng = np.random.default_rng(seed)
    arm = tapered_robot(seed)
    angles = random_angles(arm, rng, (8,), share)
    np.testing.assert_allclose(arm.angles(arm.joint_positions(angles, 0.2)), angles, rtol=0, atol=2e-14)


@many
@given(seeds)
def test_angles_come_back_in_every_quadrant_of_alpha_and_almost_to_a_right_angle_of_beta(seed):
    rng = np.random.default_rng(seed)
    arm = tapered_robot(seed)
    angles = rng.uniform(-1, 1, (8, arm.sections, 2)) * np.array([np.pi - 1e-6, 1.0])
    angles[:, rng.integers(arm.sections), 1] = rng.choice([-1, 1], 8) * (np.pi / 2 - 1e-3)
    # 1 mrad from the pole alpha is known a thousand times worse than the joints are, and the frame turns with it.
    np.testing.assert_allclose(arm.angles(arm.joint_positions(angles)), angles, rtol=0, atol=1e-9)


@pytest.mark.parametrize("beta", [np.pi / 2, -np.pi / 2, np.pi / 2 - 1e-9, 1e-9 - np.pi / 2])
def test_at_the_pole_the_angles_still_make_the_same_joints(beta):
    arm = robot_of([section(count=5)])
    angles = np.random.default_rng(0).uniform(-0.4, 0.4, (5, 2))
    angles[2, 1] = beta
    joints = arm.joint_positions(angles)
    np.testing.assert_allclose(arm.joint_positions(arm.angles(joints)), joints, rtol=0, atol=1e-14)


@few
@given(seeds)
def test_any_joints_at_all_are_met_by_their_angles(seed):
    rng = np.random.default_rng(seed)
    arm = tapered_robot(seed)
    directions = rng.normal(size=(5, arm.sections, 3))
    steps = directions / np.linalg.norm(directions, axis=2)[..., None] * arm.link_lengths[:, None]
    joints = np.concatenate([np.zeros((5, 1, 3)), np.cumsum(steps, axis=1)], axis=1)
    angles = arm.angles(joints)
    np.testing.assert_allclose(arm.joint_positions(angles), joints, rtol=0, atol=1e-13)
    assert (np.abs(angles[..., 0]) <= np.pi).all()
    assert (np.abs(angles[..., 1]) <= np.pi / 2).all()


@few
@given(seeds)
def test_angles_know_nothing_of_where_the_arm_is_nor_of_the_length_of_its_links(seed):
    rng = np.random.default_rng(seed)
    arm = tapered_robot(seed)
    angles = random_angles(arm, rng, (4,))
    joints = arm.joint_positions(angles)
    np.testing.assert_allclose(arm.angles(joints + rng.uniform(-5, 5, 3)), angles, rtol=0, atol=1e-12)
    np.testing.assert_allclose(arm.angles(7 * joints), angles, rtol=0, atol=2e-14)
    np.testing.assert_allclose(arm.joint_positions(angles, 0.7), joints + np.array([0, 0, 0.7]), rtol=0, atol=1e-14)


@pytest.mark.parametrize("leading", [(), (1,), (6,), (2, 3), (2, 0), (0,)])
def test_every_answer_has_the_leading_axes_of_the_question(arm, leading):
    rng = np.random.default_rng(1)
    angles = random_angles(arm, rng, leading)
    feeds = rng.uniform(0, 1, leading)
    joints, poses = arm.joint_positions(angles, feeds), arm.tip_pose(angles, feeds)
    cables = arm.cable_lengths(angles)
    assert joints.shape == (*leading, 13, 3)
    assert poses.shape == (*leading, 4, 4)
    assert cables.shape == arm.motor_counts(cables).shape == (*leading, 36)
    assert arm.angles(joints).shape == (*leading, 12, 2)
    for index in np.ndindex(leading):
        np.testing.assert_array_equal(joints[index], arm.joint_positions(angles[index], feeds[index]))
        np.testing.assert_array_equal(poses[index], arm.tip_pose(angles[index], feeds[index]))
        np.testing.assert_array_equal(cables[index], arm.cable_lengths(angles[index]))
        np.testing.assert_array_equal(arm.angles(joints)[index], arm.angles(joints[index]))


def test_one_feed_serves_all_steps_and_feeds_broadcast(arm):
    angles = random_angles(arm, np.random.default_rng(1), (2, 3))
    np.testing.assert_array_equal(arm.joint_positions(angles, 0.2), arm.joint_positions(angles, np.full((2, 3), 0.2)))
    feeds = [0.1, 0.2, 0.3]
    np.testing.assert_array_equal(arm.joint_positions(angles, feeds)[:, :, 0, 2], [feeds, feeds])


def test_memory_layout_and_integer_angles_do_not_matter(arm):
    angles = random_angles(arm, np.random.default_rng(1), (6,))
    joints = arm.joint_positions(angles)
    turned = np.asfortranarray(angles)
    np.testing.assert_array_equal(arm.joint_positions(turned), joints)
    np.testing.assert_array_equal(arm.cable_lengths(turned), arm.cable_lengths(angles))
    np.testing.assert_array_equal(arm.angles(np.asfortranarray(joints)), arm.angles(joints))
    whole = np.ones((12, 2), int)
    np.testing.assert_array_equal(arm.joint_positions(whole.tolist()), arm.joint_positions(whole * 1.0))


@pytest.mark.parametrize("name", BUNDLED)
def test_the_straight_arm_lies_along_z(name):
    arm = hognose.load_robot(name)
    joints = arm.joint_positions(np.zeros((arm.sections, 2)), 0.25)
    assert not joints[:, :2].any()
    np.testing.assert_allclose(joints[:, 2], 0.25 + np.append(0, np.cumsum(arm.link_lengths)), atol=1e-15)
    assert not arm.angles(joints).any()
    assert joints[-1, 2] == pytest.approx(0.25 + arm.length, abs=1e-15)


def test_signs_are_those_of_the_conventions(arm):
    angles = np.zeros((2, 12, 2))
    angles[0, 4, 0] = angles[1, 4, 1] = 0.3
    by_alpha, by_beta = arm.joint_positions(angles)
    assert (by_alpha[5:, 0] > 0.02).all()  # R_y turns z towards +x
    assert (by_beta[5:, 1] < -0.02).all()  # R_x turns z towards -y
    assert not by_alpha[:, 1].any()
    assert not by_beta[:, 0].any()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda arm: arm.angles(np.zeros((12, 3))), ["joints", "(..., 13, 3)", "(12, 3)"]),
        (lambda arm: arm.angles(np.full((13, 3), np.nan)), ["joints", "39", "not finite"]),
        (lambda arm: arm.angles("here"), ["joints", "numbers"]),
        (lambda arm: arm.joint_positions(np.zeros((11, 2))), ["angles", "(..., 12, 2)", "(11, 2)"]),
        (lambda arm: arm.joint_positions(np.zeros(2)), ["angles", "(..., 12, 2)"]),
        (lambda arm: arm.joint_positions(np.zeros((12, 2)), np.inf), ["feed", "not finite"]),
        (lambda arm: arm.joint_positions(np.zeros((4, 12, 2)), [1, 2, 3]), ["feed", "(3,)", "(4,)"]),
        (lambda arm: arm.tip_pose(np.full((12, 2), np.inf)), ["angles", "24", "not finite"]),
        (lambda arm: arm.cable_lengths(np.zeros((12, 3))), ["angles", "(..., 12, 2)", "(12, 3)"]),
        (lambda arm: arm.cable_lengths([[0.0], [0.0, 1.0]]), ["angles", "numbers"]),
        (lambda arm: arm.motor_counts(np.zeros(35)), ["cable_lengths", "36", "(35,)"]),
        (lambda arm: arm.motor_counts(np.full(36, np.nan)), ["cable_lengths", "36", "not finite"]),
    ],
)
def test_wrong_input_is_named_with_what_was_expected_and_found(arm, call, words):
    with pytest.raises(InputError) as caught:
        call(arm)
    for word in words:
        assert word in str(caught.value)


def test_joints_that_coincide_are_the_users_mistake(arm):
    joints = arm.joint_positions(np.zeros((2, 12, 2)))
    joints[1, 7] = joints[1, 6]
    with pytest.raises(InputError):
        arm.angles(joints)
