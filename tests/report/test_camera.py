"""The camera against closed forms: where points land, and that what is fitted just fits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hognose.report.camera import FRONT, THREE_QUARTER, Camera, fitted, fitted_either_way, view_axes

SIZE = (400, 300)
coordinates = st.floats(-3, 3, width=32)
directions = arrays(float, 3, elements=st.floats(-1, 1, width=32)).filter(lambda d: np.linalg.norm(d) > 0.1)


def test_a_point_lands_where_similar_triangles_say():
    camera = Camera(np.array([0.0, 0.0, 5.0]), view_axes(FRONT), half_height=0.5)
    pixels, depth = camera.project([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.3, -0.2, 1.0]], SIZE)
    focal = 150 / 0.5
    expected = [
        [200, 150],
        [200 + focal / 5, 150],
        [200, 150 - focal / 5],
        [200 + focal * 0.3 / 4, 150 + focal * 0.2 / 4],
    ]
    np.testing.assert_allclose(pixels, expected, atol=1e-12)
    np.testing.assert_allclose(depth, [5, 5, 5, 4])


def test_a_point_behind_the_eye_has_no_place():
    camera = Camera(np.zeros(3), view_axes(FRONT), half_height=0.5)
    pixels, depth = camera.project([0, 0, 1.0], SIZE)
    assert depth < 0
    assert np.isnan(pixels).all()


@given(directions)
def test_axes_are_right_handed_and_keep_up_upright(direction):
    axes = view_axes(direction)
    right, up, sight = axes
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(np.cross(right, up), -sight, atol=1e-12)
    np.testing.assert_allclose(sight, -direction / np.linalg.norm(direction), atol=1e-12)
    assert up[1] >= -1e-9


def test_the_usual_view_runs_the_insertion_from_left_to_right_and_has_y_up():
    camera = fitted([[-1, -1, -1], [1, 1, 1]], SIZE, towards_eye=THREE_QUARTER)
    pixels, _ = camera.project([[0, 0, 0], [0, 0, 0.1], [0, 0.1, 0]], SIZE)
    assert pixels[1, 0] > pixels[0, 0]
    assert pixels[2, 1] < pixels[0, 1]
    assert pixels[2, 0] == pytest.approx(pixels[0, 0], abs=2.0)


@given(arrays(float, (12, 3), elements=coordinates), directions, st.sampled_from([(400, 300), (300, 500)]))
def test_what_is_fitted_fills_the_tighter_side_and_stays_inside_the_other(points, direction, size):
    if np.ptp(points, axis=0).max() < 0.1:
        points = points + np.arange(12)[:, None] * 0.1
    camera = fitted(points, size, towards_eye=direction, border=0.05)
    pixels, depth = camera.project(points, size)
    assert depth.min() > 0
    low, high = np.array(size) * 0.05, np.array(size) * 0.95
    assert (pixels > low - 1e-6).all()
    assert (pixels < high + 1e-6).all()
    touches = np.isclose(pixels.min(axis=0), low, atol=1e-5) & np.isclose(pixels.max(axis=0), high, atol=1e-5)
    assert touches.any() or depth.min() < 2e-3


@pytest.mark.parametrize(("size", "tips"), [((770, 375), True), ((375, 770), False), ((400, 400), False)])
def test_an_arm_that_enters_upright_lies_along_a_wide_picture_and_stands_in_others(size, tips):
    mast = np.array([(x, y, z) for x in (0.0, 0.1) for y in (0.0, 1.5) for z in (0.0, 0.2)])
    side = (-0.84, 0.62, 0.36)
    found = fitted_either_way(mast, size, towards_eye=side, otherwise_up=(0.0, 0.0, 1.0))
    assert (found.axes[1, 2] > 0.9, found.axes[1, 1] < 0.3) == (tips, tips)
    pixels, _ = found.project(mast, size)
    assert (pixels >= 0).all()
    assert (pixels <= size).all()
    assert np.ptp(pixels, axis=0).max() > 0.85 * max(size)


def test_a_picture_that_would_gain_little_keeps_y_up():
    block = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.2) for z in (0.0, 1.0)])
    found = fitted_either_way(block, (770, 375), towards_eye=(-0.84, 0.62, 0.36), otherwise_up=(0.0, 0.0, 1.0))
    assert found.axes[1, 1] > abs(found.axes[1, 2])
