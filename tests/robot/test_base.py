"""What the arm stands on: a slider in any direction is the same slider, moved."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from robot_oracles import tapered_robot
from scipy.spatial.transform import Rotation

from hognose.robot.base import Slider, angles_on, axes_of, centre_line, joints_on
from hognose.robot.holes import holes_of, link_frames

seeds = st.integers(0, 2**32 - 1)


def turned_slider(seed):
    """A random arm, a slider that points anywhere, and configurations (5, n, 2) rad with feeds (5,) m."""
    rng = np.random.default_rng(seed)
    robot = tapered_robot(seed)
    rotation = Rotation.random(rng=rng).as_matrix()
    base = Slider.before(rng.normal(size=3), robot, rotation)
    angles = rng.uniform(-1, 1, (5, robot.sections, 2)) * robot.bend_limits
    return robot, base, angles, rng.uniform(0, robot.length, 5)


@given(seed=seeds)
def test_the_pose_of_the_base_puts_the_straight_arm_where_the_base_places_it(seed):
    robot, base, _, feeds = turned_slider(seed)
    straight = robot.joint_positions(np.zeros((robot.sections, 2)))
    at = feeds[:, None]
    placed = joints_on(base, robot, np.zeros((len(feeds), robot.sections, 2)), at)
    for row, axes in enumerate(axes_of(base, at)):
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
        first = base.start + feeds[row] * base.direction
        np.testing.assert_allclose(straight @ axes.T + first, placed[row], atol=1e-12)
    links = robot.link_lengths[:, None] * base.direction
    np.testing.assert_allclose(np.diff(placed, axis=1), np.broadcast_to(links, placed[:, 1:].shape), atol=1e-12)


@given(seed=seeds)
def test_the_nose_of_the_straight_arm_is_at_the_entrance_at_feed_0(seed):
    robot = tapered_robot(seed)
    rng = np.random.default_rng(seed)
    entrance = rng.normal(size=3)
    base = Slider.before(entrance, robot, Rotation.random(rng=rng).as_matrix())
    nose = joints_on(base, robot, np.zeros((1, robot.sections, 2)), np.zeros((1, 1)))[0, -1]
    np.testing.assert_allclose(nose, entrance, atol=1e-12)


@given(seed=seeds)
def test_angles_of_what_the_base_placed_are_the_angles_again(seed):
    robot, base, angles, feeds = turned_slider(seed)
    at = feeds[:, None]
    joints = joints_on(base, robot, angles, at)
    np.testing.assert_allclose(angles_on(base, robot, joints, at), angles, atol=1e-9)
    np.testing.assert_allclose(base.turned(base.aligned(joints, at), at), joints, atol=1e-12)
    np.testing.assert_allclose(centre_line(base, robot, joints, at), joints, atol=1e-12)  # links are their own chords


@given(seed=seeds, beside=st.floats(0, 0.1))
def test_the_feed_at_a_place_is_the_one_whose_first_joint_is_closest(seed, beside):
    _, base, _, feeds = turned_slider(seed)
    across = np.cross(base.direction, [0.3, -0.5, 0.8])
    for feed in feeds:
        first = base.start + feed * base.direction
        found, off = base.feed_at(first + beside * across / np.linalg.norm(across), 0.0)
        assert found == pytest.approx(feed, abs=1e-12)
        assert off == pytest.approx(beside, abs=1e-12)


@given(seed=seeds)
def test_what_is_behind_the_first_joint_covers_the_mount_at_every_feed_between(seed):
    robot, base, _, feeds = turned_slider(seed)
    low, high = np.sort(feeds)[[0, -1]]
    starts, ends, radii = base.behind(feeds[:, None])
    assert starts.shape == ends.shape == (1, 3)
    assert radii == [robot.body_radii[0]]
    for feed in feeds:
        first = base.start + feed * base.direction
        for part in (0.0, base.length_behind):
            along = (first - part * base.direction - starts[0]) @ base.direction
            assert -1e-12 <= along <= np.linalg.norm(ends[0] - starts[0]) + 1e-12
    np.testing.assert_allclose(ends[0] - starts[0], (high - low + base.length_behind) * base.direction, atol=1e-12)


@given(seed=seeds)
def test_cables_are_as_long_as_the_way_from_hole_to_hole(seed):
    robot, _, angles, _ = turned_slider(seed)
    joints, lengths = robot.joint_positions(angles[0]), robot.cable_lengths(angles[0])
    for cable in range(robot.cables):
        holes = holes_of(robot, joints, link_frames(angles[0], np.eye(3)), cable)
        assert len(holes) == 2 * robot.cable_sections[cable] + 3
        # The first hole is the plane before joint 1, where a cable's length begins.
        assert np.linalg.norm(np.diff(holes, axis=0), axis=1).sum() == pytest.approx(lengths[cable], rel=1e-12)


@given(seed=seeds)
def test_holes_keep_their_place_on_the_disk_of_their_link(seed):
    robot, _, angles, _ = turned_slider(seed)
    joints, frames = robot.joint_positions(angles[0]), link_frames(angles[0], np.eye(3))
    for cable in range(robot.cables):
        holes = holes_of(robot, joints, frames, cable)
        for number, hole in enumerate(holes):
            link = (number + 1) // 2  # two disks on every link, one on the base
            local = frames[link].T @ (hole - joints[max(link - 1, 0)])
            assert np.hypot(*local[:2]) == pytest.approx(robot.cable_radii[cable], rel=1e-12)
            assert np.cos(np.arctan2(local[1], local[0]) - robot.cable_azimuths[cable]) == pytest.approx(1.0, abs=1e-12)
