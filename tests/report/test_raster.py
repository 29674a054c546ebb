"""The pixel kernels against a plain twin that tests every pixel of every triangle."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from hognose.report.raster import keep_nearest, lay_over, shrunk

SIZE = (24, 32)


def random_triangles(seed, count):
    rng = np.random.default_rng(seed)
    return rng.uniform(-6, 38, (count, 3, 2)), rng.uniform(0.2, 1, (count, 3)), rng.uniform(0, 1, (count, 3))


def inside(triangle, nearness):
    """Return the pixels whose centres lie in a triangle, and the plane's nearness everywhere."""
    rows, columns = np.mgrid[: SIZE[0], : SIZE[1]] + 0.5
    system = np.column_stack([triangle, np.ones(3)]).T
    shares = np.linalg.solve(system, np.stack([columns, rows, np.ones(SIZE)]).reshape(3, -1))
    return (shares >= 0).all(axis=0).reshape(SIZE), (nearness @ shares).reshape(SIZE)


def opaque(triangles, nearness, colours):
    image, depth = np.ones((*SIZE, 3)), np.zeros(SIZE)
    keep_nearest(triangles, nearness, colours, image, depth)
    return image, depth


@given(st.integers(0, 10_000))
@settings(deadline=None)
def test_the_nearest_triangle_wins_at_every_pixel(seed):
    triangles, nearness, colours = random_triangles(seed, 5)
    image, depth = opaque(triangles, nearness, colours)
    expected_image, expected_depth = np.ones((*SIZE, 3)), np.zeros(SIZE)
    for triangle, near, colour in zip(triangles, nearness, colours, strict=True):
        covered, plane = inside(triangle, near)
        wins = covered & (plane > expected_depth)
        expected_depth[wins], expected_image[wins] = plane[wins], colour
    np.testing.assert_allclose(depth, expected_depth, atol=1e-9)
    np.testing.assert_allclose(image, expected_image, atol=1e-12)


@given(st.integers(0, 10_000))
@settings(deadline=None)
def test_the_order_in_which_opaque_triangles_come_does_not_matter(seed):
    triangles, nearness, colours = random_triangles(seed, 6)
    order = np.random.default_rng(seed).permutation(6)
    one, other = (
        opaque(triangles, nearness, colours),
        opaque(triangles[order], nearness[order], colours[order]),
    )
    np.testing.assert_allclose(one[0], other[0], atol=1e-9)
    np.testing.assert_allclose(one[1], other[1], atol=1e-9)


@given(st.integers(0, 10_000))
@settings(deadline=None)
def test_see_through_triangles_are_laid_over_only_what_lies_behind_them(seed):
    triangles, nearness, colours = random_triangles(seed, 7)
    image, depth = opaque(triangles[:3], nearness[:3], colours[:3])
    depth[:2] = -1
    expected, front, expected_front = image.copy(), np.zeros(SIZE), np.zeros(SIZE)
    opacity = np.array([0.2, 0.4, 0.6, 0.05])
    lay_over(triangles[3:], nearness[3:], colours[3:], opacity, image, depth, front, 0.1)
    for k in range(4):
        covered, plane = inside(triangles[3 + k], nearness[3 + k])
        seen = covered & (plane > depth) & (depth >= 0)
        expected[seen] += opacity[k] * (colours[3 + k] - expected[seen])
        if opacity[k] > 0.1:
            expected_front[seen] = np.maximum(expected_front, plane)[seen]
    np.testing.assert_allclose(image, expected, atol=1e-9)
    np.testing.assert_allclose(front, expected_front, atol=1e-9)


@given(st.integers(0, 10_000))
@settings(deadline=None)
def test_a_surface_of_many_triangles_has_neither_gaps_nor_doubled_pixels(seed):
    rng = np.random.default_rng(seed)
    grid = np.stack(np.meshgrid(np.linspace(-4, 36, 8), np.linspace(-4, 28, 7)), axis=-1)
    grid[1:-1, 1:-1] += rng.uniform(-1.2, 1.2, grid[1:-1, 1:-1].shape)
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    triangles = np.concatenate([np.stack([a, b, c], -2).reshape(-1, 3, 2), np.stack([c, d, a], -2).reshape(-1, 3, 2)])
    count = len(triangles)
    image = np.ones((*SIZE, 3))
    lay_over(
        triangles,
        np.ones((count, 3)),
        np.zeros((count, 3)),
        np.full(count, 0.25),
        image,
        np.zeros(SIZE),
        np.zeros(SIZE),
        0.0,
    )
    np.testing.assert_array_equal(image, 0.75)


def test_a_triangle_without_area_paints_nothing_and_harms_nothing():
    flat = np.array([[[2.0, 2.0], [12.0, 12.0], [22.0, 22.0]], [[5.0, 5.0]] * 3])
    image, depth = opaque(flat, np.ones((2, 3)), np.zeros((2, 3)))
    assert np.isfinite(image).all()
    assert (image == 1).all()
    assert (depth == 0).all()


def test_shrinking_averages_squares():
    image = np.random.default_rng(1).uniform(0, 1, (8, 12, 3))
    np.testing.assert_allclose(shrunk(image, 2), image.reshape(4, 2, 6, 2, 3).mean(axis=(1, 3)))
