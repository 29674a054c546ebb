import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from path_oracles import SLIDER, at_parameter, closest_distance, loop, way_points
from scipy.interpolate import BSpline

from hognose.errors import InputError
from hognose.path import Path
from hognose.path.nearest import distances

seeds = st.integers(0, 2**32 - 1)
some = settings(deadline=None, max_examples=20)
few = settings(deadline=None, max_examples=12)


def de_casteljau(polygon, part):
    while len(polygon) > 1:
        polygon = (1 - part) * polygon[:-1] + part * polygon[1:]
    return polygon[0]


@some
@given(seeds, st.integers(2, 16), st.floats(0, 1))
def test_a_bezier_curve_is_that_of_de_casteljau(seed, count, part):
    polygon = way_points(np.random.default_rng(seed), count, 1.0)
    path = Path.bezier(polygon)
    assert path.degree == count - 1
    size = np.abs(polygon - polygon[0]).max()
    accuracy = 1e-15 * 4**count * size + 1e-14  # powers lose two bits a degree
    found = at_parameter(path, part * path.breaks[-1])[0]
    np.testing.assert_allclose(found, de_casteljau(polygon, part), rtol=0, atol=accuracy)
    np.testing.assert_allclose(path.point([0, path.length]), polygon[[0, -1]], rtol=0, atol=accuracy)


@some
@given(seeds, st.integers(1, 7), st.integers(2, 12), st.floats(0, 1))
def test_a_bspline_is_scipys(seed, order, count, part):
    polygon = way_points(np.random.default_rng(seed), count, 1.0)
    path = Path.bspline(polygon, order)
    degree = min(order, count - 1)
    spans = count - degree
    inner = np.arange(spans + 1.0)
    oracle = BSpline(np.concatenate([np.zeros(degree), inner, np.full(degree, spans)]), polygon, degree)
    assert path.degree == degree
    assert len(path.breaks) == spans + 1
    found = at_parameter(path, part * path.breaks[-1])[0]
    np.testing.assert_allclose(found, oracle(part * spans), rtol=0, atol=1e-12)


@some
@given(seeds, st.integers(3, 6), st.sampled_from(["bspline", "bezier"]))
def test_a_curve_with_a_start_direction_leaves_along_it_and_ends_at_its_last_point(seed, order, kind):
    polygon = way_points(np.random.default_rng(seed), 5)
    path = Path.bezier(polygon, SLIDER) if kind == "bezier" else Path.bspline(polygon, order, SLIDER)
    np.testing.assert_allclose(path.tangent(0.0), SLIDER, rtol=0, atol=1e-12)
    assert path.curvature(0.0) == pytest.approx(0, abs=1e-9)
    np.testing.assert_allclose(path.point([0, path.length]), polygon[[0, -1]], rtol=0, atol=1e-12)


@some
@given(seeds, st.sampled_from([1, 2, 3, 5, 7]))
def test_the_reversed_path_has_the_same_points_and_length_and_twice_is_once(seed, order):
    points = way_points(np.random.default_rng(seed), 6, 0.7)
    path = Path.through(points, order, None if order == 1 else SLIDER).with_run(0.3)
    back = path.reversed()
    assert back.length == pytest.approx(path.length, rel=1e-12)
    np.testing.assert_allclose(back.break_arcs, path.length - path.break_arcs[::-1], rtol=0, atol=1e-12)
    s = np.linspace(0, min(path.length, back.length), 60)
    np.testing.assert_allclose(back.point(back.length - s), path.point(s), rtol=0, atol=1e-12)
    inside = s[1:-1]
    if order > 1:
        there = back.tangent(back.length - inside)
        np.testing.assert_allclose(there, -path.tangent(inside), rtol=0, atol=1e-9)
    again = back.reversed()
    np.testing.assert_allclose(again.breaks, path.breaks - path.breaks[0], rtol=0, atol=1e-13)
    spans = np.diff(path.breaks)[:, None, None] ** np.arange(path.degree + 1)[:, None]
    np.testing.assert_allclose(again.coefficients * spans, path.coefficients * spans, rtol=0, atol=1e-12)


@few
@given(seeds, st.sampled_from([1, 3, 5]))
def test_distance_is_that_of_a_dense_search_with_every_valley_refined(seed, order):
    rng = np.random.default_rng(seed)
    path = Path.through(way_points(rng, 6, 1.0), order)
    near = path.point(rng.uniform(0, path.length, 4)) + 10 ** rng.uniform(-4, -1, (4, 1)) * rng.normal(size=(4, 3))
    points = np.concatenate([near, rng.uniform(-2, 2, (3, 3))])
    expected = [closest_distance(path, point) for point in points]
    np.testing.assert_allclose(path.distance_to(points), expected, rtol=0, atol=1e-10)


@some
@given(seeds, st.integers(1, 7))
def test_points_of_the_path_are_no_distance_away_and_their_order_does_not_matter(seed, order):
    rng = np.random.default_rng(seed)
    path = Path.through(way_points(rng, 6, 0.7), order)
    points = path.point(rng.uniform(0, path.length, 40))
    np.testing.assert_allclose(path.distance_to(points), 0, rtol=0, atol=1e-12)
    off = points + 0.05 * rng.normal(size=points.shape)
    found = path.distance_to(off)
    np.testing.assert_allclose(path.distance_to(off[::-1]), found[::-1], rtol=0, atol=1e-13)
    np.testing.assert_allclose([path.distance_to(p) for p in off], found, rtol=0, atol=1e-13)


@pytest.mark.parametrize("off", [1e-17, 1e-16, 1e-15, 1e-14])
def test_points_beside_a_place_where_the_search_begins_are_no_distance_away(off):
    # There the minimum is at an end of what is refined, and steps beyond it are halved in place of Newton's.
    rng = np.random.default_rng(2)
    path = Path.through(way_points(rng, 6, 0.7), 3)
    samples = np.linspace(path.breaks[0], path.breaks[-1], 1001)
    places = path._at_parameter(samples)[:, 0].copy()
    points = places[:, None] + off * rng.normal(size=(1001, 20, 3))
    away = distances(path.breaks, path.coefficients, samples, places, points.reshape(-1, 3))
    assert away.max() < 10 * off + 1e-14


def test_distance_to_a_straight_path_is_that_to_a_segment():
    path = Path.through([[0, 0, 0], [0, 0, 0.5]], 1)
    points = np.array([[0.03, 0.04, 0.2], [0, 0.3, -0.4], [0, 0, 0.5], [0.05, 0, 0.62]])
    np.testing.assert_allclose(path.distance_to(points), [0.05, 0.5, 0, 0.13], rtol=0, atol=1e-15)
    assert path.distance_to(points[0]).shape == ()
    assert path.distance_to(np.zeros((2, 4, 3))).shape == (2, 4)


def test_distance_to_a_path_that_comes_back_beside_itself_is_that_to_the_closer_leg():
    # The legs stand 2.2 mm apart and their samples, 2 mm apart, are not level with each other.
    hairpin = Path.through([[0, 0, 0], [0, 0, 0.1], [0.0022, 0, 0.1], [0.0022, 0, 0.001]], 1)
    height = np.linspace(0.02, 0.08, 601)
    points = np.column_stack([np.full(601, 0.001), np.zeros(601), height])
    np.testing.assert_allclose(hairpin.distance_to(points), 0.001, rtol=0, atol=1e-12)


@pytest.mark.parametrize("turn_deg", [30, 90, 150, 175])
def test_both_legs_of_a_kink_are_looked_at(turn_deg):
    turn = np.radians(turn_deg)
    away = np.array([np.sin(turn), 0, np.cos(turn)])
    kink = np.array([0, 0, 0.1])
    path = Path.through(np.array([0 * kink, kink, kink + 0.1 * away]), 1)
    reach = np.linspace(0, 0.003, 31)[:, None]
    np.testing.assert_allclose(path.distance_to(kink + reach * away), 0, rtol=0, atol=1e-15)
    np.testing.assert_allclose(path.distance_to(kink - reach * [0, 0, 1]), 0, rtol=0, atol=1e-15)


def test_a_bezier_curve_with_a_cusp_is_a_curve_or_the_users_mistake():
    """The middle of this well-known cubic stands still; it has no tangent there, but a place."""
    try:
        path = Path.bezier([[0, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0, 0]])
        middle = path.point(path.length / 2)
    except InputError as error:
        assert "cusp" in str(error)  # noqa: PT017
    else:
        np.testing.assert_allclose(middle, [0.5, 0.75, 0], rtol=0, atol=1e-9)


LINE = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
BEND = Path.through([[0, 0, 0], [0, 0, 1], [0, 1, 1]])


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: Path.through([]), "(m, 3), got shape (0,)"),
        (lambda: Path.through([[0, 0, 0]]), "at least two points"),
        (lambda: Path.through([[0, 0], [0, 1]]), "got shape (2, 2)"),
        (lambda: Path.through([[[0, 0, 0], [0, 0, 1]]]), "got shape (1, 2, 3)"),
        (lambda: Path.through([[0, 0, 0], [0, 1]]), "way-points: expected numbers in m of shape (m, 3)"),
        (lambda: Path.through("here"), "way-points: expected numbers in m of shape (m, 3), got text"),
        (lambda: Path.through([*LINE, [0, np.nan, 2]]), "point 3 is not finite: [0.0, nan, 2.0]"),
        (lambda: Path.through([[0, np.inf, 2], *LINE]), "point 1 is not finite"),
        (lambda: Path.through([*LINE, [0, 0, 1], [0, 1, 1]]), "points 2 and 3 are the same, (0, 0, 1000) mm"),
        (lambda: Path.bezier([LINE[0], LINE[0]]), "points 1 and 2 are the same"),
        (lambda: Path.bspline([LINE[0], LINE[0]]), "points 1 and 2 are the same"),
        (lambda: Path.through(LINE, 0), "order: expected a whole number from 1 to 9, got 0"),
        (lambda: Path.through(LINE, 10), "from 1 to 9, got 10"),
        (lambda: Path.through(LINE, -3), "got -3"),
        (lambda: Path.through(LINE, 3.0), "got 3.0"),  # pyright: ignore[reportArgumentType]
        (lambda: Path.through(LINE, True), "got True"),
        (lambda: Path.bspline(LINE, 0), "got 0"),
        (lambda: Path.through(LINE, 3, [0, 0, 0]), "start_direction: expected three numbers, not all zero"),
        (lambda: Path.through(LINE, 3, [0, 1]), "start_direction"),
        (lambda: Path.through(LINE, 3, [0, np.nan, 1]), "start_direction"),
        (lambda: Path.bezier(LINE, [0, 0, np.inf]), "start_direction"),
        (lambda: Path.bezier(np.arange(51.0).reshape(17, 3)), "17 control points"),
        (lambda: BEND.with_run(0.0), "length: expected a length above 0 m and up to 10,000 m, got 0.0"),
        (lambda: BEND.with_run(-1.0), "got -1.0"),
        (lambda: BEND.with_run(float("nan")), "got nan"),
        (lambda: BEND.with_run(float("inf")), "got inf"),
        (lambda: BEND.point(-1e-6), "s: expected arc lengths within 0"),
        (lambda: BEND.point(BEND.length + 1e-6), f"{BEND.length:.6g} m of the path"),
        (lambda: BEND.tangent([0.1, np.nan]), "s: expected numbers in m of shape (...), but 1 values are not finite"),
        (lambda: BEND.curvature([[0.1], [9.0]]), "s: expected arc lengths"),
        (lambda: BEND.parameter(np.inf), "not finite"),
        (lambda: BEND.frame(-1.0), "s: expected arc lengths"),
        (lambda: BEND.equal_distance_points(0.0), "spacing: expected a number above 0"),
        (lambda: BEND.equal_distance_points(-0.1), "spacing"),
        (lambda: BEND.equal_distance_points(float("nan")), "spacing"),
        (lambda: BEND.equal_distance_points(BEND.length * 1.01), "at most the path's"),
        (lambda: BEND.equal_distance_points(1e-8), "points on"),
    ],
)
def test_wrong_input_is_named(call, words):
    with pytest.raises(InputError) as caught:
        call()
    assert words in str(caught.value)


def test_rounding_at_the_ends_is_forgiven():
    path = loop()
    ends = path.point([0, path.length])
    near = path.point([-1e-13 * path.length, path.length * (1 + 1e-13)])
    np.testing.assert_array_equal(near, ends)


def test_the_way_points_given_are_not_touched():
    points = np.array(LINE)
    Path.through(points, 3, SLIDER).with_run(0.2).reversed()
    np.testing.assert_array_equal(points, LINE)
