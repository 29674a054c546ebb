import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from path_oracles import SLIDER, arc_length, at_parameter, derivatives, loop, way_points

from hognose.path import Path

seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from(["polyline", "cubic", "quintic", "septic run", "bezier", "bspline", "loop"])
some = settings(deadline=None, max_examples=15)


def path_of(kind, seed):
    rng = np.random.default_rng(seed)
    points = way_points(rng, int(rng.integers(4, 9)), 0.6)
    return {
        "polyline": lambda: Path.through(points, 1),
        "cubic": lambda: Path.through(points),
        "quintic": lambda: Path.through(points, 5),
        "septic run": lambda: Path.through(points, 7, SLIDER).with_run(0.4),
        "bezier": lambda: Path.bezier(points),
        "bspline": lambda: Path.bspline(points, 4),
        "loop": loop,
    }[kind]()


@some
@given(kinds, seeds)
def test_length_is_that_of_adaptive_quadrature(kind, seed):
    path = path_of(kind, seed)
    arcs = [arc_length(path, a, b) for a, b in zip(path.breaks[:-1], path.breaks[1:], strict=True)]
    np.testing.assert_allclose(path.break_arcs, np.append(0, np.cumsum(arcs)), rtol=2e-13, atol=1e-14)
    assert path.length == path.break_arcs[-1]


@some
@given(kinds, seeds)
def test_length_is_that_of_a_fine_polyline(kind, seed):
    """Two polylines, extrapolated: the error of the inscribed polyline falls by four as its pieces are halved."""
    path = path_of(kind, seed)
    lengths = []
    for pieces in (1000, 2000):
        parts = np.arange(pieces) / pieces
        u = (path.breaks[:-1, None] + np.diff(path.breaks)[:, None] * parts).ravel()
        corners = at_parameter(path, np.append(u, path.breaks[-1]))
        lengths.append(np.linalg.norm(np.diff(corners, axis=0), axis=1).sum())
    assert lengths[1] <= path.length * (1 + 1e-13)
    assert path.length == pytest.approx((4 * lengths[1] - lengths[0]) / 3, rel=1e-9)


@some
@given(kinds, seeds, st.lists(st.integers(0, 1000), min_size=1, max_size=6))
def test_parameter_is_the_inverse_of_the_arc_length(kind, seed, parts):
    path = path_of(kind, seed)
    s = np.array(parts) / 1000 * path.length
    u = path.parameter(s)
    assert ((u >= path.breaks[0]) & (u <= path.breaks[-1])).all()
    back = [arc_length(path, path.breaks[0], one) if one > path.breaks[0] else 0.0 for one in u]
    np.testing.assert_allclose(back, s, rtol=0, atol=1e-12 * max(1, path.length))


@some
@given(kinds, seeds)
def test_parameter_rises_and_meets_the_breaks(kind, seed):
    path = path_of(kind, seed)
    np.testing.assert_allclose(path.parameter(path.break_arcs), path.breaks, rtol=0, atol=1e-12)
    assert (np.diff(path.parameter(np.linspace(0, path.length, 4000))) > 0).all()
    assert path.parameter(0.0) == path.breaks[0]


@some
@given(kinds, seeds, st.floats(0.02, 0.98))
def test_point_tangent_and_curvature_belong_together(kind, seed, part):
    path = path_of(kind, seed)
    s = part * path.length
    gap = np.abs(path.break_arcs - s).min()
    step = 1e-4
    if gap < 1.1 * step:  # at a break a higher derivative jumps; a polyline even turns
        s += 3 * step
    before, here, after = path.point([s - step, s, s + step])
    slope, bend = (after - before) / (2 * step), (after - 2 * here + before) / step**2
    # Third derivatives by arc length, which the differences leave out, grow with curvature and speed changes.
    u = path.parameter(s)
    first, second, third = derivatives(path, u, 3)[1:]
    speed = float(np.linalg.norm(first))
    rough = (float(np.linalg.norm(third)) / speed**3 + 3 * (float(np.linalg.norm(second)) / speed**2) ** 2 + 1) * 10
    tangent = path.tangent(s)
    assert np.linalg.norm(tangent) == pytest.approx(1, abs=1e-15)
    np.testing.assert_allclose(slope, tangent, rtol=0, atol=rough * step**2)
    assert path.curvature(s) == pytest.approx(float(np.linalg.norm(bend)), abs=rough * step * 10 + 1e-6)
    np.testing.assert_array_equal(path.frame(s)[0], path.point(s))
    np.testing.assert_allclose(path.frame(s), derivatives(path, u, 2), rtol=1e-12, atol=1e-10)


@some
@given(kinds, seeds, st.floats(1e-3, 0.3))
def test_equal_distance_points_are_equally_far_apart_along_the_path(kind, seed, spacing):
    path = path_of(kind, seed)
    points = path.equal_distance_points(spacing)
    assert (len(points) - 1) * spacing <= path.length * (1 + 1e-12) < len(points) * spacing * (1 + 1e-9)
    np.testing.assert_allclose(points, path.point(spacing * np.arange(len(points))), rtol=0, atol=1e-13)
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert (chords <= spacing * (1 + 1e-10)).all()


def test_equal_distance_points_end_on_the_end_of_a_whole_number_of_spacings():
    line = Path.through([[0, 0, 0], [0, 0, 0.3]], 1)
    points = line.equal_distance_points(0.1)
    np.testing.assert_allclose(points[:, 2], [0, 0.1, 0.2, 0.3], rtol=0, atol=1e-16)
    np.testing.assert_allclose(line.equal_distance_points(0.29)[:, 2], [0, 0.29], rtol=0, atol=1e-16)


@pytest.mark.parametrize("order", [3, 5, 7])
def test_a_spline_through_a_dense_circle_is_that_circle(order):
    radius, turn = 0.4, np.linspace(0, 2 * np.pi, 361)
    points = radius * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    path = Path.through(points, order)
    assert path.length == pytest.approx(2 * np.pi * radius, rel=1e-7)
    s = np.linspace(0.1, 0.9, 50) * path.length  # away from the natural ends
    angle = s / radius
    expected = radius * np.column_stack([np.cos(angle), np.sin(angle), 0 * s])
    np.testing.assert_allclose(path.point(s), expected, rtol=0, atol=2e-7)
    across = np.column_stack([-np.sin(angle), np.cos(angle), 0 * s])
    np.testing.assert_allclose(path.tangent(s), across, rtol=0, atol=2e-6)
    np.testing.assert_allclose(path.curvature(s), 1 / radius, rtol=1e-4)


def test_a_parabola_has_the_length_and_curvature_of_the_closed_form():
    # The Bézier curve of (-1, 1), (0, -1), (1, 1) is y = x².
    path = Path.bezier([[-1, 1, 0], [0, -1, 0], [1, 1, 0]])
    assert path.length == pytest.approx(np.sqrt(5) + np.arcsinh(2) / 2, rel=1e-14)
    x = path.point(np.linspace(0, path.length, 41))[:, 0]
    np.testing.assert_allclose(path.point(np.linspace(0, path.length, 41))[:, 1], x**2, rtol=0, atol=1e-14)
    curvature = path.curvature(np.linspace(0, path.length, 41))
    np.testing.assert_allclose(curvature, 2 / (1 + 4 * x**2) ** 1.5, rtol=1e-12)
    half = np.abs(x) * np.sqrt(1 + 4 * x**2) / 2 + np.arcsinh(2 * np.abs(x)) / 4
    s = path.length / 2 + np.sign(x) * half
    np.testing.assert_allclose(np.linspace(0, path.length, 41), s, rtol=0, atol=1e-13)
    assert path.sharpest == pytest.approx((2, path.length / 2), rel=1e-12)


def test_the_sharpest_bend_is_the_largest_curvature_of_a_dense_search():
    path = loop()
    s = np.linspace(0, path.length, 40_001)
    curvature = path.curvature(s)
    assert path.sharpest[0] == pytest.approx(curvature.max(), rel=2e-3)
    assert path.curvature(path.sharpest[1]) == pytest.approx(path.sharpest[0], rel=0.02)
    kinked = Path.through([[0, 0, 0], [0, 0, 1], [0, 1, 1]], 1)
    assert kinked.sharpest == pytest.approx((np.inf, 1.0))
    assert Path.through([[0, 0, 0], [0, 0, 1]], 1).sharpest[0] == 0


def test_a_polyline_is_as_sharp_as_its_first_corner_and_straight_where_it_has_none():
    rng = np.random.default_rng(4)
    for _ in range(200):
        start, along, aside = rng.normal(size=(3, 3))
        along /= np.linalg.norm(along)
        places = np.cumsum(rng.uniform(0.01, 0.5, 5))
        straight = start + places[:, None] * along
        assert Path.through(straight, 1).sharpest == (0, 0)
        assert Path.through(straight[:2], 1).with_run(1.1).sharpest == (0, 0)
        bent = straight + np.maximum(places - places[2], 0.0)[:, None] * 1e-4 * aside
        assert Path.through(bent, 1).sharpest == pytest.approx((np.inf, places[2] - places[0]))
        back = np.append(straight, straight[1:2], axis=0)
        assert Path.through(back, 1).sharpest == pytest.approx((np.inf, places[-1] - places[0]))


@pytest.mark.parametrize("order", [2, 3, 4, 5, 7, 9])
def test_a_spline_has_no_kink_where_its_pieces_meet_and_one_where_a_corner_follows(order):
    rng = np.random.default_rng(order)
    for _ in range(50):
        points = np.cumsum(rng.normal((0, 0, 1), 0.2, (6, 3)), axis=0)
        path = Path.through(points, order, start_direction=(0, 0.1, 1)).with_run(0.5)
        assert np.isfinite(path.sharpest[0])
        assert np.isfinite(path.reversed().sharpest[0])
        corner = Path.through([points[-1], points[-1] + rng.normal(size=3)], 1)
        assert corner.with_lead(path).sharpest == pytest.approx((np.inf, path.length))


@pytest.mark.parametrize("shape", [(), (1,), (5,), (2, 3), (0,)])
def test_answers_have_the_shape_of_the_question(shape):
    path = loop()
    s = np.random.default_rng(0).uniform(0, path.length, shape)
    assert path.parameter(s).shape == path.curvature(s).shape == shape
    assert path.point(s).shape == path.tangent(s).shape == (*shape, 3)
    assert path.frame(s).shape == (*shape, 3, 3)
    for index in np.ndindex(shape):
        np.testing.assert_allclose(path.point(s)[index], path.point(s[index]), rtol=0, atol=1e-15)
