"""What hides what: the arm and the obstacles, faces and edges, rooms and the arm inside them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hognose.report.camera import FRONT, Camera, view_axes
from hognose.report.canvas import link_colours, nice_length
from hognose.report.render import FINE, Lines, in_sight, sampled, set_stage, shoot

SIZE = (320, 200)
RED = np.array([[0.9, 0.05, 0.05]])


def arm_pixels(picture):
    covered = picture.depth > 0
    return covered.reshape(SIZE[1], FINE, SIZE[0], FINE).all(axis=(1, 3))


def test_the_arm_hides_obstacles_behind_it_and_shines_through_those_before_it(boards):
    stage = set_stage(boards, SIZE, towards_eye=FRONT)
    joints = boards.joints[-1] * [0, 0, 1] + [0.2, 0.2, 0]
    red = np.repeat(RED, 12, axis=0)
    # Seen from the far side: before the last board, then behind all three.
    near = shoot(stage, joints + np.array([0, 0, 1.2]), boards.robot.body_radii, red)
    far = shoot(stage, joints - [0, 0, 2.0], boards.robot.body_radii, red)
    clear, veiled = near.image[arm_pixels(near)], far.image[arm_pixels(far)]
    assert len(clear) > 50
    assert len(veiled) > 50
    assert clear[:, 1:].max() < 0.2
    assert veiled[:, 1:].min() > 0.2


def test_away_from_the_arm_the_picture_is_the_empty_space(boards):
    stage = set_stage(boards, SIZE)
    picture = shoot(stage, boards.joints[30], boards.robot.body_radii)
    touched = (picture.depth > 0).reshape(SIZE[1], FINE, SIZE[0], FINE).any(axis=(1, 3))
    np.testing.assert_array_equal(picture.image[~touched], stage.still[~touched])
    assert (picture.image[touched] != stage.still[touched]).any(axis=1).mean() > 0.95


def test_a_hole_in_a_board_is_a_hole_in_the_picture(boards):
    one = replace(
        boards,
        scene=replace(boards.scene, triangles=boards.scene.triangles[boards.scene.owner == 0],
                      owner=np.zeros(int((boards.scene.owner == 0).sum()), int)),
    )  # fmt: skip
    stage = set_stage(one, SIZE, towards_eye=FRONT)
    (hole, board), _ = stage.camera.project([[0, 0, 0.06], [0.15, 0.15, 0.06]], SIZE)
    np.testing.assert_allclose(stage.still[int(hole[1]), int(hole[0])], 1.0)
    assert stage.still[int(board[1]), int(board[0])].max() < 0.95


def test_near_walls_of_a_room_are_only_a_veil_over_the_arm_inside(tank):
    stage = set_stage(tank, SIZE)
    red = np.repeat(RED, 12, axis=0)
    picture = shoot(stage, tank.joints[-1] + [-0.2, -0.1, 0], tank.robot.body_radii, red)
    inside = picture.image[arm_pixels(picture)]
    solid = replace(stage, solids=stage.solids._replace(opacity=np.maximum(stage.solids.opacity, 0.34)))
    hidden = shoot(solid, tank.joints[-1] + [-0.2, -0.1, 0], tank.robot.body_radii, red).image[arm_pixels(picture)]
    assert np.median(inside[:, 1]) < 0.5 * np.median(hidden[:, 1])
    # The far walls are there all the same.
    assert (1 - stage.still).max() > 0.2


def test_lines_behind_the_arm_are_hidden_and_those_before_it_are_not(boards):
    stage = set_stage(boards, SIZE)
    joints = boards.joints[-1]
    picture = shoot(stage, joints, boards.robot.body_radii)
    middle = (joints[5] + joints[6]) / 2
    sight = (middle - stage.camera.eye) / np.linalg.norm(middle - stage.camera.eye)
    points = np.stack([middle - 0.03 * sight, middle])
    pixels, depth = stage.camera.project(points, SIZE)
    seen = in_sight(Lines(pixels, 1 / depth, np.arange(2)), picture.depth)
    assert seen.tolist() == [True, False]


def test_samples_run_from_end_to_end_with_nearness_linear_in_the_picture(boards):
    camera = set_stage(boards, SIZE).camera
    line = np.array([[[0.0, -0.2, 0.1], [0.1, 0.3, 0.9]]])
    lines = sampled(camera, SIZE, line)
    pixels, depth = camera.project(line[0], SIZE)
    np.testing.assert_allclose(lines.pixels[[0, -1]], pixels)
    np.testing.assert_allclose(lines.nearness[[0, -1]], 1 / depth)
    # Every sample is the image of a point of the line in space.
    share = np.linspace(0, 1, 4001)[:, None]
    at, deep = camera.project(line[0, 0] * (1 - share) + line[0, 1] * share, SIZE)
    nearest = np.argmin(np.linalg.norm(lines.pixels[:, None] - at, axis=-1), axis=1)
    np.testing.assert_allclose(lines.nearness, 1 / deep[nearest], rtol=1e-4)


def test_what_lies_partly_behind_the_eye_is_cut_off_there(boards):
    camera = Camera(np.array([0.0, 0.0, 0.5]), view_axes(FRONT), half_height=0.4)
    stage = set_stage(boards, SIZE, camera=camera)
    assert np.isfinite(stage.solids.pixels).all()
    assert (stage.solids.nearness > 0).all()
    assert np.isfinite(stage.outlines.pixels).all()
    picture = shoot(stage, boards.joints[-1], boards.robot.body_radii)
    assert np.isfinite(picture.image).all()


def test_a_space_without_obstacles_is_drawn(boards):
    empty = replace(boards.scene, triangles=np.empty((0, 3, 3)), owner=np.empty(0, int), names=())
    stage = set_stage(replace(boards, scene=empty), SIZE)
    picture = shoot(stage, boards.joints[0], boards.robot.body_radii)
    assert (picture.depth > 0).any()
    assert len(picture.edges) == len(picture.edges_behind) == 0
    assert len(picture.arm_edges) > 20


def test_an_arm_outside_the_picture_leaves_it_empty(boards):
    stage = set_stage(boards, SIZE)
    picture = shoot(stage, boards.joints[0] + 1000 * stage.camera.axes[0], boards.robot.body_radii)
    np.testing.assert_array_equal(picture.image, stage.still)


def test_links_are_coloured_by_clearance_and_beyond_the_horizon_in_grey(boards):
    clearance = np.full_like(boards.clearance, boards.horizon)
    clearance[:, 0], clearance[:, 1] = 0.0, 0.04
    colours = link_colours(replace(boards, clearance=clearance), 0)
    np.testing.assert_array_equal(colours[2:], np.repeat(colours[2:3], 10, axis=0))
    assert colours[0].sum() < colours[1].sum() < colours[2].sum()


@pytest.mark.parametrize(("length", "nice"), [(0.1, 0.1), (0.19, 0.1), (0.2, 0.2), (0.49, 0.2), (0.6, 0.5), (3.0, 2.0)])
def test_the_scale_is_one_two_or_five(length, nice):
    assert nice_length(length) == pytest.approx(nice)
