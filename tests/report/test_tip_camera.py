"""The camera on the tip: it looks along the last link, through holes, and sees what is lit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import hognose
from hognose.report.camera import Camera, view_axes
from hognose.report.tip_camera import DARK, photograph, tip_camera, tip_picture, tip_pictures
from hognose.robot.tip_camera import ANGLE_OF_VIEW_DEG
from hognose.scene import Board, Hole, Scene

SIZE = (81, 61)  # odd, so that one pixel is the middle
NOTHING = np.round(255 * np.array(DARK))
ALONG = view_axes((0.0, 0.0, -1.0))
HOLE = 0.05


@pytest.fixture(scope="module")
def board():
    hole = Hole(center=(0.1, 0.0), diameter=2 * HOLE)
    return Scene.from_obstacles([Board(center=(0.0, 0.0, 0.3), size=(0.6, 0.6), thickness=0.01, hole=(hole,))])


@pytest.fixture(scope="module")
def plan():
    return hognose.plan(hognose.load_task("obstacle-array"))


def camera(x: float, y: float, z: float = 0.0) -> Camera:
    return Camera(np.array([x, y, z]), ALONG, float(np.tan(np.radians(0.5 * ANGLE_OF_VIEW_DEG))))


@settings(max_examples=25)
@given(st.booleans(), st.floats(0.0, 1.0), st.floats(-np.pi, np.pi), st.floats(-0.4, 0.2))
def test_the_middle_is_dark_exactly_where_the_sight_goes_through_the_hole(board, through, share, way, z):
    """But for the rim, which is as wide as a few pixels."""
    away = share * (HOLE - 0.02) if through else HOLE + 0.02 + 0.1 * share
    x, y = 0.1 + away * np.cos(way), away * np.sin(way)
    middle = photograph(board, camera(x, y, z), SIZE)[SIZE[1] // 2, SIZE[0] // 2]
    assert (middle == NOTHING).all() == through


def test_a_hole_lies_where_the_camera_projects_it(board):
    eye = camera(0.02, -0.03, 0.05)
    dark = (photograph(board, eye, (321, 241)) == NOTHING).all(axis=2)
    # Within the picture of the board: its border is far from the hole.
    centre, _ = eye.project([0.1, 0.0, 0.295], (321, 241))
    focal = 241 / 2 / eye.half_height
    rows, columns = np.indices(dark.shape)
    near = np.hypot(columns + 0.5 - centre[0], rows + 0.5 - centre[1]) < 1.5 * HOLE * focal / 0.245
    # Seen through the front rim and the back one, which is farther and shifted.
    assert np.pi * (HOLE * focal / 0.255) ** 2 * 0.85 < (dark & near).sum() < np.pi * (HOLE * focal / 0.245) ** 2


def test_what_is_farther_is_darker(board):
    lit = [photograph(board, camera(-0.1, 0.0, z), SIZE)[30, 40].sum() for z in (0.2, 0.0, -0.3, -1.0, -3.0)]
    assert (np.diff(np.array(lit, dtype=int)) < 0).all()


def test_nothing_is_dark(board):
    back = Camera(np.zeros(3), view_axes((0.0, 0.0, 1.0)), 0.5)
    assert (photograph(board, back, SIZE) == NOTHING).all()
    assert (photograph(Scene.from_obstacles([]), back, SIZE) == NOTHING).all()


def test_it_looks_along_the_last_link_from_its_end(plan):
    for step in (0, 150, -1):
        step %= len(plan.time)
        seen, last = tip_camera(plan, step), plan.body[step, -1] - plan.body[step, -2]
        np.testing.assert_allclose(seen.eye, plan.body[step, -1], atol=1e-12)
        np.testing.assert_allclose(seen.axes[2], last / np.linalg.norm(last), atol=1e-9)
        np.testing.assert_allclose(seen.axes @ seen.axes.T, np.eye(3), atol=1e-12)
        np.testing.assert_allclose(np.cross(seen.axes[0], seen.axes[1]), -seen.axes[2], atol=1e-12)
    np.testing.assert_allclose(tip_camera(plan, 0).axes, [[-1, 0, 0], [0, 1, 0], [0, 0, 1]], atol=1e-12)


def test_it_sees_the_hole_it_is_about_to_go_through(plan):
    # 40 mm before the last board, whose far side is open.
    step = int(np.argmin(np.abs(plan.body[:, -1, 2] - 0.76)))
    picture = tip_picture(plan, step, (161, 121))
    through, _ = tip_camera(plan, step).project([0.022, 0.063, 0.8], (161, 121))
    column, row = np.floor(through).astype(int)
    assert (picture[row, column] == NOTHING).all()
    assert (picture[60, -1] != NOTHING).any()


def test_the_figure_has_a_picture_an_instant(plan):
    assert [len(tip_pictures(plan, times).axes) for times in ([0.0], [0.0, 22.0, 34.0, 46.0])] == [1, 4]
    with pytest.raises(hognose.InputError, match="99 s lies outside the plan"):
        tip_pictures(plan, [99.0])
