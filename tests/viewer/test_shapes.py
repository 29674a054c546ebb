"""What the page draws is where the arm is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import hognose
from hognose.robot.holes import link_frames
from hognose.viewer import shapes
from hognose.viewer.model.clock import Clock
from hognose.viewer.verdict_panel import plain


@pytest.fixture(scope="module")
def robot():
    return hognose.load_robot("sjtu-25dof")


def bent(robot, seed):
    angles = np.random.default_rng(seed).uniform(-0.5, 0.5, (robot.sections, 2))
    return angles, robot.joint_positions(angles, 0.3)


def rotated(quaternion, vector):
    w, axis = quaternion[0], quaternion[1:]
    return vector + 2 * np.cross(axis, np.cross(axis, vector) + w * vector)


@pytest.mark.parametrize("name", ["sjtu-25dof", "sjtu-25dof-99"])
def test_cables_are_as_long_as_the_kinematics_says(name):
    robot = hognose.load_robot(name)
    angles, joints = bent(robot, 3)
    pieces, owner = shapes.cables(robot, joints, link_frames(angles, np.eye(3)))
    lengths = np.linalg.norm(pieces[:, 1] - pieces[:, 0], axis=1)
    ends = np.flatnonzero(np.any(pieces[1:, 0] != pieces[:-1, 1], axis=1)) + 1
    drawn = [part.sum() for part in np.split(lengths, ends)]
    np.testing.assert_allclose(drawn, robot.cable_lengths(angles), rtol=0, atol=1e-12)
    assert owner.max() == robot.sections - 1


@given(st.integers(0, 2**32 - 1))
def test_cylinders_lie_along_their_links(seed):
    robot = hognose.load_robot("sjtu-25dof")
    _, joints = bent(robot, seed)
    places, turns, scales = shapes.links(joints, robot.body_radii)
    for k in range(robot.sections):
        top = places[k] + rotated(turns[k], np.array([0, 0, scales[k, 2]]))
        np.testing.assert_allclose(top, joints[k + 1], rtol=0, atol=1e-12)
    np.testing.assert_allclose(scales[:, :2], np.stack([robot.body_radii] * 2, axis=1))


def test_a_link_that_points_back_is_turned_round():
    turn = shapes.turns_from_z(np.array([[0.0, 0.0, -1.0]]))[0]
    np.testing.assert_allclose(rotated(turn, np.array([0.0, 0.0, 1.0])), [0, 0, -1], atol=1e-15)


def test_disks_stand_across_their_links(robot):
    angles, joints = bent(robot, 4)
    places, turns, _ = shapes.disks(robot, joints, link_frames(angles, np.eye(3)))
    along = np.diff(joints, axis=0)
    for i in range(robot.sections):
        axis = rotated(turns[2 * i + 1], np.array([0.0, 0.0, 1.0]))
        np.testing.assert_allclose(axis, along[i] / np.linalg.norm(along[i]), atol=1e-12)
        assert np.linalg.norm(places[2 * i + 1] - joints[i]) < 0.0105


@pytest.mark.parametrize("sides", [3, 32])
def test_the_cylinder_is_closed_and_wound_outwards(sides):
    vertices, faces = shapes.unit_cylinder(sides)
    corners = vertices[faces]
    volume = np.einsum("fi,fi->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume == pytest.approx(sides / 2 * np.sin(2 * np.pi / sides))


def test_balls_between_chords_show_through_no_side_of_the_cylinders():
    cylinder, faces = shapes.unit_cylinder()
    sides = cylinder[faces][np.ptp(cylinder[faces][:, :, 2], axis=1) > 0]
    out = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
    nearest = np.einsum("fi,fi->f", out, sides[:, 0]) / np.linalg.norm(out, axis=1)
    ball = shapes.SKIN * np.linalg.norm(shapes.unit_ball()[0], axis=1)
    assert 0.99 < ball.max() <= nearest.min() + 1e-12


def test_colours_tell_too_close_from_near_far_and_unknown():
    found = shapes.clearance_colours(np.array([0.0049, 0.005, 0.03, 0.0499, 0.05]), 0.005, 0.05)
    assert tuple(found[0]) == shapes.TOO_CLOSE_COLOUR
    assert tuple(found[1]) == shapes.NEAR_COLOUR
    assert tuple(found[4]) == shapes.BEYOND_COLOUR
    assert np.all(np.diff(found[1:4].astype(int), axis=0)[:, 1] > 0)


MOVES = st.lists(st.sampled_from(["play", "on", "back", "time", "out", "in", "scrub"]), max_size=30)


@given(st.integers(1, 500), MOVES)
def test_a_clock_stays_on_its_rows(rows, moves):
    clock = Clock(rows)
    for k, move in enumerate(moves):
        clock = {
            "play": clock.toggled,
            "on": lambda c=clock: c.stepped(1),
            "back": lambda c=clock: c.stepped(-1),
            "time": lambda c=clock: c.after(0.7, 0.15),
            "out": lambda c=clock: Clock(c.rows, c.row, c.playing, c.speed, True),
            "in": lambda c=clock: Clock(c.rows, c.row, c.playing, c.speed, False),
            "scrub": lambda c=clock, k=k: c.to(37.0 * k - 50),
        }[move]()
        assert 0 <= clock.row <= rows - 1
        assert 0 <= clock.shown < rows


def test_a_clock_plays_in_the_time_of_the_arm_and_stops_at_the_ends():
    clock = Clock(101, speed=2.0).toggled()
    assert clock.after(3.0, 0.15).row == pytest.approx(40)
    assert clock.after(100.0, 0.15).shown == 100
    assert not clock.after(100.0, 0.15).playing
    back = Clock(101, row=100.0, outwards=True).toggled().after(1.5, 0.15)
    assert (back.row, back.playing) == (pytest.approx(90), True)
    assert Clock(101, row=100.0).toggled().row == 0  # played to the end, it plays again


@pytest.mark.parametrize("turn", [(0.0, 0.0), (3.0, 0.0), (-2.0, 5.0), (0.0, 1e-9)])
def test_the_way_ahead_is_the_arc_that_the_turn_means(turn):
    frame = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    line = shapes.arc(np.array([0.1, 0.2, 0.3]), frame, np.array(turn), 0.1)
    np.testing.assert_allclose(line[0], (0.1, 0.2, 0.3), atol=1e-15)
    there = (line - line[0]) @ frame  # along x, y and the heading of the nose
    rate, chords = np.hypot(*turn), np.linalg.norm(np.diff(line, axis=0), axis=1)
    piece = 0.1 / (len(line) - 1)
    np.testing.assert_allclose(chords, piece if rate < 1e-6 else 2 / rate * np.sin(rate * piece / 2), rtol=1e-9)
    # Circles: x and y grow with the square of the way, towards the turn.
    np.testing.assert_allclose(there[1, :2], 0.5 * np.array(turn) * piece**2, rtol=1e-3, atol=1e-12)
    np.testing.assert_allclose(there[-1, 2], 0.1 if rate < 1e-6 else np.sin(0.1 * rate) / rate, rtol=1e-9)


def test_rings_stand_round_the_middles_of_their_links(robot):
    joints = np.stack([bent(robot, seed)[1] for seed in (1, 2)])
    pieces = shapes.rings(joints, robot.body_radii, sides=8).reshape(8, 2, robot.sections, 2, 3)
    middles, along = 0.5 * (joints[:, :-1] + joints[:, 1:]), np.diff(joints, axis=1)
    out = pieces - middles[:, :, None]
    np.testing.assert_allclose(np.linalg.norm(out, axis=-1) - robot.body_radii[:, None], 0, atol=1e-15)
    np.testing.assert_allclose(np.einsum("stnei,tni->stne", out, along), 0, atol=1e-15)
    np.testing.assert_array_equal(pieces[1:, ..., 0, :], pieces[:-1, ..., 1, :])
    np.testing.assert_allclose(pieces[-1, ..., 1, :], pieces[0, ..., 0, :], atol=1e-15)


def test_names_in_a_file_become_no_markup():
    evil = "<img src=x> ![a](http://b) {1+1} `c`"
    assert plain(evil) == r"\<img src=x\> \!\[a\](http://b) \{1+1\} \`c\`"
    assert plain("way-point 2 at (30.0, 25.0) mm is 3.6 mm from 'pipe 1'") == (
        "way-point 2 at (30.0, 25.0) mm is 3.6 mm from 'pipe 1'"
    )
