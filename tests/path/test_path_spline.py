import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from path_oracles import SLIDER, derivatives, way_points
from scipy.interpolate import BSpline, CubicSpline, make_interp_spline

from hognose.path import Path

seeds = st.integers(0, 2**32 - 1)
orders = st.integers(1, 7)
many = settings(deadline=None, max_examples=30)


def chord_sites(points):
    return np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))


def from_scipy(spline, u):
    return np.stack([spline(u, k) for k in range(3)])


def assert_smooth(path, index, highest):
    """Derivatives 0 … highest agree on both sides of a break; each weighs what it does over one piece."""
    u = path.breaks[index]
    span = min(u - path.breaks[index - 1], path.breaks[index + 1] - u)
    weights = np.array([[span**k / math.factorial(k)] for k in range(highest + 1)])
    here, there = derivatives(path, u, highest, "left"), derivatives(path, u, highest, "right")
    np.testing.assert_allclose(here * weights, there * weights, rtol=0, atol=1e-12)


@many
@given(seeds, st.integers(2, 9))
def test_cubic_coefficients_are_those_of_eq_2(seed, count):
    points = way_points(np.random.default_rng(seed), count, 1.0)
    path = Path.through(points, 3)
    slopes = np.array([derivatives(path, u, 1)[1] for u in path.breaks])
    np.testing.assert_allclose(path.breaks, chord_sites(points), rtol=1e-14, atol=1e-15)
    for h in range(count - 1):
        u = path.breaks[h + 1] - path.breaks[h]
        start, end, out, into = points[h], points[h + 1], slopes[h], slopes[h + 1]
        a = [
            start,
            out,
            3 * (end - start) / u**2 - (2 * out + into) / u,
            2 * (start - end) / u**3 + (out + into) / u**2,
        ]
        scale = np.abs(a).max() + 1
        np.testing.assert_allclose(path.coefficients[h], a, rtol=0, atol=1e-12 * scale)


@many
@given(seeds, st.floats(0, 1))
def test_cubic_segments_are_the_normalised_form_of_eq_3(seed, part):
    """With the parameter u / u_{h+1}, the tangents of eq. (3) are those by that parameter."""
    points = way_points(np.random.default_rng(seed), 5, 1.0)
    path = Path.through(points, 3)
    f = [2 * part**3 - 3 * part**2 + 1, part**2 * (3 - 2 * part), part * (part - 1) ** 2, part**2 * (part - 1)]
    for h in range(4):
        u = path.breaks[h + 1] - path.breaks[h]
        out = derivatives(path, path.breaks[h], 1, "right")[1] * u
        into = derivatives(path, path.breaks[h + 1], 1, "left")[1] * u
        expected = f[0] * points[h] + f[1] * points[h + 1] + f[2] * out + f[3] * into
        found = derivatives(Path(path.breaks[h : h + 2], path.coefficients[h : h + 1]), path.breaks[h] + part * u, 0)
        np.testing.assert_allclose(found[0], expected, rtol=0, atol=1e-13)


@many
@given(seeds, st.integers(3, 9))
def test_order_3_is_scipys_natural_cubic(seed, count):
    points = way_points(np.random.default_rng(seed), count, 1.0)
    path, u = Path.through(points, 3), chord_sites(points)
    oracle = CubicSpline(u, points, bc_type="natural")
    for at in np.linspace(0, u[-1], 50)[1:-1]:
        np.testing.assert_allclose(derivatives(path, at, 2), from_scipy(oracle, at), rtol=1e-10, atol=1e-10)


@many
@given(seeds, st.integers(3, 7))
def test_order_5_is_scipys_natural_quintic(seed, count):
    points = way_points(np.random.default_rng(seed), count, 1.0)
    path, u = Path.through(points, 5), chord_sites(points)
    free = [(3, np.zeros(3)), (4, np.zeros(3))]
    if count < 6:  # SciPy wants as many sites as coefficients; the clean end conditions are still ours to check
        for side, at in (("right", u[0]), ("left", u[-1])):
            ends = derivatives(path, at, 4, side)[3:]
            np.testing.assert_allclose(ends, 0, rtol=0, atol=1e-9 * np.abs(path.coefficients).max())
        return
    oracle = make_interp_spline(u, points, 5, bc_type=(free, free))
    for at in np.linspace(0, u[-1], 50)[1:-1]:
        np.testing.assert_allclose(derivatives(path, at, 2), from_scipy(oracle, at), rtol=1e-8, atol=1e-8)


@many
@given(seeds, orders, st.integers(2, 10), st.sampled_from([0.0, 0.3, 1.0]))
def test_a_spline_passes_through_its_way_points_with_all_promised_derivatives(seed, order, count, bends):
    count = max(count, (order + 1) // 2)  # fewer points leave several smoothest ones: see the next test
    points = way_points(np.random.default_rng(seed), count, bends)
    path = Path.through(points, order)
    assert path.degree == order
    for u, point in zip(path.breaks, points, strict=True):
        for side in ("left", "right"):
            np.testing.assert_allclose(derivatives(path, u, 0, side)[0], point, rtol=0, atol=1e-11)
    np.testing.assert_allclose(path.point(path.break_arcs), points, rtol=0, atol=1e-11)
    for index in range(1, count - 1):
        assert_smooth(path, index, order - 1)


@pytest.mark.parametrize(("order", "count"), [(o, c) for o in range(5, 10) for c in range(2, (o + 1) // 2)])
def test_a_spline_through_few_points_passes_them_without_strange_loops(order, count):
    points = way_points(np.random.default_rng(order), count)
    path = Path.through(points, order)
    np.testing.assert_allclose(path.point(path.break_arcs), points, rtol=0, atol=1e-9)
    assert path.length < 1.5 * np.linalg.norm(np.diff(points, axis=0), axis=1).sum()


@many
@given(seeds, orders, st.integers(2, 9))
def test_a_straight_run_joins_with_all_promised_derivatives(seed, order, count):
    rng = np.random.default_rng(seed)
    points, run = way_points(rng, count), rng.uniform(0.3, 1.5)
    direction = rng.normal(size=3) + 3 * np.array(SLIDER)
    unit = direction / np.linalg.norm(direction)
    if order == 1:
        points[1] = points[0] + unit * rng.uniform(0.1, 0.3)
        assert_runs_straight(Path.through(points, 1).with_run(run), points, unit, run)
        return
    path = Path.through(points, order, 7 * direction).with_run(run)
    assert_runs_straight(path, points, unit, run)
    for index in range(1, len(path.breaks) - 1):
        assert_smooth(path, index, order - 1)
    np.testing.assert_allclose(path.distance_to(points), 0, rtol=0, atol=1e-10)
    entrance = derivatives(path, path.breaks[1], order - 1, "right")
    np.testing.assert_allclose(entrance[1], unit, rtol=0, atol=1e-11)
    span = path.breaks[2] - path.breaks[1]
    for k in range(2, order):
        np.testing.assert_allclose(entrance[k] * span**k, 0, rtol=0, atol=1e-10)


def assert_runs_straight(path, points, unit, run):
    s = np.linspace(0, run, 40)
    line = points[0] + (s - run)[:, None] * unit
    np.testing.assert_allclose(path.point(s), line, rtol=0, atol=1e-13)
    np.testing.assert_allclose(path.tangent(s[:-1]), np.broadcast_to(unit, (39, 3)), rtol=0, atol=1e-13)
    assert not path.curvature(s[:-1]).any()


@many
@given(seeds, st.integers(3, 7), st.sampled_from(["through", "bspline", "bezier"]))
def test_curvature_starts_from_zero_at_the_entrance(seed, order, kind):
    points = way_points(np.random.default_rng(seed), 5)
    if kind == "bezier":
        path = Path.bezier(points, SLIDER).with_run(0.5)
    else:
        path = getattr(Path, kind)(points, order, SLIDER).with_run(0.5)
    near = path.curvature(0.5 + np.array([-1e-9, 0, 1e-9]))
    np.testing.assert_allclose(near, 0, rtol=0, atol=1e-4)
    np.testing.assert_allclose(path.tangent(0.5 + 1e-9), SLIDER, rtol=0, atol=1e-8)
    assert path.curvature(np.linspace(0.5, path.length, 200)).max() > 0.01


@many
@given(seeds, orders)
def test_moving_turning_and_growing_the_way_points_does_the_same_to_the_path(seed, order):
    rng = np.random.default_rng(seed)
    points = way_points(rng, 6)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    size, shift = rng.uniform(0.01, 10), rng.uniform(-2, 2, 3)
    path = Path.through(points, order)
    other = Path.through(size * points @ turn.T + shift, order)
    assert other.length == pytest.approx(size * path.length, rel=1e-11)
    part = np.linspace(0, 1, 30)
    expected = size * path.point(part * path.length) @ turn.T + shift
    np.testing.assert_allclose(other.point(part * other.length), expected, rtol=0, atol=1e-10 * (size + 1))


@pytest.mark.parametrize("order", range(1, 10))
@pytest.mark.parametrize("direction", [None, (1.0, 2.0, 2.0)])
@pytest.mark.parametrize("count", [2, 3, 4, 6])
def test_way_points_on_a_line_make_that_line(order, direction, count):
    along = np.array([0.0, 0.1, 0.25, 0.3, 0.5, 0.9])[:count]
    points = along[:, None] * np.array([1.0, 2.0, 2.0]) / 3 + 0.1
    path = Path.through(points, order, direction)
    accuracy = 1e-11 if order < 8 else 1e-7
    assert path.length == pytest.approx(along[-1], abs=accuracy)
    s = np.linspace(0, along[-1], 37)
    line = points[0] + s[:, None] * np.array([1.0, 2.0, 2.0]) / 3
    np.testing.assert_allclose(path.point(np.minimum(s, path.length)), line, rtol=0, atol=accuracy)


@pytest.mark.parametrize("order", [2, 3, 4, 5, 6, 7])
def test_no_spline_through_the_points_bends_less(order):
    """The energy is stationary: its product with every spline of the order that vanishes at the sites is 0."""
    points = way_points(np.random.default_rng(8), 6, 1.0)
    path = Path.through(points, order)
    p = max(2, (order + 1) // 2)

    knots = np.concatenate([np.full(order, path.breaks[0]), path.breaks, np.full(order, path.breaks[-1])])
    count = len(knots) - order - 1
    basis = BSpline(knots, np.eye(count), order)
    values = basis(path.breaks)
    _, singular, rows = np.linalg.svd(values)
    vanishing = rows[np.sum(singular > 1e-10) :]
    assert len(vanishing) == order - 1
    for weights in vanishing:
        bump = BSpline(knots, weights, order)
        inner = np.zeros(3)
        nodes, mass = np.polynomial.legendre.leggauss(order + 1)
        for h in range(len(points) - 1):
            half = (path.breaks[h + 1] - path.breaks[h]) / 2
            for node, weight in zip(nodes, mass, strict=True):
                u = path.breaks[h] + half * (node + 1)
                inner += half * weight * bump(u, p) * derivatives(path, u, p)[p]
        size = sum(np.abs(derivatives(path, u, p)[p]).max() * np.abs(bump(u, p)) for u in path.breaks)
        np.testing.assert_allclose(inner, 0, rtol=0, atol=1e-10 * size)
