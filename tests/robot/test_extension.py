"""Sections that change their length: where they end, how long cables are, and which files are refused."""

import numpy as np
import pytest
from extension_oracles import arcs_line, extending, posture, threaded
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from robot_oracles import robot_of
from section_makers import THIN, mixed, mixed_robot, of_kind

import hognose
from hognose.errors import InputError

seeds = st.integers(0, 2**32 - 1)
some = settings(deadline=None, max_examples=25)


@some
@given(seeds, st.integers(1, 5))
def test_joints_and_chords_are_those_of_arcs_of_these_lengths(seed, sections):
    rng = np.random.default_rng(seed)
    robot = extending(*[None] * sections)
    angles, lengths = posture(robot, rng)
    chords = int(mixed(robot).counts[0])
    points, frame = arcs_line(angles, lengths, chords)
    joints = robot.joint_positions(angles, 0.0, lengths)
    np.testing.assert_allclose(joints, points[::chords], rtol=0, atol=1e-13)
    np.testing.assert_allclose(robot.model.vertices(joints), points, rtol=0, atol=1e-13)
    np.testing.assert_allclose(robot.tip_pose(angles, 0.0, lengths)[:3, :3], frame, rtol=0, atol=1e-13)


@some
@given(seeds, st.booleans())
def test_joints_alone_say_angles_and_lengths(seed, straight):
    rng = np.random.default_rng(seed)
    robot = extending(None, 4, 7)
    poses = [posture(robot, rng, 0.0 if straight else 0.7) for _ in range(4)]
    angles, lengths = (np.array(each).reshape(2, 2, *each[0].shape) for each in zip(*poses, strict=True))
    joints = robot.joint_positions(angles, rng.uniform(-1, 1, (2, 2)), lengths)
    np.testing.assert_allclose(robot.angles(joints), angles, rtol=0, atol=1e-12)
    np.testing.assert_allclose(robot.section_lengths(joints), lengths, rtol=0, atol=1e-14)


@some
@given(seeds)
def test_the_body_stays_within_what_stands_for_it_at_any_length(seed):
    """Of the chords, no point of the arcs is farther than their thickness has it besides the section's radius."""
    rng = np.random.default_rng(seed)
    robot = extending(None, None, body_diameter=0.02, cable_radius=0.008)
    low, high = robot.length_bounds.T
    angles, lengths = robot.bend_bounds[..., 1] * rng.choice([-1.0, 1.0], (2, 2)), rng.choice([low, high])
    chords, fine = int(mixed(robot).counts[0]), 20
    vertices = robot.model.vertices(robot.joint_positions(angles, 0.0, lengths))
    points, _ = arcs_line(angles, lengths, chords * fine)
    along = np.repeat(np.diff(vertices, axis=0), fine, axis=0)
    beside = points[:-1] - np.repeat(vertices[:-1], fine, axis=0)
    part = (beside * along).sum(axis=1) / (along * along).sum(axis=1)
    away = np.linalg.norm(beside - part[:, None] * along, axis=1)
    thick = np.repeat(robot.chord_radii, fine) - 0.01
    assert (away <= thick + 1e-15).all()
    assert (lengths < high).any() or away.max() > 0.99 * thick.max()


@some
@given(seeds, st.integers(3, 9))
def test_cables_run_straight_from_hole_to_hole_of_the_disks_at_any_length(seed, disks):
    rng = np.random.default_rng(seed)
    robot = extending(disks, disks, disks)
    angles, lengths = posture(robot, rng)
    found = robot.cable_lengths(angles, lengths)
    np.testing.assert_allclose(found, threaded(robot, angles, lengths), rtol=0, atol=1e-14)


def test_without_disks_a_cable_is_as_much_longer_as_the_sections_it_passes():
    robot, rng = extending(None, None), np.random.default_rng(5)
    angles, lengths = posture(robot, rng)
    longer = robot.cable_lengths(angles, lengths) - robot.cable_lengths(angles)
    more = np.cumsum(lengths - 0.09)[robot.cable_sections]
    np.testing.assert_allclose(longer, more, rtol=0, atol=1e-15)


@some
@given(seeds, st.sampled_from([None, 3, 6]))
def test_cables_say_angles_and_lengths(seed, disks):
    rng = np.random.default_rng(seed)
    robot = extending(disks, None, disks)
    angles, lengths = (np.array(each) for each in zip(*(posture(robot, rng) for _ in range(5)), strict=True))
    cables = robot.cable_lengths(angles, lengths)
    np.testing.assert_allclose(robot.angles_from_cables(cables, 0.0 * angles), angles, rtol=0, atol=1e-11)
    np.testing.assert_allclose(robot.lengths_from_cables(cables, 0.0 * angles), lengths, rtol=0, atol=1e-13)


@some
@given(seeds)
def test_of_more_cables_than_three_the_shrunk_bend_and_length_fit_best(seed):
    """No bend and length near those found leaves a smaller sum of squares of the first section's own cables."""
    rng = np.random.default_rng(seed)
    robot = extending(None, cable_azimuths_deg=(0.0, 80.0, 170.0, 250.0))
    angles, lengths = posture(robot, rng)
    cables = robot.cable_lengths(angles, lengths) + rng.normal(0, 1e-3, 4)
    found = robot.angles_from_cables(cables[None], np.zeros((1, 1, 2)))[0]
    long = robot.lengths_from_cables(cables[None], np.zeros((1, 1, 2)))[0]

    def left(angles, long):
        return ((robot.cable_lengths(angles, long) - cables) ** 2).sum()

    best = left(found, long)
    for _ in range(20):
        assert left(found + rng.normal(0, 1e-3, (1, 2)), long + rng.normal(0, 1e-5, 1)) > best


def test_cables_that_no_bend_has_say_so_for_all_sections_behind():
    robot = extending(1, 1, bend_limit_deg=5.0)
    cables = robot.straight_cable_lengths + np.array([0.1, -0.05, -0.05, 0.0, 0.0, 0.0])
    assert np.isnan(robot.angles_from_cables(cables[None], np.zeros((1, 2, 2)))).all()
    assert np.isnan(robot.lengths_from_cables(cables[None], np.zeros((1, 2, 2)))).all()


def test_at_rest_an_arm_is_the_one_that_does_not_extend_and_counts_are_zero():
    rng = np.random.default_rng(3)
    able, fixed = extending(4, None, 3), extending(4, None, 3, length_range=None)
    angles = rng.uniform(-0.6, 0.6, (7, 3, 2))
    assert able.extends
    assert not fixed.extends
    for robot in (able, fixed):
        rest = np.broadcast_to(robot.link_lengths, (7, 3))
        np.testing.assert_array_equal(robot.joint_positions(angles), robot.joint_positions(angles, 0.0, rest))
        np.testing.assert_array_equal(robot.cable_lengths(angles), robot.cable_lengths(angles, rest))
        np.testing.assert_array_equal(fixed.joint_positions(angles), robot.joint_positions(angles))
        np.testing.assert_array_equal(fixed.cable_lengths(angles), robot.cable_lengths(angles))
        assert not robot.motor_counts(robot.straight_cable_lengths).any()
    assert able.fingerprint != fixed.fingerprint
    assert able.length == fixed.length
    np.testing.assert_array_equal(fixed.length_bounds, np.repeat(fixed.link_lengths[:, None], 2, axis=1))
    assert (able.length_bounds == (0.06, 0.13)).all()


def test_arms_that_do_not_extend_have_their_link_lengths():
    for robot in (hognose.load_robot("sjtu-25dof"), mixed_robot(4)):
        angles = np.random.default_rng(1).uniform(-0.3, 0.3, (5, robot.sections, 2))
        joints, rest = robot.joint_positions(angles), np.tile(robot.link_lengths, (5, 1))
        np.testing.assert_array_equal(robot.section_lengths(joints), rest)
        np.testing.assert_array_equal(robot.joint_positions(angles, 0.0, rest), joints)
        np.testing.assert_array_equal(robot.cable_lengths(angles, rest), robot.cable_lengths(angles))
        with pytest.raises(InputError, match=r"that do not extend always"):
            robot.joint_positions(angles, 0.0, rest * 1.01)
        with pytest.raises(InputError, match=r"that do not extend always"):
            robot.cable_lengths(angles, rest * 1.01)


@pytest.mark.parametrize(
    ("lengths", "said"),
    [([0.09, 0.09], "of shape"), ([[0.09] * 3] * 2, "as of angles"), ([0.09, 0.0, 0.09], "no length is 0 or less")],
)
def test_lengths_that_are_none_are_refused(lengths, said):
    robot = extending(None, None, None)
    for asked in (robot.joint_positions, lambda *given: robot.cable_lengths(given[0], given[2])):
        with pytest.raises(InputError, match=rf"^lengths: .*{said}"):
            asked(np.zeros((3, 2)), 0.0, lengths)


def test_only_the_sections_that_extend_have_other_lengths_in_a_mixed_arm():
    kinds = [of_kind("link", **THIN), of_kind("arc", length_range=(0.06, 0.12), **THIN), of_kind("hinges", **THIN)]
    robot, rng = robot_of(kinds, tool_length=0.02), np.random.default_rng(8)
    angles, lengths = rng.uniform(-0.4, 0.4, (3, 2)), robot.link_lengths + np.array([0.0, 0.02, 0.0])
    joints = robot.joint_positions(angles, 0.0, lengths)
    np.testing.assert_allclose(robot.section_lengths(joints), lengths, rtol=0, atol=1e-15)
    np.testing.assert_allclose(robot.angles(joints), angles, rtol=0, atol=1e-12)
    apart = [np.linalg.norm(np.diff(each, axis=0), axis=1) for each in (joints, robot.joint_positions(angles))]
    assert apart[0] / apart[1] == pytest.approx([1.0, lengths[1] / 0.091, 1.0], abs=1e-12)
    cables = robot.cable_lengths(angles, lengths)
    near = angles + rng.uniform(-0.05, 0.05, angles.shape)
    np.testing.assert_allclose(robot.angles_from_cables(cables[None], near[None])[0], angles, rtol=0, atol=1e-9)
    np.testing.assert_allclose(robot.lengths_from_cables(cables[None], near[None])[0], lengths, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"length_range": (0.1, 0.13)}, r"length_range \[100, 130\] mm does not hold the pitch of 90 mm"),
        ({"length_range": (0.13, 0.06)}, r"expected \[shortest, longest\] with the pitch between them"),
        ({"length_range": (0.09, 0.09)}, "leaves the section only one length"),
        (
            {"length_range": (0.014, 0.1)},
            "when it is shortest, to a radius of 14.2 mm, tighter than",
        ),
        (
            {"kind": "joints", "joints": 3},
            "length_range is for sections of kind 'arc', and this",
        ),
        ({"disks": 1, "length_range": (0.06, 0.5), "cable_radius": 0.0145, "bend_limit_deg": 20.0}, "disks = "),
    ],
)
def test_ranges_that_no_section_has_are_refused(changes, said):
    own = {"pitch": 0.09, "length_range": (0.06, 0.13), **THIN, **changes}
    with pytest.raises(ValidationError, match=said):
        robot_of([of_kind(own.pop("kind", "arc"), **own)])


def test_a_tool_on_a_section_that_extends_is_a_section_of_its_own():
    arc = of_kind("arc", pitch=0.09, length_range=(0.06, 0.13), **THIN)
    with pytest.raises(ValidationError, match="make tool_length 0, and describe the tool as a last section"):
        robot_of([arc], tool_length=0.02)
    assert robot_of([arc, of_kind("link", **THIN)], tool_length=0.02).extends


@pytest.mark.parametrize(
    ("group", "changes", "stepping"),
    [
        (0, {"passing_cable_radius": 0.011}, 11),
        (1, {"passing_cable_radius": 0.011}, 12),
        (1, {"cable_radius": 0.010}, None),
        (2, {"cable_radius": 0.010}, None),
        (2, {"passing_cable_radius": 0.011}, None),
    ],
)
def test_cables_that_come_to_disks_of_an_extending_section_from_another_circle_are_refused(group, changes, stepping):
    own = {"pitch": 0.09, "length_range": (0.06, 0.13), "disks": 5, **THIN}
    groups = [of_kind("link", **THIN), of_kind("arc", count=2, **own), of_kind("link", **THIN)]
    groups[group] = {**groups[group], **changes}
    if stepping is not None:
        with pytest.raises(
            ValidationError, match=f"disks of group 2, whose sections extend, from another circle, of {stepping} mm"
        ):
            robot_of(groups)
        groups[1] = {**groups[1], "disks": None}
    assert robot_of(groups).extends
