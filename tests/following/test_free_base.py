"""Sections on a base that goes along the path, and base and sections fitted together, against slow second opinions."""

import math

import numpy as np
import pytest
from following_oracles import SLIDER, arm, places
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import hognose
from hognose.errors import InputError
from hognose.evaluation.shapes import SHAPES, shape
from hognose.following.fit_model import assembled, laid
from hognose.following.fitted import FittedSections
from hognose.following.on_base import section_base
from hognose.following.samples import sampled
from hognose.following.sections import SectionFollower
from hognose.path import Path
from hognose.robot import Drum
from hognose.robot.sections import KINDS

seeds = st.integers(0, 2**32 - 1)
START = Rotation.from_rotvec([0.0, 0.0, 0.7])


def carried(path, model, lengths, method="fitted", limit=None, start=START):
    made = hognose.follower(path, lengths, method, 0.0005, limit, model, start.as_matrix(), True)
    assert isinstance(made, SectionFollower)
    return made


def frame_at(path, feed, start=START):
    """Axes of the start, turned the shortest way to the path's direction: by scipy."""
    before, ahead = start.apply(SLIDER), path.tangent(feed)
    axis = np.cross(before, ahead)
    sine = np.linalg.norm(axis)
    turn = axis / sine * math.atan2(sine, before @ ahead) if sine > 0 else axis
    return Rotation.from_rotvec(turn) * start


def cost_of(path, model, feed, x):
    """What is made smallest, for base and angles (4 + 2n,), and the tip (3,): written anew."""
    body, length = sampled(model), model.table[:, 2].sum() / (len(model.first) - 1)
    weights = body[5].copy()
    weights[: body[2][1]] /= 2.5  # the first section is as free as the others
    frame = frame_at(path, feed)
    base = path.point(feed) + frame.apply([length * x[0], length * x[1], 0.0])
    points = places(model, body, x[4:].reshape(-1, 2), (base, frame * Rotation.from_rotvec([x[3], x[2], 0.0])))
    half = 0.5 * path.distance_to(points[:-1]) ** 2
    tie = 1e-4 * length**2 * 0.5 * (x[:4] ** 2).sum()
    return float((weights * (half + 0.5 * body[6] * half**2)).sum() + tie), points[-1]


def unknowns(path, model, feed, joints, axes):
    """The place of the base across the path, how it is turned, and the angles: from a pose."""
    frame, length = frame_at(path, feed), model.table[:, 2].sum() / (len(model.first) - 1)
    across = frame.inv().apply(joints[0] - path.point(feed))
    turn = (frame.inv() * Rotation.from_matrix(axes)).as_rotvec()
    np.testing.assert_allclose([across[2], turn[2]], 0, rtol=0, atol=1e-12)  # beside the feed, and turned no further
    angles = model.angles((joints @ axes)[None])[0]
    return np.concatenate([across[:2] / length, turn[1::-1], angles.ravel()])


@pytest.mark.parametrize("limit", [1.57, 1.0])
def test_no_pose_of_base_and_sections_near_is_closer(limit):
    """scipy, with the cost and the tip's place on the path written anew, from beside the fit: the same minimum."""
    path = shape("S", 0.6, np.random.default_rng(5)).with_end(0.3)
    model, lengths = arm(["arc", "joints"], [0.3] * 2)
    made, feed = carried(path, model, lengths, limit=limit), 0.7
    joints, axes = (rows[0] for rows in made.run_with_axes([feed]))
    found = unknowns(path, model, feed, joints, axes)
    assert (np.abs(found[4:]).max() > limit - 1e-9) == (limit == 1.0)
    cost, tip = cost_of(path, model, feed, found)
    np.testing.assert_allclose(tip, joints[-1], rtol=0, atol=1e-12)
    assert path.distance_to(tip) < 1e-12
    arc = made.tip_arc(feed)

    def off(x):
        return cost_of(path, model, feed, x[:-1])[1] - path.point(min(max(x[-1], 0), path.length))

    rng = np.random.default_rng(0)
    beside = found + rng.normal(0, 0.02, 8)
    beside[4:] = np.clip(beside[4:], -limit, limit)
    bounds = [(-1.0, 1.0)] * 4 + [(-limit, limit)] * 4 + [(0.0, path.length)]
    slow = minimize(
        lambda x: 1e4 * cost_of(path, model, feed, x[:-1])[0],
        np.append(beside, arc + 0.01),
        method="SLSQP",
        bounds=bounds,
        constraints={"type": "eq", "fun": off},
        options={"ftol": 1e-11, "maxiter": 100},
    )
    assert np.abs(off(slow.x)).max() < 1e-7
    assert 1e-4 * slow.fun >= cost * (1 - 1e-5)
    np.testing.assert_allclose(slow.x[:-1], found, rtol=0, atol=5e-3)


def test_derivatives_by_place_and_direction_of_the_base_are_those_of_differences():
    path, (model, lengths) = shape("screw", 0.6, np.random.default_rng(3)), arm(["arc", "joints"], [0.3, 0.3])
    made = FittedSections(path, model, lengths, axes=START.as_matrix(), carried=True)
    made.step(0.45)
    (body, _, _), (chain, rest, _), row = made._fit, made._room, round(0.45 / made._stride)
    state, base = made._keyframes.found[0][row].copy(), row * made._stride
    feet, pull, origin = state[8:-3] + base + path.breaks[0], state[-3:], path.point(base)
    chain[1][0] = frame_at(path, base).as_matrix().T

    def at(flat, second=True):
        laid(body, flat.reshape(-1, 2), second, chain)
        cost = assembled(made._pieces, body, origin, pull, feet, second, chain, rest)
        return cost + pull @ (rest[4].T @ rest[2]), np.tril(rest[1]) + np.tril(rest[1], -1).T, rest[0].copy()

    angles, step = state[:8] + 0.05, 1e-5 * np.eye(8)
    _, square, gradient = at(angles)
    through = rest[3].T @ (rest[4] @ pull)
    for a in range(8):
        slope = (at(angles + step[a], False)[0] - at(angles - step[a], False)[0]) / 2e-5
        assert slope == pytest.approx(gradient[a] + through[a], rel=1e-4, abs=1e-7)
        for b in range(4):
            second = at(angles + step[a] + step[b], False)[0] - at(angles + step[a] - step[b], False)[0]
            second += at(angles - step[a] - step[b], False)[0] - at(angles - step[a] + step[b], False)[0]
            assert second / 4e-10 == pytest.approx(square[a, b], abs=1e-3 * np.abs(square).max())


@settings(deadline=None, max_examples=4)
@given(seeds)
def test_a_pose_of_base_and_sections_depends_on_the_feed_alone_to_the_last_bit(seed):
    rng = np.random.default_rng(seed)
    path = shape(str(rng.choice(list(SHAPES))), 0.6, rng).with_end(0.4)
    count = int(rng.integers(2, 6))
    kinds = rng.choice(list(KINDS), count)
    model, lengths = arm(kinds, np.full(count, 0.6 / count), int(rng.integers(2, 6)))
    feeds = np.linspace(0.0, 0.65, 13)
    made = carried(path, model, lengths)
    joints, axes = made.run_with_axes(feeds)
    for way in (np.arange(13)[::-1], rng.permutation(13)):
        again, turned = carried(path, model, lengths).run_with_axes(feeds[way])
        np.testing.assert_array_equal(again, joints[way])
        np.testing.assert_array_equal(turned, axes[way])
    assert path.distance_to(joints[:, -1]).max() < 1e-12
    np.testing.assert_allclose(joints[0], path.point(np.append(0, np.cumsum(lengths))), rtol=0, atol=1e-12)
    np.testing.assert_allclose(axes[0], START.as_matrix(), rtol=0, atol=1e-12)
    for feed, pose, turn in zip(feeds, joints, axes, strict=True):
        x = unknowns(path, model, feed, pose, turn)
        if kinds[0] in ("link", "hinges"):  # their first joint does what the base's direction would
            np.testing.assert_allclose(x[2:4], 0, rtol=0, atol=1e-9)
        assert np.abs(x[4:]).max() <= math.pi / 2 + 1e-12
        line = places(model, sampled(model), x[4:].reshape(-1, 2), (pose[0], Rotation.from_matrix(turn)))
        np.testing.assert_allclose(line[-1], pose[-1], rtol=0, atol=1e-12)


def test_three_sections_with_a_free_base_are_closer_in_the_mean_and_at_worst():
    for kind in ("S", "C", "screw"):
        path = shape(kind, 1.0, np.random.default_rng(7))
        model, lengths = arm(["arc"] * 3, [1 / 3] * 3)
        feeds, away = np.linspace(0.0, 1.0, 20), {}
        for free in (False, True):
            made = FittedSections(path, model, lengths, axes=np.eye(3), carried=free)
            joints, axes = made.run_with_axes(feeds)
            line = np.einsum("tij,tnj->tni", axes, model.vertices(joints @ axes))
            away[free] = 100 * path.distance_to(line).mean(axis=1)
        assert away[True].mean() < 0.85 * away[False].mean()
        assert away[True].max() < 0.7 * away[False].max()
        assert away[True].mean() <= 0.7


@pytest.mark.parametrize("method", ["exact", "aim"])
def test_other_methods_begin_on_the_path_in_its_direction(method):
    path = Path.through([[0, 0, 0], [0, 0, 0.6], [0.1, 0.1, 1.0], [0.1, 0.3, 1.4], [0.0, 0.4, 1.9]], 3, SLIDER)
    model, lengths = arm(["arc", "joints", "arc", "hinges"], [0.1] * 4)
    feeds = np.array([0.0, 0.4, 0.8, 1.1])
    joints, axes = carried(path, model, lengths, method).run_with_axes(feeds)
    for feed, pose, turn in zip(feeds, joints, axes, strict=True):
        np.testing.assert_allclose(unknowns(path, model, feed, pose, turn)[:4], 0, rtol=0, atol=1e-9)
    if method == "exact":
        assert path.distance_to(joints).max() < 1e-12
    np.testing.assert_array_equal(carried(path, model, lengths, method).run(feeds[:1]), joints[:1])


@pytest.mark.parametrize("method", ["exact", "aim", "fitted"])
@pytest.mark.parametrize("free", [False, True])
def test_axes_that_do_not_lie_along_the_path_are_refused(method, free):
    path = shape("S", 0.6, np.random.default_rng(1))
    model, lengths = arm(["arc"] * 3, [0.2] * 3)
    across = Rotation.from_rotvec([0.0, 0.01, 0.0]) * START
    said = r"axes: the third one is \(0\.0\d+, .*\), and the path begins along \(0, 0, 1\); expected the same direction"
    with pytest.raises(InputError, match=said):
        hognose.follower(path, lengths, method, model=model, axes=across.as_matrix(), carried=free)


def test_a_base_of_links_is_not_carried_by_their_follower():
    path = shape("S", 0.6, np.random.default_rng(1))
    with pytest.raises(InputError, match="carried: joints of rigid links say by themselves how a carrier holds them"):
        hognose.follow(path, np.full(6, 0.1), [0.0], carried=True)


def test_sections_on_a_drum_have_no_axes_to_begin_with():
    links = hognose.load_robot("sjtu-25dof")
    drum = Drum.before(np.zeros(3), links, 0.28, 0.2, np.eye(3))
    with pytest.raises(InputError, match="from a slider, a cart or a carrier, not from a base of type Drum"):
        section_base(drum)
