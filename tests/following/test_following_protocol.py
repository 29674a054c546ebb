import tracemalloc

import numpy as np
import pytest
from following_oracles import FIRST_CROSSING, GLIDING, ON_PATH, random_path

import hognose
from hognose.errors import InfeasibleError, InputError
from hognose.path import Path

methods = pytest.mark.parametrize("method", list(hognose.METHODS))
gliding = pytest.mark.parametrize("method", GLIDING)
on_path = pytest.mark.parametrize("method", ON_PATH)
first_crossing = pytest.mark.parametrize("method", FIRST_CROSSING)
LENGTHS = np.full(12, 0.091)


@pytest.fixture(scope="module")
def path():
    return random_path(7)


@methods
def test_a_run_is_its_steps_one_by_one(path, method):
    feeds = np.concatenate([np.arange(0, 0.05, 0.0035), [0.2, 0.85, 0.2, 0.2], np.linspace(0.9, 0, 8)])
    feeds = feeds[::7] if method == "optimization" else feeds  # it takes by far the longest
    whole = hognose.follow(path, LENGTHS, feeds, method)
    follower = hognose.follower(path, LENGTHS, method)
    for row, feed in zip(whole, feeds, strict=True):
        np.testing.assert_allclose(follower.step(feed), row, rtol=0, atol=1e-14)
    other = hognose.follower(path, LENGTHS, method)
    parts = [other.run(feeds[:5]), other.run([]), other.run(feeds[5:])]
    np.testing.assert_allclose(np.concatenate(parts), whole, rtol=0, atol=1e-14)


@methods
def test_the_way_to_a_feed_does_not_change_the_answer(path, method):
    """Fresh, in fine or coarse steps, backward, in any order: where the arm lies is a matter of the feed alone."""
    feeds = np.array([0.0, 0.0021, 0.1, 0.3333, 0.6006, 0.777, 0.9])
    fresh = np.array([hognose.follower(path, LENGTHS, method).step(feed) for feed in feeds])
    follower = hognose.follower(path, LENGTHS, method)
    ways = [
        np.unique(np.concatenate([feeds, np.arange(0, 0.9, 0.0035)])),
        np.unique(np.concatenate([feeds, np.arange(0, 0.9, 0.02)])),
        feeds[::-1],
        feeds[[3, 6, 0, 5, 1, 4, 2]],
    ]
    for way in ways:
        for one in (follower, hognose.follower(path, LENGTHS, method)):
            found = one.run(way)[[int(np.flatnonzero(way == feed)[0]) for feed in feeds]]
            np.testing.assert_allclose(found, fresh, rtol=0, atol=2 * follower.tolerance)


@methods
def test_what_a_step_returns_is_the_callers_own(path, method):
    follower = hognose.follower(path, LENGTHS, method)
    first = follower.step(0.1)
    kept = first.copy()
    second = follower.step(0.5)
    np.testing.assert_array_equal(first, kept)
    second[:] = np.nan
    assert np.isfinite(follower.step(0.5)).all()


@methods
def test_lengths_are_copied_and_feeds_left_alone(path, method):
    lengths, feeds = LENGTHS.copy(), np.linspace(0, 0.5, 30)
    follower = hognose.follower(path, lengths, method)
    before = follower.run(feeds)
    lengths[:] = 0.01
    np.testing.assert_allclose(follower.run(feeds), before, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(feeds, np.linspace(0, 0.5, 30))
    np.testing.assert_allclose(follower.run(np.repeat(feeds, 2)[::2]), before, rtol=0, atol=1e-12)
    np.testing.assert_allclose(follower.run(feeds.tolist()), before, rtol=0, atol=1e-12)


@gliding
def test_a_thousand_steps_take_no_more_memory_than_one(path, method):
    follower = hognose.follower(path, LENGTHS, method)
    feeds = np.random.default_rng(0).uniform(0, 0.9, 1000)
    follower.run(feeds[:3])
    tracemalloc.start()
    for feed in feeds[:200]:
        follower.step(feed)
    before = tracemalloc.get_traced_memory()[0]
    for feed in feeds:
        follower.step(feed)
    after = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    assert after - before < 8_000, "bytes; a number a step would be kept"


@on_path
def test_an_arm_of_1200_links_follows(method):
    path = random_path(11, run=1.5)
    lengths = np.full(1200, 0.001)
    feeds = np.linspace(0.2, path.length - 1.25, 20)
    follower = hognose.follower(path, lengths, method, 0.0001)
    joints = follower.run(feeds)
    assert joints.shape == (20, 1201, 3)
    links = np.linalg.norm(np.diff(joints, axis=1), axis=2)
    np.testing.assert_allclose(links, 0.001, rtol=0, atol=follower.tolerance)
    assert path.distance_to(joints).max() <= follower.tolerance


@first_crossing
def test_a_link_longer_than_bends_and_pieces_spans_them(method):
    path = random_path(3, "wild", run=0.2)
    link = np.array([0.9 * np.linalg.norm(path.point(path.length) - path.point(0.0))])
    follower = hognose.follower(path, link, method)
    joints = follower.step(0.0)
    assert np.linalg.norm(joints[1] - joints[0]) == pytest.approx(link[0], abs=follower.tolerance)


@first_crossing
def test_a_polyline_is_followed_round_its_corners(method):
    corner = Path.through([[0, 0, 0], [0, 0, 1], [0, 1, 1]], 1)
    follower = hognose.follower(corner, [0.1, 0.1], method, 0.0005)
    feeds = np.array([0.5, 0.92, 0.97, 1.0])
    joints = follower.run(feeds)
    assert follower.tolerance < 1e-3
    # Before the corner, the first joint past it is at y = sqrt(L² - (1 - z)²).
    first = np.where(feeds < 0.9, 0.0, np.sqrt(np.maximum(0.01 - (1 - feeds) ** 2, 0)))
    np.testing.assert_allclose(joints[1:, 1, 1], first[1:], rtol=0, atol=4 * follower.tolerance)
    np.testing.assert_allclose(joints[1:, 2, 1], first[1:] + 0.1, rtol=0, atol=6 * follower.tolerance)
    np.testing.assert_allclose(joints[0, :, 2], [0.5, 0.6, 0.7], rtol=0, atol=2 * follower.tolerance)


@on_path
def test_a_link_that_cannot_reach_is_named_with_step_place_and_numbers(method):
    line = Path.through([[0, 0, 0], [0, 0, 0.5]], 1)
    feeds = [0.0, 0.1, 0.15, 0.3]
    with pytest.raises(InfeasibleError) as caught:
        hognose.follow(line, [0.15, 0.1, 0.05], feeds, method)
    text = str(caught.value)
    for words in (
        "step 3, feed 300.00 mm",
        "link 2 (100 mm) cannot reach",
        "joint at (0, 0, 450) mm",
        "ends after 50.00 mm",
    ):
        assert words in text, words


@gliding
def test_a_follower_goes_on_after_a_link_that_could_not_reach(path, method):
    follower = hognose.follower(path, LENGTHS, method)
    feeds = np.linspace(0, 0.8, 50)
    expected = follower.run(feeds)
    for bad in (path.length, path.length - 0.5):
        with pytest.raises(InfeasibleError):
            follower.step(bad)
        np.testing.assert_allclose(follower.step(0.8), expected[-1], rtol=0, atol=1e-11)
        with pytest.raises(InfeasibleError):
            follower.run([0.1, bad, 0.2])
        np.testing.assert_allclose(follower.run(feeds[::-1]), expected[::-1], rtol=0, atol=1e-11)
        with pytest.raises(InputError):
            follower.step(-1.0)
        np.testing.assert_allclose(follower.step(0.0), expected[0], rtol=0, atol=1e-11)


@on_path
@pytest.mark.parametrize("short", [1e-6, 1e-4, 3e-4])
def test_a_path_too_short_by_less_than_a_point_is_still_too_short(method, short):
    """Either the follower says so, or its joints are as close to the path as it promises.

    Snapped joints drift by up to half a point a link, so that much may stick out of the path's end.
    """
    line = Path.through([[0, 0, 0], [0, 0, 0.50013]], 1)
    follower = hognose.follower(line, [0.1, 0.1], method, 0.0005)
    try:
        joints = follower.step(line.length - 0.2 + short)
    except InfeasibleError:
        return
    drift = 3 if method in ("prediction", "iterative") else 1
    assert line.distance_to(joints).max() <= drift * follower.tolerance
    links = np.linalg.norm(np.diff(joints, axis=0), axis=1)
    np.testing.assert_allclose(links, 0.1, rtol=0, atol=follower.tolerance)


@on_path
def test_a_path_just_long_enough_is_long_enough(method):
    line = Path.through([[0, 0, 0], [0, 0, 0.50013]], 1)
    follower = hognose.follower(line, [0.1, 0.1], method, 0.0005)
    joints = follower.step(line.length - 0.2 - 1e-12)
    accuracy = 3 * follower.tolerance
    np.testing.assert_allclose(joints[:, 2], line.length - np.array([0.2, 0.1, 0]), rtol=0, atol=accuracy)


@methods
@pytest.mark.parametrize("bad", [-1e-9, -1.0, 1e6, np.nan, np.inf])
def test_feeds_outside_the_path_are_named(path, method, bad):
    follower = hognose.follower(path, LENGTHS, method)
    with pytest.raises(InputError, match="feeds: step 0 is"):
        follower.step(bad)
    with pytest.raises(InputError, match="feeds: step 2 is") as caught:
        follower.run([0.0, 0.1, bad, 0.2])
    assert f"expected 0 to {1e3 * path.length:.3f} mm" in str(caught.value)
    with pytest.raises(InputError, match=r"feeds: expected .* \(T,\), got shape \(2, 2\)"):
        follower.run(np.zeros((2, 2)))


@methods
@pytest.mark.parametrize(
    "lengths", [[], [0.1, 0.0], [0.1, -0.1], [np.nan], [np.inf], [[0.1, 0.1]], 0.1, "long", [[0.1], [0.1, 0.2]]]
)
def test_link_lengths_must_be_positive_numbers(path, method, lengths):
    with pytest.raises(InputError, match="link_lengths"):
        hognose.follower(path, lengths, method)


@pytest.mark.parametrize("method", ["prediction", "interpolation", "iterative"])
@pytest.mark.parametrize("spacing", [0.0, -0.001, np.nan, 1e3, 1e-9])
def test_a_spacing_that_does_not_suit_the_path_is_named(path, method, spacing):
    with pytest.raises(InputError, match="spacing"):
        hognose.follow(path, LENGTHS, [0.0], method, spacing)


def test_an_unknown_method_is_answered_with_the_known_ones():
    with pytest.raises(InputError) as caught:
        hognose.follow(random_path(1), LENGTHS, [0.0], "predicton")
    assert "'predicton' is unknown; did you mean 'prediction'?" in str(caught.value)
    for name in hognose.METHODS:
        assert name in str(caught.value)
    with pytest.raises(InputError, match=f"Methods: {', '.join(hognose.METHODS)}"):
        hognose.follower(random_path(1), LENGTHS, "zzz")


def test_the_table_of_methods_knows_them_by_their_own_names():
    assert next(iter(hognose.METHODS)) == "exact"
    assert {name: method.name for name, method in hognose.METHODS.items()} == {n: n for n in hognose.METHODS}


@methods
def test_points_as_far_apart_as_a_link_is_long_are_refused(path, method):
    with pytest.raises(InputError, match=r"spacing: 90 mm is not below the shortest link, 90 mm"):
        hognose.follow(path, [0.1, 0.09], [0.1], method=method, spacing=0.09)
