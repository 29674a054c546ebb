import numpy as np
import pytest
from following_oracles import FIRST_CROSSING, Marcher, interpolated, knotted_paths, predicted, random_path
from hypothesis import given, reject, settings
from hypothesis import strategies as st

import hognose
from hognose.following.bisection import Bisection
from hognose.following.iterative import Iterative
from hognose.following.lookup import lookup_points
from hognose.path import Path

SPACING = 0.0005
seeds = st.integers(0, 2**32 - 1)
first_crossing = pytest.mark.parametrize("method", FIRST_CROSSING)


@pytest.fixture(scope="module", params=list(knotted_paths()))
def knotted(request):
    return Marcher(knotted_paths()[request.param])


def assert_first_crossings(marcher, joints, feeds, lengths, slack):
    """Every joint is where a march from the joint before first comes to the link's length; counts the checks."""
    checked = 0
    for row, feed in zip(joints, feeds, strict=True):
        arc = float(feed)
        for i, length in enumerate(lengths):
            expected, cosine = marcher.first_crossing(row[i], arc, length, 4 * slack + 2e-6)
            if expected is None:
                # At the path's end: what a discrete method may do there is tested with the protocol.
                assert slack > 1e-6 or cosine > length - 2 * slack
                break
            if cosine < 0.15:
                break  # the distance only just reaches the length: a hair decides which crossing is the first
            gap = np.linalg.norm(marcher.path.point(expected) - row[i + 1])
            assert gap <= slack / cosine, (feed, i, arc, expected)
            arc = marcher.near(row[i + 1], expected, 0.003)
            checked += 1
    return checked


def feasible(follower, feeds):
    """The feeds at which the arm finds room on the path, and the joints."""
    rows, kept = [], []
    for feed in feeds:
        try:
            rows.append(follower.step(feed))
            kept.append(feed)
        except hognose.InfeasibleError:
            continue
    return kept, rows


@first_crossing
@pytest.mark.parametrize("link", [0.02, 0.05, 0.091, 0.15])
def test_every_joint_is_the_first_point_at_the_links_length(method, knotted, link):
    lengths = link * np.array([1.0, 0.8, 1.1, 1.0])
    follower = hognose.follower(knotted.path, lengths, method, SPACING)
    rng = np.random.default_rng(1)
    forward = np.linspace(0, knotted.path.length - 0.01, 40)
    feeds = np.concatenate([forward, forward[::-3], rng.uniform(0, knotted.path.length, 15)])
    kept, rows = feasible(follower, feeds)
    # Discrete methods may be off by half a point, and by what the curve bends between two points.
    slack = {"exact": 1e-9, "bisection": 1e-9, "interpolation": 2e-5}.get(method, 0.51 * SPACING)
    if method == "interpolation" and knotted.path.degree == 1:
        slack = 0.51 * SPACING  # it cuts the kinks
    assert assert_first_crossings(knotted, rows, kept, lengths, slack) > 50


@settings(deadline=None, max_examples=3)
@given(seeds)
def test_every_joint_on_a_wild_path_is_the_first_point_at_the_links_length(seed):
    marcher = Marcher(random_path(seed, "wild", run=0.3))
    rng = np.random.default_rng(seed)
    lengths = rng.uniform(0.02, 0.15, 4)
    forward = np.linspace(0, 0.8 * marcher.path.length, 20)
    slacks = {"exact": 1e-9, "bisection": 1e-9, "interpolation": 2e-5}
    for method in FIRST_CROSSING:
        slack = slacks.get(method, 0.51 * SPACING)
        follower = hognose.follower(marcher.path, lengths, method, SPACING)
        kept, rows = feasible(follower, np.concatenate([forward, forward[::-1]]))
        assert assert_first_crossings(marcher, rows, kept, lengths, slack) > 20


@pytest.mark.parametrize("link", [0.004, 0.06])
@pytest.mark.parametrize("step", [-0.0005, 0.0005])
def test_a_bend_too_narrow_to_be_sampled_does_not_lead_astray(step, link):
    """The path all but turns on the spot, at 0.493 of its only piece: its curvature there is not seen."""
    whole = 0.4 * np.array([[0, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0, 0.002]])
    end = 0.5 / 0.493
    edges = [whole]
    while len(edges[-1]) > 1:
        edges.append((1 - end) * edges[-1][:-1] + end * edges[-1][1:])
    marcher = Marcher(Path.bezier([points[0] for points in edges]))
    lengths = np.array([link])
    feeds = np.arange(0.0, marcher.path.length - 0.1, abs(step))[:: int(np.sign(step))]
    rows = hognose.follow(marcher.path, lengths, feeds)
    assert assert_first_crossings(marcher, rows, feeds, lengths, 1e-9) > 100


@pytest.mark.parametrize("order", [3, 5])
@settings(deadline=None, max_examples=6)
@given(seeds)
def test_prediction_is_the_papers_lookup(order, seed):
    """Equations 4 to 10, on feeds of whole points as in the paper, forward and back."""
    path = random_path(seed, "gentle", order)
    lengths = np.random.default_rng(seed).uniform(0.05, 0.1, 5)
    feeds = SPACING * np.concatenate([np.arange(1400, 1800, 7), np.arange(1800, 1400, -5)])
    expected = predicted(path, lengths, feeds, SPACING)
    found = hognose.follow(path, lengths, feeds, "prediction", SPACING)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("spacing", [0.0005, 0.002])
@settings(deadline=None, max_examples=6)
@given(seeds)
def test_interpolation_is_the_papers_equation_12(spacing, seed):
    path = random_path(seed)
    rng = np.random.default_rng(seed)
    lengths = rng.uniform(0.05, 0.1, 5)
    feeds = np.concatenate([np.arange(0.7, 0.9, 0.0035), rng.uniform(0.5, 1.0, 10)])
    expected = interpolated(path, lengths, feeds, spacing)
    found = hognose.follow(path, lengths, feeds, "interpolation", spacing)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


def test_prediction_errs_in_the_first_order_of_the_spacing_and_interpolation_in_the_second():
    path = random_path(2)
    lengths, feeds = np.full(8, 0.091), np.linspace(0.5, 1.0, 150)
    exact = hognose.follow(path, lengths, feeds)

    def rms(method, spacing):
        joints = hognose.follow(path, lengths, feeds, method, spacing)
        return np.sqrt(np.mean(np.sum((joints[:, -1] - exact[:, -1]) ** 2, axis=-1)))

    # A ratio of 8; a link is no half number of spacings, or the last bit would say to which point a joint snaps.
    coarse, fine = 1.92e-3, 2.4e-4
    assert 4 < rms("prediction", coarse) / rms("prediction", fine) < 24
    assert 30 < rms("interpolation", coarse) / rms("interpolation", fine) < 130
    assert rms("interpolation", fine) < 1e-3 * rms("prediction", fine)


@pytest.mark.parametrize("kind", ["gentle", "wild"])
@settings(deadline=None, max_examples=6)
@given(seeds)
def test_what_the_published_methods_gained_in_speed_they_did_not_lose_in_the_answer(kind, seed):
    path = random_path(seed, kind)
    lengths = np.random.default_rng(seed).uniform(0.03, 0.1, 4)
    feeds = np.concatenate([np.arange(0.6, 1.0, 0.0035), [0.3, 0.9], np.arange(1.0, 0.6, -0.01)])
    for method, accuracy in ((Iterative, 0.0), (Bisection, 1e-12)):
        tuned, published = (method(path, lengths, SPACING, as_published=form) for form in (False, True))
        try:
            expected = published.run(feeds)
        except hognose.InfeasibleError:
            reject()
        np.testing.assert_allclose(tuned.run(feeds), expected, rtol=0, atol=accuracy)
        assert tuned.evaluations <= published.evaluations
    stepped = published_steps(path, lengths, feeds)
    np.testing.assert_array_equal(Iterative(path, lengths, SPACING, as_published=True).run(feeds[::20]), stepped)


def published_steps(path, lengths, feeds):
    """Ref. 32 in plain Python: go to the next point until it is far enough, keep the closer of the last two."""
    points = lookup_points(path, SPACING, len(lengths) + 1)
    rows = []
    for feed in feeds[::20]:
        index = int(feed / SPACING + 0.5)
        row = [points[index]]
        for length in lengths:
            beyond = index + 1
            while np.linalg.norm(points[beyond] - row[-1]) < length:
                beyond += 1
            far, near = (abs(np.linalg.norm(points[k] - row[-1]) - length) for k in (beyond, beyond - 1))
            index = beyond - 1 if near < far else beyond
            row.append(points[index])
        rows.append(row)
    return np.array(rows)
