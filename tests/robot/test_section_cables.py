"""Cables through sections of all kinds: lengths, angles that belong to lengths, and motor counts."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robot_oracles import circle, robot_of, section
from scipy.spatial.transform import Rotation
from section_makers import dense_line, mixed, mixed_robot, of_kind, stretched

from hognose.robot.sections import KINDS as MODELS
from hognose.robot.sections import Geometry

seeds = st.integers(0, 2**32 - 1)
some = settings(deadline=None, max_examples=20)


def through(
    kind, angles, azimuths=(0.3, 2.0, 4.5), radius=0.019, before=0.0, after=0.0, pitch=0.091, entering=None, **keys
):
    given_keys = {"joints": None, "axis_offset": None, "disks": None} | keys
    shape = Geometry(pitch, before, after, 0.02, (0.7, 0.7), **given_keys)
    around = np.array(azimuths)
    rest = np.full(len(around), radius), np.cos(around), np.sin(around), np.full(len(around), entering or radius)
    return MODELS[kind].cables(shape, np.atleast_2d(angles), *rest)


def poses_along_arc(alpha, beta, length, count):
    """Places (count+1, 3) and rotations of disks at equal distances on an arc."""
    parts = np.arange(count + 1) / count
    turns = Rotation.from_rotvec(parts[:, None] * np.array([beta, alpha, 0.0]))
    bend = math.hypot(alpha, beta)
    side = np.array([alpha, -beta, 0.0]) / bend
    around = parts[:, None] * bend
    return length / bend * ((1 - np.cos(around)) * side + np.sin(around) * np.array([0, 0, 1.0])), turns


@some
@given(st.floats(-1.2, 1.2), st.floats(0.05, 1.2), st.integers(1, 9), st.sampled_from([0.019, 0.008, 0.024]))
def test_cables_between_disks_of_an_arc_are_the_distances_of_their_holes(alpha, beta, disks, entering):
    places, turns = poses_along_arc(alpha, beta, 0.091, disks)
    found = through("arc", (alpha, beta), disks=disks, entering=entering)[0]
    for length, azimuth in zip(found, (0.3, 2.0, 4.5), strict=True):
        off = np.outer([entering, *[0.019] * disks], [math.cos(azimuth), math.sin(azimuth), 0.0])
        holes = places + turns.apply(off)
        expected = np.linalg.norm(np.diff(holes, axis=0), axis=1).sum() - 0.091
        assert length == pytest.approx(expected, abs=1e-15)


@some
@given(st.floats(-1.2, 1.2), st.floats(0.05, 1.2))
def test_cables_of_an_arc_without_disks_are_those_of_ever_more_disks(alpha, beta):
    smooth, few, many = (through("arc", (alpha, beta), disks=d) for d in (None, 50, 100))
    np.testing.assert_allclose(smooth, (4 * many - few) / 3, rtol=0, atol=1e-10)  # the difference goes with 1/D²
    azimuth = np.array([0.3, 2.0, 4.5])
    np.testing.assert_allclose(smooth[0], -0.019 * (alpha * np.cos(azimuth) - beta * np.sin(azimuth)), atol=1e-16)


def test_straight_between_six_disks_is_a_tenth_of_a_millimetre_shorter():
    """At 1 rad on 91 mm: docs/kinematics.md."""
    across = (math.pi / 2,)
    off = through("arc", (1.0, 0.0), across) - through("arc", (1.0, 0.0), across, disks=6)
    assert off.item() == pytest.approx(0.1053e-3, rel=1e-3)


@some
@given(seeds, st.integers(2, 6), st.sampled_from([None, 0.008, 0.021]))
def test_cables_of_a_stack_are_those_of_an_arm_of_so_many_links(seed, count, passing):
    rng = np.random.default_rng(seed)
    shared = {"half_lengths": (0.003, 0.004), "passing_cable_radius": passing}
    both = ((50.0, -70.0, -190.0), (40.0, -80.0, -200.0))
    around = [{"cable_azimuths_deg": each} for each in both]
    stack = robot_of([of_kind("joints", joints=count, pitch=0.1, **shared, **each) for each in around])
    # The links of a stack have one circle for its own cables, which those of the last of them then have to keep.
    links = [section(pitch=0.1 / count, count=count, **shared, **around[0], cable_radius=passing or 0.019)]
    links += [section(pitch=0.1 / count, count=count, half_lengths=(0.003, 0.004), **around[1])]
    chain = robot_of(links)
    angles = rng.uniform(-0.7, 0.7, (5, 2, 2))
    small = np.repeat(angles / count, count, axis=1)
    ends = chain.cable_sections == 2 * count - 1
    found, expected = stack.cable_lengths(angles)[:, 3:], chain.cable_lengths(small)[:, ends]
    np.testing.assert_allclose(found - found[0], expected - expected[0], rtol=0, atol=1e-15)
    if passing is None:
        ends = np.isin(chain.cable_sections, [count - 1, 2 * count - 1])
        np.testing.assert_allclose(stack.cable_lengths(angles), chain.cable_lengths(small)[:, ends], rtol=0, atol=1e-15)


@some
@given(seeds)
def test_a_cable_runs_straight_through_two_hinges(seed):
    rng = np.random.default_rng(seed)
    alpha, beta = rng.uniform(-0.6, 0.6, 2)
    before, after, offset, azimuth = rng.uniform(0.001, 0.03, 4)
    hole = np.array([0.04 * math.cos(azimuth), 0.04 * math.sin(azimuth), 0.0])
    first, second = Rotation.from_euler("Y", alpha), Rotation.from_euler("X", beta)
    behind = first.apply(np.array([0, 0, offset]) + second.apply(hole + np.array([0, 0, after])))
    for share in (1.0, 0.4):
        keys = {"axis_offset": offset, "entering": 0.04 * share}
        found = through("hinges", (alpha, beta), (azimuth,), 0.04, before, after, 0.2, **keys)
        expected = np.linalg.norm(behind - share * hole + np.array([0, 0, before])) - offset
        assert found.item() == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("kind", list(MODELS))
def test_of_a_straight_section_the_hole_planes_are_left(kind):
    keys = {"joints": {"joints": 5}, "hinges": {"axis_offset": 0.02}}.get(kind, {})
    planes = {} if kind == "arc" else {"before": 0.003, "after": 0.005}
    np.testing.assert_allclose(through(kind, (0.0, 0.0), **planes, **keys), sum(planes.values()), rtol=0, atol=1e-17)


@pytest.mark.parametrize("kind", list(MODELS))
def test_at_first_order_cables_change_by_the_lever_of_their_hole(kind):
    keys = {"joints": {"joints": 5}, "hinges": {"axis_offset": 1e-9}}.get(kind, {})
    planes = {} if kind == "arc" else {"before": 0.003, "after": 0.005}
    around, step = np.array([0.3, 2.0, 4.5]), 1e-6
    for a, b in ((1, 0), (0, 1)):
        slope = (through(kind, (a * step, b * step), **planes, **keys) - through(kind, (0, 0), **planes, **keys)) / step
        np.testing.assert_allclose(slope[0], -0.019 * (a * np.cos(around) - b * np.sin(around)), rtol=0, atol=1e-7)


def oracle(robot, angles):
    """Lengths (c,) of cables as the sums of many short straight parts between holes placed in space."""
    sums = np.zeros(robot.cables)
    for k in range(robot.cables):
        azimuth = robot.cable_azimuths[k]
        around = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        place, turn = np.zeros(3), Rotation.identity()
        holes = [circle(robot, k, -1) * around - np.array([0, 0, robot.joint_before[0]])]
        for i in range(robot.cable_sections[k] + 1):
            hole = circle(robot, k, i) * around
            shape, kind = mixed(robot).sections[i], mixed(robot).kinds[i].name
            after = shape.after
            last = robot.pitches[i] - (robot.joint_before[i + 1] if i + 1 < robot.sections else shape.before)
            if kind == "arc":
                count = shape.disks or 2000
                alpha, beta = angles[i] + 1e-12
                places, turns = poses_along_arc(alpha, beta, robot.pitches[i], count)
                along = place + turn.apply(places + turns.apply(hole))
                # The step onto the circle of an arc without disks is the same in all postures, and not counted.
                holes += [np.full(3, np.nan), *along] if shape.disks is None else list(along[1:])
                place, turn = place + turn.apply(places[-1]), turn * turns[-1]
                continue
            pieces = stretched(robot, i)
            for number, (share_a, share_b, length, _) in enumerate(pieces):
                tool = robot.spec.tool_length if i == robot.sections - 1 and number == len(pieces) - 1 else 0.0
                turn = turn * Rotation.from_euler("YX", [share_a * angles[i, 0], share_b * angles[i, 1]])
                if kind != "hinges" or number:
                    holes.append(place + turn.apply(hole + np.array([0, 0, after])))
                    if number == len(pieces) - 1:
                        end = last - sum(piece[2] for piece in pieces[:-1])
                        holes.append(place + turn.apply(hole + np.array([0, 0, end])))
                    else:
                        holes.append(place + turn.apply(hole + np.array([0, 0, length - shape.before])))
                place = place + (length - tool) * turn.apply([0, 0, 1.0])
        sums[k] = np.nansum(np.linalg.norm(np.diff(holes, axis=0), axis=1))
    return sums


@settings(deadline=None, max_examples=6)
@given(seeds, st.booleans())
def test_cables_are_as_long_as_the_ways_from_hole_to_hole(seed, passing):
    """Through all sections passed, whatever their kind; arcs without disks by 2,000 straight parts."""
    rng = np.random.default_rng(seed)
    robot = mixed_robot(seed, 5, passing=passing)
    angles = rng.uniform(-0.6, 0.6, (robot.sections, 2))
    points, ends, _ = dense_line(robot, angles, 4)
    np.testing.assert_allclose(robot.joint_positions(angles), points[ends], atol=1e-13)
    np.testing.assert_allclose(robot.cable_lengths(angles), oracle(robot, angles), rtol=0, atol=3e-8)


@some
@given(seeds, st.booleans())
def test_angles_come_back_from_the_cables_they_make(seed, passing):
    rng = np.random.default_rng(seed)
    robot = mixed_robot(seed, passing=passing)
    angles = rng.uniform(-0.7, 0.7, (4, robot.sections, 2))
    near = angles + rng.uniform(-0.1, 0.1, angles.shape)
    found = robot.angles_from_cables(robot.cable_lengths(angles), near)
    np.testing.assert_allclose(found, angles, rtol=0, atol=1e-9)


def test_angles_of_lengths_that_do_not_fit_are_those_of_least_squares():
    rng = np.random.default_rng(3)
    robot = robot_of([of_kind("arc", disks=4), of_kind("joints"), of_kind("hinges")])
    angles = rng.uniform(-0.4, 0.4, (1, 3, 2))
    lengths = robot.cable_lengths(angles) + rng.normal(0, 2e-4, (1, robot.cables))
    found = robot.angles_from_cables(lengths, angles)

    def misfit(values, i):
        own = slice(*robot.first_cables[i : i + 2])
        return float((((robot.cable_lengths(values) - lengths)[:, own]) ** 2).sum())

    for i in range(3):
        for axis in (0, 1):
            for aside in (1e-4, -1e-4):
                other = found.copy()
                other[0, i, axis] += aside
                assert misfit(other, i) > misfit(found, i)


def test_where_cables_do_not_determine_a_section_the_later_ones_have_no_angles_either():
    robot = robot_of([of_kind("arc"), of_kind("link"), of_kind("arc")])
    lengths = np.repeat(robot.straight_cable_lengths[None], 2, axis=0)
    lengths[1, robot.first_cables[1]] += 1.0
    found = robot.angles_from_cables(lengths, np.zeros((2, 3, 2)))
    np.testing.assert_allclose(found[0], 0.0, atol=1e-12)
    assert np.isfinite(found[1, 0]).all()
    assert np.isnan(found[1, 1:]).all()


@some
@given(seeds)
def test_counts_are_zero_at_the_straight_arm_and_come_back(seed):
    robot = mixed_robot(seed)
    assert not robot.motor_counts(robot.cable_lengths(np.zeros((robot.sections, 2)))).any()
    counts = np.random.default_rng(seed).integers(-10_000, 10_000, robot.cables)
    np.testing.assert_array_equal(robot.motor_counts(robot.lengths_of_counts(counts)), counts)
