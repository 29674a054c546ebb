"""An arm that extends moves as steadily as at rest: no jump, no posture missing, and still a function of the feed."""

import math

import numpy as np
import pytest

from hognose.evaluation.shapes import SHAPES, shape
from hognose.following import keyframes
from hognose.following.fit_freedom import Course, free
from hognose.following.fitted import FittedSections
from hognose.path import Path
from hognose.robot.sections import KINDS, Geometry, MixedSections

PITCH, RANGE, LIMIT = 0.03, (0.0165, 0.04), math.radians(75.0)
RUN = 3 * PITCH
LAST = 0.0885
#: Of each kind paths on which lengths with the same freedom everywhere jumped or had no posture, and others.
SEEDS = {"C": (0, 1), "S": (2, 4, 6, 10, 13, 15, 17), "screw": (0, 27), "robot": (0, 4, 7, 9, 69)}
PATHS = [(kind, seed) for kind, seeds in SEEDS.items() for seed in seeds]


def path_of(kind, seed):
    """A shape behind a run of the arm's length, and a straight end."""
    drawn = shape(kind, 0.077, np.random.default_rng([list(SHAPES).index(kind), seed]))
    return Path(drawn.breaks[1:], drawn.coefficients[1:]).with_run(RUN).with_end(0.05)


def arm(path, extends=True, **more):
    section = Geometry(PITCH, 0.0, 0.0, 0.002, (LIMIT, LIMIT), None, length_range=RANGE if extends else None)
    model = MixedSections([KINDS["arc"]] * 3, [section] * 3, 0.0)
    return FittedSections(path, model, np.full(3, PITCH), bend_limits=LIMIT, axes=np.eye(3), **more)


def largest_jump(made, feeds):
    """How far (m) a joint moves within 1e-9 m of feed, where most happens in an interval of feeds (T,)."""
    joints, largest = made.run(feeds), 0.0
    moved = np.abs(np.diff(joints, axis=0)).max(axis=(1, 2))
    beside = np.maximum(np.append(moved[1:], 0.0), np.append(0.0, moved[:-1]))
    suspects = {int(i) for i in [*np.argsort(moved)[-2:], *np.argsort(moved / (beside + 1e-6))[-2:]]}
    for i in suspects:
        low, high, before, after = feeds[i], feeds[i + 1], joints[i], joints[i + 1]
        while high - low > 1e-9:
            feed = 0.5 * (low + high)
            middle = made.step(feed)
            if np.abs(middle - before).max() > np.abs(after - middle).max():
                high, after = feed, middle
            else:
                low, before = feed, middle
        largest = max(largest, float(np.abs(after - before).max()))
    return largest


@pytest.mark.parametrize(("kind", "seed"), PATHS)
def test_an_arm_that_extends_does_not_jump_where_the_arm_at_rest_does_not(kind, seed):
    path, feeds = path_of(kind, seed), np.linspace(0.0, LAST, 355)
    assert largest_jump(arm(path, extends=False), feeds) < 1e-7
    made = arm(path)
    assert largest_jump(made, feeds) < 1e-7
    lengths = made.model.lengths(made.run(feeds), made.model.angles(made.run(feeds)))
    assert lengths.min() >= RANGE[0]
    assert lengths.max() <= RANGE[1]
    assert np.abs(lengths - PITCH).max() > 0.01 * PITCH
    assert path.distance_to(made.run(feeds)[:, -1]).max() < 1e-11


@pytest.mark.parametrize("seed", [9, 13])
def test_lengths_that_are_not_free_give_the_posture_of_the_arm_at_rest(seed):
    path = path_of("S", seed)
    made = arm(path)
    made.step(0.0)
    held = np.flatnonzero(made._keyframes.freedom == 0.0)
    feeds = made._stride * held[made._stride * held < LAST]
    assert feeds.size > 3
    np.testing.assert_allclose(made.run(feeds), arm(path, extends=False).run(feeds), rtol=0, atol=1e-9)


@pytest.mark.parametrize("kind", ["S", "robot"])
def test_a_pose_depends_on_the_feed_alone_where_lengths_are_less_free(kind):
    """From nothing each time: in any order, one by one, and with another straight end."""
    path, order = path_of(kind, 4), np.random.default_rng(0).permutation(25)
    feeds, found = np.linspace(0.0, LAST, 25), []
    for way in (np.arange(25), order, np.arange(25)[::-1]):
        keyframes._kept.clear()
        made = arm(path)
        found.append(made.run(feeds[way])[np.argsort(way)])
    assert made._keyframes.freedom[: round(LAST / made._stride)].min() < 0.5
    keyframes._kept.clear()
    made = arm(path.with_end(0.1))
    found.append(np.array([made.step(feed) for feed in feeds]))
    for each in found[1:]:
        np.testing.assert_array_equal(each, found[0])


def test_an_arm_that_extends_has_a_posture_wherever_the_arm_at_rest_has_one():
    """It had none at some of these feeds; in the last two, where rounding kept steps from getting small."""
    for kind, seed in (("S", 13), ("robot", 69), ("screw", 27), ("screw", 43), ("screw", 96)):
        feeds = np.linspace(0.0, 0.0884, 885)
        for extends in (False, True):
            assert np.isfinite(arm(path_of(kind, seed), extends).run(feeds)).all()


def test_on_a_carrier_and_on_gentle_paths_lengths_stay_as_free_as_they_are():
    made = arm(path_of("C", 0), carried=True)
    made.step(0.0)
    assert made._keyframes.freedom.min() == 1.0
    made = arm(path_of("C", 0))
    made.step(0.0)
    np.testing.assert_array_equal(made._keyframes.freedom[: math.floor(RUN / made._stride)], 1.0)


def test_lengths_go_back_to_rest_behind_the_run():
    found = free(1.0, 0.305, 0.01, 0.1)
    assert len(found) == 43
    np.testing.assert_array_equal(found[:31], 1.0)
    np.testing.assert_allclose(found[31:41], np.linspace(0.95, 0.05, 10), rtol=0, atol=1e-12)
    np.testing.assert_array_equal(found[41:], 0.0)
    np.testing.assert_array_equal(free(1.0, math.inf, 0.01, 0.1), np.ones(102))


def course(state, at_rest, count=41, stride=0.1):
    """A course of which states (angle, length) are functions of the place and the freedom, and its freedom."""
    freedom = np.ones(count)

    def states(places, keys=None):
        return np.array([state(place, freedom) for place in places])

    def keyed(known, to):
        return np.concatenate([known, states(range(len(known), to))])

    def rested(places, keys=None):
        return np.array([at_rest(place) for place in places])

    Course(keyed, states, 1, 2, stride, freedom, (rested(range(count - 1)), rested)).freed(np.empty((0, 2)))
    return freedom


def test_a_jump_that_is_too_small_to_be_fast_is_found_and_taken_away_where_it_is():
    def state(place, freedom):
        jumps = place > 17.3 and np.interp(17.3, np.arange(41), freedom) > 0.2
        return 0.02 * place + (max(0.03 - 0.003 * (place - 17.3), 0.0) if jumps else 0.0), 0.0

    found = course(state, lambda place: (0.02 * place, 0.0))
    assert found[[17, 18]].max() <= 0.2
    assert found[[17, 18]].min() > 0.0
    assert np.abs(np.diff(found)).max() <= 0.1 + 1e-12
    np.testing.assert_array_equal(found[:8], 1.0)
    np.testing.assert_array_equal(found[29:], 1.0)


@pytest.mark.parametrize("column", [0, 1])
def test_what_is_too_fast_is_slowed_down_but_for_what_the_arm_at_rest_does(column):
    """Angles may turn by 2 rad and lengths change by 0.5 in a feed of a mean section, ten keyframes."""
    limit, both = (0.2, 0.05)[column], {}

    def state(place, freedom):
        part = float(np.clip(place - 20.0, 0.0, 4.0))
        moved = np.zeros(2)
        moved[column] = 1.5 * limit * part * (0.5 + 0.5 * np.interp(place, np.arange(41), freedom))
        return moved

    for at_rest in (0.0, 1.5 * limit):
        both[at_rest] = course(state, lambda place, rate=at_rest: (rate * float(np.clip(place - 20.0, 0.0, 4.0)), 0.0))
    assert both[0.0][20:25].max() < 0.5
    np.testing.assert_array_equal(both[0.0][:9], 1.0)
    turns_as_at_rest = column == 0
    assert (both[1.5 * limit].min() == 1.0) == turns_as_at_rest


@pytest.mark.parametrize("lost_at_rest", [False, True])
def test_where_holding_lengths_helps_no_more_they_are_held_from_feed_0_on_unless_the_arm_at_rest_is_lost(lost_at_rest):
    """The arm came to another posture at keyframe 5, which ends at 25."""

    def state(place, freedom):
        return (math.nan, math.nan) if 25 < place < 26 and freedom[5] > 0.0 else (0.0, 0.0)

    found = course(state, lambda place: (math.nan, 0.0) if lost_at_rest and 25 < place < 26 else (0.0, 0.0))
    if lost_at_rest:
        np.testing.assert_array_equal(found, 1.0)
    else:
        np.testing.assert_array_equal(found[:27], 0.0)
        np.testing.assert_array_equal(found[36:], 1.0)


def test_where_the_arm_at_rest_jumps_lengths_stay_as_free_as_they_are():
    """Less freedom would only make the arm that extends jump as it does."""

    def state(place, freedom):
        held = np.interp(17.3, np.arange(41), freedom) < 1.0
        return 0.02 * place + (0.3 if place > (17.3 if held else 17.6) else 0.0), 0.0

    found = course(state, lambda place: (0.02 * place + (0.3 if place > 17.4 else 0.0), 0.0))
    np.testing.assert_array_equal(found, 1.0)


@pytest.mark.parametrize("calls", [3, 10, 20])
def test_a_search_that_was_interrupted_leaves_nothing_behind(calls):
    path, feeds, left = path_of("S", 4), np.linspace(0.0, LAST, 25), [calls]
    keyframes._kept.clear()
    expected = arm(path).run(feeds)
    keyframes._kept.clear()
    made = arm(path)
    states = made._states

    def interrupted(places, keys):
        left[0] -= 1
        if not left[0]:
            raise KeyboardInterrupt
        return states(places, keys)

    made._states = interrupted
    with pytest.raises(KeyboardInterrupt):
        made.run(feeds)
    np.testing.assert_array_equal(made.run(feeds), expected)
    np.testing.assert_array_equal(arm(path).run(feeds), expected)
