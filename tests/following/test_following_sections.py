"""Following with sections of all kinds: ends on the path, whatever the kind, and directions that do not ring."""

import math
from itertools import pairwise

import numpy as np
import pytest
from following_oracles import GLIDING, SLIDER, random_path
from hypothesis import given, settings
from hypothesis import strategies as st

import hognose
from hognose.errors import InfeasibleError, InputError
from hognose.following import METHODS, OF_SECTIONS
from hognose.following.sections import AimedSections, ExactSections
from hognose.path import Path
from hognose.robot.sections import KINDS, RIGID_LINK, Geometry, MixedSections

seeds = st.integers(0, 2**32 - 1)
some = settings(deadline=None, max_examples=15)
both = pytest.mark.parametrize("method", ["exact", "aim"])


def model_of(kinds, pitches, joints=5, tool=0.0):
    """Sections of kinds and lengths (m)."""
    keys = {
        "joints": lambda pitch: {"joints": joints},
        "hinges": lambda pitch: {"axis_offset": 0.3 * pitch},
        "link": lambda pitch: {},
        "arc": lambda pitch: {},
    }
    blank = {"joints": None, "axis_offset": None, "disks": None}
    sections = [
        Geometry(float(pitch), 0.0, 0.0, 0.02, (0.7, 0.7), **{**blank, **keys[kind](pitch)})
        for kind, pitch in zip(kinds, pitches, strict=True)
    ]
    lengths = np.array(pitches, dtype=float)
    lengths[-1] += tool
    return MixedSections([KINDS[kind] for kind in kinds], sections, tool), lengths


def random_arm(rng, kinds=tuple(KINDS)):
    count = int(rng.integers(2, 13))
    tool = float(rng.choice([0.0, 0.02]))
    return model_of(rng.choice(kinds, count), rng.uniform(0.05, 0.1, count), int(rng.integers(2, 8)), tool)


def top_feed(path, lengths):
    return max(0.3, min(1.0, path.length - 1.3 * lengths.sum()))


def made_again(path, model, joints, feeds):
    """Ends of sections (T, n+1, 3) of the angles that belong to joints, on a base that lies on the path's run."""
    ends, _ = model.positions(model.angles(joints), feeds, np.empty(0))
    return ends


@some
@given(seeds, st.sampled_from([2, 3, 5]))
def test_ends_are_on_the_path_and_the_sections_reach_them(seed, order):
    rng = np.random.default_rng(seed)
    path, (model, lengths) = random_path(seed, "gentle", order), random_arm(rng)
    feeds = np.linspace(0.0, min(top_feed(path, lengths), 1.09), 80)  # the base stays on the run
    joints = hognose.follow(path, lengths, feeds, model=model)
    assert path.distance_to(joints).max() <= 1e-12
    np.testing.assert_allclose(joints[:, 0], path.point(feeds), rtol=0, atol=1e-13)
    start = path.point(0.0)
    assert np.abs(path.tangent(0.0) - [0, 0, 1]).max() < 1e-15
    again = made_again(path, model, joints - start, feeds)
    np.testing.assert_allclose(again + start, joints, rtol=0, atol=1e-12)


@both
@some
@given(seeds)
def test_forward_backward_in_jumps_and_at_once_the_configurations_are_the_same(method, seed):
    rng = np.random.default_rng(seed)
    path, (model, lengths) = random_path(seed), random_arm(rng)
    top = top_feed(path, lengths)
    feeds = np.linspace(0.0, top, 70)
    follower = hognose.follower(path, lengths, method, model=model)
    joints = follower.run(feeds)
    np.testing.assert_allclose(follower.run(feeds[::-1])[::-1], joints, rtol=0, atol=1e-12)
    order = rng.permutation(len(feeds))
    np.testing.assert_allclose(follower.run(feeds[order]), joints[order], rtol=0, atol=1e-12)
    stepped = [follower.step(float(feed)) for feed in feeds[::7]]
    np.testing.assert_allclose(stepped, joints[::7], rtol=0, atol=1e-12)
    fresh = [hognose.follower(path, lengths, method, model=model).step(float(feed)) for feed in feeds[::20]]
    np.testing.assert_allclose(fresh, joints[::20], rtol=0, atol=1e-12)


@both
@some
@given(seeds)
def test_the_tip_is_on_the_path(method, seed):
    rng = np.random.default_rng(seed)
    path, (model, lengths) = random_path(seed), random_arm(rng)
    joints = hognose.follow(path, lengths, np.linspace(0.0, top_feed(path, lengths), 60), method, model=model)
    assert path.distance_to(joints[:, -1]).max() <= 1e-12


@some
@given(seeds)
def test_stacks_of_one_joint_are_placed_as_links_are(seed):
    rng = np.random.default_rng(seed)
    path, lengths = random_path(seed), rng.uniform(0.05, 0.1, 8)
    feeds = np.linspace(0.0, top_feed(path, lengths), 60)
    links = hognose.follow(path, lengths, feeds)
    for kind in ("link", "joints"):
        model, _ = model_of([kind] * 8, lengths, joints=1)
        for method in ("exact", "aim"):  # a stack of one joint does not ring, so that there is nothing to aim
            found = hognose.follow(path, lengths, feeds, method, model=model)
            np.testing.assert_allclose(found, links, rtol=0, atol=1e-12)


def test_stacks_of_ever_more_joints_come_to_lie_as_arcs_do():
    """A plane path, on which nothing twists; the difference is a series in 1/k."""
    bent = np.linspace(0, 1.2, 12)[1:]
    curve = np.column_stack([0.6 * (1 - np.cos(bent)), np.zeros(11), 0.6 * np.sin(bent)])
    path = Path.through(np.concatenate([[[0, 0, 0]], curve]), 3, SLIDER).with_run(0.6)
    lengths, feeds = np.full(6, 0.1), np.linspace(0.0, 0.5, 11)
    arcs = hognose.follow(path, lengths, feeds, model=model_of(["arc"] * 6, lengths)[0])
    found = [
        hognose.follow(path, lengths, feeds, model=model_of(["joints"] * 6, lengths, 64 * 2**m)[0]) for m in range(4)
    ]
    assert np.abs(found[-1] - arcs).max() <= 1e-4
    for power in range(1, 4):
        found = [(2**power * fine - coarse) / (2**power - 1) for coarse, fine in pairwise(found)]
    np.testing.assert_allclose(found[0], arcs, rtol=0, atol=1e-9)


@both
def test_on_a_circle_arcs_lie_on_it(method):
    radius, length = 0.5, 0.1
    angle = np.linspace(0, 5.5, 600)
    path = Path.through(np.column_stack([radius * (1 - np.cos(angle)), 0 * angle, radius * np.sin(angle)]), 5)
    model, lengths = model_of(["arc"] * 8, [length] * 8)
    feeds = np.linspace(0.5, 1.5, 30)
    joints = hognose.follow(path, lengths, feeds, method, model=model)
    around = np.unwrap(np.arctan2(joints[..., 2], radius - joints[..., 0]), axis=1)
    np.testing.assert_allclose(np.diff(around, axis=1), length / radius, rtol=0, atol=1e-8)
    np.testing.assert_allclose(np.hypot(joints[..., 2], radius - joints[..., 0]), radius, rtol=0, atol=1e-9)


@both
def test_on_a_straight_path_sections_are_straight(method):
    direction = np.array([2.0, -1.0, 2.0]) / 3
    path = Path.through(np.outer([0.0, 2.0], direction) + 0.1)
    model, lengths = model_of(["arc", "joints", "hinges", "link", "arc"], [0.05, 0.08, 0.2, 0.09, 0.1], tool=0.03)
    feeds = np.array([0.0, 0.7, 0.3, 1.4])
    along = feeds[:, None] + np.append(0, np.cumsum(lengths))
    found = hognose.follow(path, lengths, feeds, method, model=model)
    np.testing.assert_allclose(found, path.point(0.0) + along[..., None] * direction, rtol=0, atol=1e-14)


@pytest.mark.parametrize(("method", "part"), [("exact", 0.0), ("aim", 0.35)])
@pytest.mark.parametrize("joints", [1, 2, 6, None])
def test_an_error_of_the_direction_comes_back_as_derived(method, part, joints):
    """From a base that points beside a straight path: the factor of one end to the next, at first order."""
    path = Path.through([[0, 0, 0], [0, 0, 3.0]])
    kind = "arc" if joints is None else "joints"
    model, lengths = model_of([kind] * 6, [0.1] * 6, joints=joints or 1)
    tilt = 1e-6
    axes = np.array([[1, 0, tilt], [0, 1, 0], [-tilt, 0, 1.0]])
    ends = hognose.follow(path, lengths, [0.5], method, model=model, axes=axes)[0]
    frames = axes @ np.eye(3)
    angles = model.angles((ends - ends[0])[None] @ frames)[0]
    direction = tilt + np.cumsum(angles[:, 0])
    gain = 0.5 if joints is None else (joints + 1) / (2 * joints)
    inverse = 0.0 if joints is None else 1 / joints
    weights = np.append(np.full(5, part * (1 - inverse)), 0.0)  # none at the tip
    expected, error, place = [], tilt, 0.0
    for weight in weights:
        # At first order: place + L (error + gain b) + weight L (error + b) = 0.
        bend = -(place / 0.1 + error * (1 + weight)) / (gain + weight)
        place += 0.1 * (error + gain * bend)
        error += bend
        expected.append(error)
    np.testing.assert_allclose(direction, expected, rtol=0, atol=1e-4 * tilt)
    if part == 0.0:
        factor = -1.0 if joints is None else -(joints - 1) / (joints + 1)
        np.testing.assert_allclose(expected, tilt * factor ** np.arange(1, 7), rtol=0, atol=1e-9 * tilt)
    else:
        factor = (part - 0.5) / (part + 0.5)
        if joints is None:
            assert expected[3] / expected[2] == pytest.approx(factor, rel=1e-9)


def arc_path():
    """A path whose curvature changes much: through three boards one way and the other."""
    places = [[0, 0, 0], [0, 0, 0.15], [0.05, 0.02, 0.35], [0.0, 0.08, 0.6], [0.06, 0.03, 0.85], [0.12, 0.1, 1.1]]
    return Path.through(np.array(places), 3, SLIDER).with_run(1.1)


def test_aimed_arcs_are_closer_to_the_path_than_those_that_ring():
    path = arc_path()
    model, lengths = model_of(["arc"] * 12, [0.091] * 12)
    feeds = np.linspace(0.3, path.length - 1.15, 120)
    away = {}
    for method in ("exact", "aim"):
        line = model.vertices(hognose.follow(path, lengths, feeds, method, model=model))
        away[method] = path.distance_to(line.reshape(-1, 3))
    assert away["aim"].max() < 0.75 * away["exact"].max()
    assert np.sqrt((away["aim"] ** 2).mean()) < 0.5 * np.sqrt((away["exact"] ** 2).mean())


def test_methods_for_links_say_that_they_are():
    path, (model, lengths) = arc_path(), model_of(["arc"] * 3, [0.1] * 3)
    for method in METHODS:
        if method not in OF_SECTIONS:
            with pytest.raises(InputError, match=f"method '{method}' is for arms of rigid links"):
                hognose.follower(path, lengths, method, model=model)
    assert set(OF_SECTIONS) & set(GLIDING) == {"exact"}


def test_a_method_for_other_sections_says_that_it_is():
    with pytest.raises(InputError, match="for rigid links take exact"):
        hognose.follower(arc_path(), [0.1] * 3, "aim")
    assert hognose.follower(arc_path(), [0.1] * 3, model=RIGID_LINK).name == "exact"


def test_an_arm_that_reaches_beyond_the_path_says_which_section():
    path = Path.through([[0, 0, 0], [0, 0, 1.0]])
    model, lengths = model_of(["arc"] * 4, [0.1] * 4)
    follower = hognose.follower(path, lengths, model=model)
    np.testing.assert_allclose(follower.step(0.6)[-1], [0, 0, 1.0], atol=1e-9)
    with pytest.raises(InfeasibleError, match=r"section 3 \(100 mm\).*Feed less, lengthen the path, or take 'fitted'"):
        follower.step(0.75)
    np.testing.assert_allclose(follower.step(0.5)[-1], [0, 0, 0.9], atol=1e-12)
    with pytest.raises(InputError, match="expected 0 to 1000"):
        follower.step(1.1)


def test_the_tip_comes_to_the_very_end_of_a_path():
    path = arc_path()
    for method, kind in ((ExactSections, "arc"), (AimedSections, "arc"), (ExactSections, "joints")):
        model, lengths = model_of([kind] * 10, [0.1] * 10)
        follower = method(path.with_end(1.0), model, lengths)
        low, high = 0.0, path.length - 0.5
        while high - low > 1e-13:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if follower.tip_arc(middle) < path.length else (low, middle)
        tip = method(path, model, lengths).step(low)[-1]
        np.testing.assert_allclose(tip, path.point(path.length), rtol=0, atol=1e-11)


def test_steps_need_few_distances():
    path = arc_path()
    model, lengths = model_of(["arc"] * 12, [0.091] * 12)
    follower = hognose.follower(path, lengths, model=model)
    feeds = np.arange(0.0, path.length - 1.15, 0.0035)
    follower.step(0.0)
    before = follower.evaluations
    follower.run(feeds)
    assert (follower.evaluations - before) / (12 * len(feeds)) < 2.2


def test_axes_of_the_base_turn_the_way_a_stack_leaves_its_plane():
    """The base turned about the path by a quarter turn: α and β change roles, and so do the joints of a stack."""
    path, (model, lengths) = arc_path(), model_of(["joints"] * 5, [0.1] * 5)
    feeds = [0.6, 0.9]
    turned = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    plain, other = (hognose.follow(path, lengths, feeds, model=model, axes=axes) for axes in (np.eye(3), turned))
    np.testing.assert_array_equal(hognose.follow(path, lengths, feeds, model=model), plain)
    assert 0 < np.abs(plain - other).max() < 1e-4
    ends, _ = model.positions(model.angles((other - other[:, :1]) @ turned), np.zeros(2), np.empty(0))
    np.testing.assert_allclose(ends @ turned.T, other - other[:, :1], rtol=0, atol=1e-13)


def test_a_bend_is_found_on_either_side_however_sharp_the_path():
    """Where the path turns by more than a right angle within a section, every step searches anew."""
    angle = np.linspace(0, 1.4 * math.pi, 12)[1:]
    ring = np.column_stack([0.06 * (1 - np.cos(angle)), np.zeros(11), 0.06 * np.sin(angle)])
    path = Path.through(np.concatenate([[[0, 0, 0]], ring]), 3, SLIDER).with_run(0.4)
    model, lengths = model_of(["arc"] * 2, [0.1] * 2)
    follower = hognose.follower(path, lengths, model=model)
    assert not follower.tracks
    feeds = np.linspace(0.15, 0.35, 30)
    joints = follower.run(feeds)
    assert path.distance_to(joints).max() <= 1e-12
    np.testing.assert_allclose(follower.run(feeds[::-1])[::-1], joints, rtol=0, atol=1e-12)


@pytest.mark.parametrize("joints", [2, 6, None])
def test_an_ideal_direction_does_not_ring_where_curvature_changes_steadily(joints):
    """On a clothoid in a plane, ends and directions that are aimed settle: ends of second order beside the path."""
    rate, length = 1.5, 0.1  # curvature 1.5 s
    s = np.linspace(0, 2.4, 4801)
    heading = rate * s**2 / 2
    places = np.concatenate([[0j], np.cumsum(np.exp(1j * (heading[1:] + heading[:-1]) / 2)) * (s[1] - s[0])])
    path = Path.through(np.column_stack([np.imag(places), 0 * s, np.real(places)])[::20], 5)
    kind = "arc" if joints is None else "joints"
    model, lengths = model_of([kind] * 12, [length] * 12, joints=joints or 1)
    ends = hognose.follow(path, lengths, [0.3], "aim", model=model)[0]
    beside = path.distance_to(ends)
    assert beside[5:-1].max() < 0.01 * rate * length**3
