import math
from functools import cache

import numpy as np
import pytest
from following_oracles import GLIDING, ON_PATH, SLIDER, random_path
from hypothesis import assume, given, reject, settings
from hypothesis import strategies as st

import hognose
from hognose.path import Path

seeds = st.integers(0, 2**32 - 1)
methods = pytest.mark.parametrize("method", list(hognose.METHODS))
gliding = pytest.mark.parametrize("method", GLIDING)
on_path = pytest.mark.parametrize("method", ON_PATH)
kinds = st.sampled_from(["gentle", "wild"])
some = settings(deadline=None, max_examples=12)


def random_lengths(rng):
    """2 to 14 links between 50 and 100 mm."""
    return rng.uniform(0.05, 0.1, int(rng.integers(2, 15)))


def random_feeds(path, lengths, rng, count=60):
    """Forward, backward, and in jumps; the chords of the arm are shorter than the path that is left."""
    last = path.length - 1.7 * lengths.sum() if path.degree > 1 else 0.4
    top = max(0.3, min(1.0, last))
    feeds = np.linspace(0, top, count)
    return np.concatenate([feeds, feeds[::-1], rng.uniform(0, top, count)])


def followed(method, path, lengths, feeds, spacing=0.0005):
    """The follower and the joints; an example whose path at random is too short for the arm is drawn anew."""
    follower = hognose.follower(path, lengths, method, spacing)
    try:
        return follower, follower.run(feeds)
    except hognose.InfeasibleError:
        reject()


@on_path
@some
@given(seeds, kinds, st.sampled_from([2, 3, 5, 7]))
def test_joints_lie_on_the_path_a_link_apart(method, seed, kind, order):
    assume(kind == "gentle" or method != "optimization")  # it finds minima nearby, of which wild paths have many
    rng = np.random.default_rng(seed)
    path, lengths = random_path(seed, kind, order), random_lengths(rng)
    feeds = random_feeds(path, lengths, rng)
    follower, joints = followed(method, path, lengths, feeds)
    assert joints.shape == (len(feeds), len(lengths) + 1, 3)
    links = np.linalg.norm(np.diff(joints, axis=1), axis=2)
    np.testing.assert_allclose(links, np.broadcast_to(lengths, links.shape), rtol=0, atol=follower.tolerance)
    assert path.distance_to(joints).max() <= follower.tolerance
    bases = np.linalg.norm(joints[:, 0] - path.point(feeds), axis=1)
    assert bases.max() <= follower.tolerance


@some
@given(seeds, kinds, st.sampled_from([1, 2, 3, 5, 7]))
def test_the_exact_method_is_exact(seed, kind, order):
    rng = np.random.default_rng(seed)
    path, lengths = random_path(seed, kind, order), random_lengths(rng)
    feeds = random_feeds(path, lengths, rng)
    follower, joints = followed("exact", path, lengths, feeds)
    assert follower.tolerance <= 1e-12
    links = np.linalg.norm(np.diff(joints, axis=1), axis=2)
    np.testing.assert_allclose(links, np.broadcast_to(lengths, links.shape), rtol=0, atol=1e-12)
    assert path.distance_to(joints).max() <= 1e-12
    np.testing.assert_allclose(joints[:, 0], path.point(feeds), rtol=0, atol=1e-13)


@some
@given(seeds, st.floats(0.001, 0.01))
def test_short_links_are_no_less_exact(seed, length):
    path = random_path(seed)
    lengths = length * np.random.default_rng(seed).uniform(0.5, 1.5, 20)
    top = path.length - 2 * lengths.sum()
    feeds = np.concatenate([np.arange(0.9, top, 0.0035), np.arange(top, 0.9, -0.002)])
    follower = hognose.follower(path, lengths)
    joints = follower.run(feeds)
    links = np.linalg.norm(np.diff(joints, axis=1), axis=2)
    np.testing.assert_allclose(links, np.broadcast_to(lengths, links.shape), rtol=0, atol=follower.tolerance)
    assert path.distance_to(joints).max() <= follower.tolerance


@gliding
@some
@given(seeds, kinds, st.sampled_from([1, 3, 5]))
def test_the_answer_does_not_depend_on_what_was_asked_before(method, seed, kind, order):
    assume(kind == "gentle" or method != "optimization")  # it finds minima nearby, of which wild paths have many
    rng = np.random.default_rng(seed)
    path, lengths = random_path(seed, kind, order), random_lengths(rng)
    feeds = random_feeds(path, lengths, rng)
    follower, joints = followed(method, path, lengths, feeds)
    order_of_asking = rng.permutation(len(feeds))
    again = follower.run(feeds[order_of_asking])
    np.testing.assert_allclose(again, joints[order_of_asking], rtol=0, atol=1e-11)
    fresh = [hognose.follower(path, lengths, method).step(feed) for feed in feeds[::20]]
    np.testing.assert_allclose(fresh, joints[::20], rtol=0, atol=1e-11)


@methods
def test_on_a_straight_path_the_joints_are_the_sums_of_the_links(method):
    direction = np.array([2.0, -1.0, 2.0]) / 3
    path = Path.through(np.outer([0.0, 2.0], direction) + 0.1)
    lengths = np.array([0.05, 0.0123, 0.3, 0.091])
    feeds = np.array([0.0, 0.7, 0.3, 1.5])
    follower = hognose.follower(path, lengths, method, 0.0005)
    along = feeds[:, None] + np.append(0, np.cumsum(lengths))
    expected = path.point(0.0) + along[..., None] * direction
    # Off by half a point a link, where the method takes points.
    accuracy = follower.tolerance * (len(lengths) + 1)
    np.testing.assert_allclose(follower.run(feeds), expected, rtol=0, atol=accuracy)


@cache
def helix(radius, rise, turns, order=5):
    angle = np.linspace(0, math.tau * turns, int(90 * turns))
    return Path.through(np.column_stack([radius * np.cos(angle), radius * np.sin(angle), rise * angle]), order)


@on_path
@pytest.mark.parametrize("link", [0.03, 0.091, 0.2])
def test_equal_chords_on_a_helix_take_equal_arcs(method, link):
    radius, rise = 0.3, 0.05
    path = helix(radius, rise, 3)
    follower = hognose.follower(path, np.full(12, link), method, 0.0005)
    joints = follower.run(np.linspace(1.5, 2.0, 40))  # far from the ends, which are not quite a helix
    angle = joints[..., 2] / rise
    turn = np.diff(angle, axis=1)
    chord = 2 * radius * np.sin(turn / 2), rise * turn
    accuracy = 4 * follower.tolerance + 1e-12
    np.testing.assert_allclose(np.hypot(*chord), link, rtol=0, atol=accuracy)
    if method == "exact":
        np.testing.assert_allclose(turn, turn[0, 0], rtol=1e-9)
        on_circle = np.hypot(joints[..., 0], joints[..., 1])
        np.testing.assert_allclose(on_circle, radius, rtol=0, atol=1e-11)


@on_path
@pytest.mark.parametrize("radius", [0.15, 0.3, 1.0])
def test_a_chord_on_a_circle_spans_twice_the_arcsine(method, radius):
    path = helix(radius, 0.0, 0.9)
    link = 0.091
    follower = hognose.follower(path, np.full(3, link), method, 0.0005)
    joints = follower.run(np.linspace(0.25, 0.5, 30) * path.length)
    angle = np.unwrap(np.arctan2(joints[..., 1], joints[..., 0]), axis=1)
    expected = 2 * math.asin(link / (2 * radius))
    np.testing.assert_allclose(np.diff(angle, axis=1), expected, rtol=0, atol=(3 * follower.tolerance + 1e-11) / radius)


@pytest.mark.parametrize(("order", "run"), [(3, 1.2), (5, 1.2), (1, 1.2)])
def test_the_tip_reaches_the_very_end_of_the_path(order, run):
    """The feed is found as the planner finds it, by following the reversed path from its end."""
    lengths = np.random.default_rng(order).uniform(0.05, 0.12, 12)
    for seed in range(4):
        path = random_path(seed, "gentle", order, run)
        base = hognose.follow(path.reversed(), lengths[::-1], [0.0])[0][-1]
        candidates = path.distance_to(base)
        assert candidates < 1e-12
        # The base is on the run only if the arm is long enough; else it is past it: take its arc by search.
        arcs = np.linspace(0, path.length, 200_001)
        about = arcs[np.argmin(np.linalg.norm(path.point(arcs) - base, axis=1))]
        low, high = max(about - 2e-5, 0.0), min(about + 2e-5, path.length)
        for _ in range(100):
            thirds = low + (high - low) * np.array([1, 2]) / 3
            a, b = np.linalg.norm(path.point(thirds) - base, axis=1)
            low, high = (low, thirds[1]) if a < b else (thirds[0], high)
        feed = low + float((base - path.point(low)) @ path.tangent(low))
        for feeds in ([feed], np.append(np.arange(0, feed, 0.0035), feed)):
            tip = hognose.follow(path, lengths, feeds)[-1, -1]
            np.testing.assert_allclose(tip, path.point(path.length), rtol=0, atol=2e-9)


def test_the_tip_reaches_the_target_at_the_end_of_the_sliders_run():
    lengths = np.full(12, 0.091)
    rng = np.random.default_rng(4)
    for _ in range(20):
        steps = np.array([0, 0, 0.25]) + rng.normal(size=(3, 3)) * 0.03
        points = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
        path = Path.through(points, 3, SLIDER).with_run(1.092)
        base = hognose.follow(path.reversed(), lengths[::-1], [0.0])[0][-1]
        feed = float(base[2]) + 1.092
        assert 0 < feed < 1.092
        feeds = np.append(np.arange(0, feed, 0.0035), feed)
        joints = hognose.follow(path, lengths, feeds)
        np.testing.assert_allclose(joints[-1, -1], points[-1], rtol=0, atol=1e-11)
        np.testing.assert_allclose(joints[-1, 0], base, rtol=0, atol=1e-14)
