"""Sections of all kinds: where they end, which angles lead where, and what of the body is between."""

import math
from itertools import pairwise
from typing import Any

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robot_oracles import mjcf, robot_of, section
from section_makers import KINDS, dense_line, mixed, mixed_robot, of_kind

import hognose
from hognose.errors import InputError
from hognose.robot.sections import KINDS as MODELS
from hognose.robot.sections import LINK, RIGID_LINK, Geometry, MixedSections
from hognose.robot.sections.chain import BY_ALPHA, BY_BETA, END, ROWS, TURN_ALPHA, TURN_BETA, X, Y, Z, arc_terms, end_of

mj: Any = mujoco  # its names are made at run time
seeds = st.integers(0, 2**32 - 1)
some = settings(deadline=None, max_examples=25)
bends = st.floats(-1.2, 1.2)


def alone(kind, **changes):
    """The model of one section."""
    return MixedSections([MODELS[kind]], [geometry(**changes)], 0.0)


def geometry(pitch=0.1, joints=None, axis_offset=None, disks=None):
    return Geometry(pitch, 0.0, 0.0, 0.02, (0.7, 0.7), joints, axis_offset, disks)


def placed(model, angles):
    joints, frames = model.positions(np.ascontiguousarray(angles), np.zeros(len(angles)), np.empty(0))
    return joints[:, 1], frames


@some
@given(seeds)
def test_the_body_is_that_of_many_small_turns_and_steps(seed):
    rng = np.random.default_rng(seed)
    robot = mixed_robot(seed)
    angles = rng.uniform(-0.9, 0.9, (robot.sections, 2))
    points, ends, frame = dense_line(robot, angles, 50)
    np.testing.assert_allclose(robot.joint_positions(angles), points[ends], rtol=0, atol=1e-13)
    np.testing.assert_allclose(robot.tip_pose(angles)[:3, :3], frame, rtol=0, atol=1e-13)


@some
@given(bends, bends)
def test_an_arc_ends_where_the_closed_form_says(alpha, beta):
    ends, frames = placed(alone("arc"), np.array([[[alpha, beta]]]))
    bend, away = math.hypot(alpha, beta), np.linalg.norm(ends[0])
    half = math.sin(bend / 2) / (bend / 2) if bend else 1.0
    assert away == pytest.approx(0.1 * half, abs=1e-15)
    # The chord is turned by half of the bend, in the plane of both ends' directions.
    tangent = frames[0, :, 2]
    np.testing.assert_allclose(np.array([0, 0, 1]) + tangent, 2 * math.cos(bend / 2) * ends[0] / away, atol=1e-14)
    assert tangent[2] == pytest.approx(math.cos(bend), abs=1e-14)


@pytest.mark.parametrize("count", [1, 2, 3, 7, 30])
def test_a_stack_bent_about_one_axis_keeps_the_formula(count):
    """d = L sin(k θ/(k + 1)) / (k sin(θ/(k + 1))), and the end is turned by 2k θ/(k + 1)."""
    theta = np.linspace(0.05, 1.2, 9)
    bend = 2 * count * theta / (count + 1)
    for axis in (0, 1):
        angles = np.zeros((9, 1, 2))
        angles[:, 0, axis] = bend
        ends, frames = placed(alone("joints", joints=count), angles)
        said = 0.1 * np.sin(count * theta / (count + 1)) / (count * np.sin(theta / (count + 1)))
        np.testing.assert_allclose(np.linalg.norm(ends, axis=1), said, rtol=0, atol=1e-15)
        np.testing.assert_allclose(np.arccos(ends[:, 2] / said), theta, rtol=0, atol=1e-13)
        np.testing.assert_allclose(np.arccos(frames[:, 2, 2]), bend, rtol=0, atol=1e-12)


@some
@given(bends, bends)
def test_a_stack_of_one_joint_is_a_link(alpha, beta):
    angles = np.array([[[alpha, beta]]])
    joints, frames = RIGID_LINK.positions(angles, np.zeros(1), np.array([0.1]))
    for model in (alone("joints", joints=1), alone("link")):
        ends, turns = placed(model, angles)
        np.testing.assert_allclose(ends, joints[:, 1], rtol=0, atol=1e-16)
        np.testing.assert_allclose(turns, frames, rtol=0, atol=1e-15)


@settings(deadline=None, max_examples=8)
@given(bends, bends)
def test_a_stack_of_ever_more_joints_becomes_an_arc(alpha, beta):
    """The difference is a series in 1/k, of which four members are left out by those of four stacks."""
    angles, counts = np.array([[[alpha, beta]]]), 200 * 2 ** np.arange(4)
    found = [placed(alone("joints", joints=int(count)), angles) for count in counts]
    for which, expected in enumerate(placed(alone("arc"), angles)):
        values = [each[which] for each in found]
        assert np.abs(values[-1] - expected).max() <= 1e-3
        for power in range(1, 4):
            values = [(2**power * fine - coarse) / (2**power - 1) for coarse, fine in pairwise(values)]
        np.testing.assert_allclose(values[0], expected, rtol=0, atol=1e-9)


def test_arms_of_links_alone_keep_their_own_model():
    assert robot_of([section(count=3)]).model is RIGID_LINK
    assert robot_of([section(kind="link"), section(kind="joints", joints=1)]).model is RIGID_LINK
    assert not mixed_robot(1).straight_links
    for name in ("sjtu-25dof", "sjtu-25dof-99"):
        assert hognose.load_robot(name).straight_links


@pytest.mark.parametrize("kind", ["joints", "hinges"])
def test_mujoco_puts_the_tip_of_small_joints_there_too(kind):
    """The stack as an arm of so many links; two hinges as two joints of which each turns about one axis only."""
    robot = robot_of([of_kind(kind, bend_limit_deg=60.0, count=3)], tool_length=0.02)
    table = mixed(robot).table
    parts = [section(pitch=float(length), half_lengths=(0.0, 0.001), count=1) for length in table[:, 2]]
    chain = robot_of(parts)
    model = mj.MjModel.from_xml_string(mjcf(chain))
    data = mj.MjData(model)
    rng = np.random.default_rng(3)
    for _ in range(20):
        angles = rng.uniform(-1, 1, (3, 2))
        data.qpos[:] = (table[:, :2] * np.repeat(angles, len(table) // 3, axis=0)).ravel()
        mj.mj_forward(model, data)
        np.testing.assert_allclose(robot.joint_positions(angles)[-1], data.site("tip").xpos, rtol=0, atol=1e-14)
        turn = data.site("tip").xmat.reshape(3, 3)
        np.testing.assert_allclose(robot.tip_pose(angles)[:3, :3], turn, rtol=0, atol=1e-14)


def test_mujoco_bends_many_small_joints_almost_into_an_arc():
    count, length = 60, 0.3
    chain = robot_of([section(pitch=length / count, half_lengths=(0.0, 0.001), count=count)])
    model = mj.MjModel.from_xml_string(mjcf(chain))
    data = mj.MjData(model)
    arc = robot_of([of_kind("arc", pitch=length)])
    for alpha, beta in ((0.6, -0.5), (-0.2, 0.9), (1.0, 0.0)):
        data.qpos[:] = np.tile([alpha / count, beta / count], count)
        mj.mj_forward(model, data)
        off = np.linalg.norm(arc.joint_positions([[alpha, beta]])[-1] - data.site("tip").xpos)
        assert off <= length * math.hypot(alpha, beta) / count


@some
@given(seeds, st.sampled_from([1e-9, 1e-3, 0.5, 1.0]))
def test_angles_come_back_from_the_joints_they_make(seed, share):
    rng = np.random.default_rng(seed)
    robot = mixed_robot(seed)
    angles = rng.uniform(-1.2 * share, 1.2 * share, (6, robot.sections, 2))
    joints = robot.joint_positions(angles, 0.3)
    np.testing.assert_allclose(robot.angles(joints), angles, rtol=0, atol=1e-12)
    np.testing.assert_allclose(robot.angles(joints + 0.7), angles, rtol=0, atol=1e-12)


@some
@given(seeds)
def test_an_arc_is_found_in_every_quadrant_however_far_it_is_bent(seed):
    rng = np.random.default_rng(seed)
    direction, bend = rng.uniform(-math.pi, math.pi, (20, 1)), rng.uniform(0, 6.0, (20, 1))
    angles = np.concatenate([bend * np.cos(direction), bend * np.sin(direction)], axis=1)[:, None]
    joints, _ = alone("arc").positions(angles, np.zeros(20), np.empty(0))
    np.testing.assert_allclose(alone("arc").angles(joints), angles, rtol=0, atol=1e-9)


@some
@given(seeds)
def test_a_link_among_others_is_found_in_every_quadrant(seed):
    rng = np.random.default_rng(seed)
    robot = robot_of([of_kind("arc"), of_kind("link"), of_kind("joints")])
    angles = rng.uniform(-1, 1, (20, 3, 2)) * np.array([[0.5, 0.5], [math.pi - 1e-6, 1.5], [0.5, 0.5]])
    np.testing.assert_allclose(robot.angles(robot.joint_positions(angles)), angles, rtol=0, atol=1e-11)


def test_a_section_that_ends_where_it_begins_has_no_angles():
    robot = mixed_robot(4)
    joints = robot.joint_positions(np.zeros((2, robot.sections, 2)))
    joints[1, 3] = joints[1, 2]
    with pytest.raises(InputError, match="section 3 has no angles at step 1"):
        robot.angles(joints)


@pytest.mark.parametrize("kind", KINDS)
def test_derivatives_of_the_end_agree_with_differences(kind):
    rng, step = np.random.default_rng(7), 1e-6
    model = mixed(robot_of([of_kind("arc"), of_kind(kind)], tool_length=0.03))
    low, high = model.first[1:].tolist()

    def end(alpha, beta):
        out = np.empty((ROWS, 3))
        end_of(model.table, low, high, alpha, beta, out)
        return out

    for alpha, beta in [(0.0, 0.0), (1e-5, -1e-4), *rng.uniform(-1.5, 1.5, (20, 2))]:
        out = end(alpha, beta)
        for by, turn, sides in (
            (BY_ALPHA, TURN_ALPHA, (end(alpha + step, beta), end(alpha - step, beta))),
            (BY_BETA, TURN_BETA, (end(alpha, beta + step), end(alpha, beta - step))),
        ):
            slope = (sides[0] - sides[1]) / (2 * step)
            np.testing.assert_allclose(out[by], slope[END], rtol=0, atol=1e-10)
            for axis in (X, Y, Z):
                np.testing.assert_allclose(np.cross(out[turn], out[axis]), slope[axis], rtol=0, atol=1e-9)


@pytest.mark.parametrize("t", [0.05, 0.1 - 1e-9, 0.1 + 1e-9, 1.0, 9.0, 30.0])
def test_terms_of_an_arc_agree_with_closed_forms_on_both_sides_of_the_series_end(t):
    def first(t):
        return 2 * math.sin(math.sqrt(t) / 2) ** 2 / t

    def second(t):
        return math.sin(math.sqrt(t)) / math.sqrt(t)

    angle, step = math.sqrt(t), 1e-5
    third = (angle - math.sin(angle)) / angle**3
    slopes = [(term(t + step) - term(t - step)) / (2 * step) for term in (first, second)]
    found = arc_terms(t)
    np.testing.assert_allclose(found[:3], [first(t), second(t), third], rtol=1e-12)
    np.testing.assert_allclose(found[3:], slopes, rtol=1e-7, atol=1e-11)


def test_terms_of_an_arc_begin_with_their_limits():
    assert arc_terms(0.0) == (1 / 2, 1.0, 1 / 6, -1 / 24, -1 / 6)


@some
@given(seeds)
def test_the_centre_line_is_within_the_sagitta_of_the_chords(seed):
    rng = np.random.default_rng(seed)
    robot = mixed_robot(seed)
    limits = robot.bend_limits
    angles = np.where(rng.random((robot.sections, 1)) < 0.5, 1.0, rng.uniform(-1, 1, limits.shape)) * limits
    joints = robot.joint_positions(angles)
    line, model = robot.model.vertices(joints), mixed(robot)
    assert len(line) == len(robot.chord_radii) + 1 == model.counts.sum() + 1
    at_joints = np.append(0, np.cumsum(model.chords))
    np.testing.assert_array_equal(line[at_joints], joints)
    points, _, _ = dense_line(robot, angles, int(4 * np.lcm.reduce(model.counts)))
    owner = np.repeat(np.arange(len(model.table)), (len(points) - 1) // len(model.table))
    within = np.concatenate([np.arange(n) for n in np.bincount(owner)]) / np.bincount(owner)[owner]
    chord = np.append(0, np.cumsum(model.counts))[owner] + np.floor(within * model.counts[owner]).astype(int)
    for k in range(len(line) - 1):
        beside = points[:-1][chord == k] - line[k]
        along = line[k + 1] - line[k]
        part = np.clip(beside @ along / (along @ along), 0, 1)
        away = np.linalg.norm(beside - part[:, None] * along, axis=1).max()
        left = model.sagitta(robot.link_lengths, limits)[k]
        assert away <= left + 1e-13
        if left and (np.abs(angles[robot.chord_sections[k]]) == limits[robot.chord_sections[k]]).all():
            assert away >= 0.99 * left


@some
@given(seeds)
def test_arcs_of_chords_are_the_length_of_the_arm(seed):
    robot = mixed_robot(seed)
    arcs = robot.model.arcs(robot.link_lengths)
    np.testing.assert_allclose(np.bincount(robot.chord_sections, arcs), robot.link_lengths, rtol=1e-14)
    straight = robot.model.vertices(robot.joint_positions(np.zeros((robot.sections, 2))))
    np.testing.assert_allclose(np.diff(straight[:, 2]), arcs, rtol=0, atol=1e-15)


def test_every_kind_answers_by_its_name():
    assert list(MODELS) == list(KINDS)
    assert all(model.name == name for name, model in MODELS.items())
    assert LINK.pieces(geometry()) == ((1.0, 1.0, 0.1, False),)


def test_the_arm_of_two_hinges_is_as_published():
    """github.com/OceanYv/snake_arm_ctrl; as one universal joint a section's end would be off by 31.6 mm."""
    arm = hognose.load_robot("zju-24cable")
    angles = np.zeros((8, 2))
    angles[0] = math.radians(30)
    end = arm.joint_positions(angles)[1]
    links = robot_of([section(pitch=0.15, bend_limit_deg=30.0)])
    assert np.linalg.norm(end - links.joint_positions(angles[:1])[1]) == pytest.approx(31.6e-3, abs=5e-5)
    np.testing.assert_allclose(arm.link_lengths, [0.15] * 7 + [0.175], rtol=1e-15)
    assert np.degrees(arm.bend_limits).round(9).tolist() == [[30.0, 30.0]] * 8
    turn = [math.hypot(0.006, math.pi * (drum + 0.0025)) for drum in (0.027, 0.039, 0.055, 0.067, 0.067, 0.067, 0.064)]
    counts = np.array([25, 28, 28, 25, 16, 7, 4]) * 36_000
    np.testing.assert_allclose(arm.travel_per_count[:-3:3], turn / counts, rtol=3e-4)
    around = np.degrees(arm.cable_azimuths.reshape(8, 3))
    np.testing.assert_allclose(np.diff(around, axis=0), 15.0, atol=1e-9)
    np.testing.assert_allclose(np.diff(around, axis=1), 120.0, atol=1e-9)
