"""The whole-arm fit: derivatives and minima against slow second opinions, limits, and what it promises."""

import numpy as np
import pytest
from following_oracles import SLIDER, arm, places
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

import hognose
from hognose.errors import InfeasibleError
from hognose.evaluation.shapes import SHAPES, shape
from hognose.following.fit_model import assembled, laid
from hognose.following.fitted import FittedSections
from hognose.path import Path
from hognose.robot.sections import KINDS

seeds = st.integers(0, 2**32 - 1)
some = settings(deadline=None, max_examples=4)


def follower(path, model, lengths, limit=None):
    return FittedSections(path, model, lengths, bend_limits=limit, axes=np.eye(3))


def cost_of(path, model, body, base, angles):
    """What is made smallest, and the tip (3,)."""
    points = base + places(model, body, angles)
    half = 0.5 * path.distance_to(points[:-1]) ** 2
    return float((body[5] * (half + 0.5 * body[6] * half**2)).sum()), points[-1]


def bent_path(seed=3):
    return shape("screw", 0.6, np.random.default_rng(seed))


MIXED = (["arc", "joints", "link", "hinges", "arc"], [0.15, 0.12, 0.08, 0.1, 0.13])


@pytest.mark.parametrize("kinds", [MIXED, (["arc"] * 3, [0.2] * 3)], ids=["mixed", "arcs"])
def test_derivatives_are_those_of_differences(kinds):
    """Gradient and second derivatives with the tip's multiplier, near a fit: of half the cost's second differences."""
    path, (model, lengths) = bent_path(), arm(*kinds, tool=0.02)
    made = follower(path, model, lengths)
    feed = 0.45
    made.step(feed)
    body, chain, rest = made._fit[0], made._room[0], made._room[1]
    state = made._keyframes.found[0][round(feed / made._stride)].copy()
    size, base = 2 * len(lengths), np.array([0, 0, round(feed / made._stride) * made._stride])
    feet, pull = state[size:-3] + base[2] + path.breaks[0], state[-3:]
    angles = state[:size]
    chain[1][0] = np.eye(3)

    def at(flat, second=True):
        laid(body, flat.reshape(-1, 2), second, chain)
        cost = assembled(made._pieces, body, base, pull, feet, second, chain, rest)
        return cost, rest[0].copy(), np.tril(rest[1]) + np.tril(rest[1], -1).T, rest[3].copy(), rest[2].copy()

    cost, gradient, square, rates, apart = at(angles)
    slow, tip = cost_of(path, model, body, base, angles.reshape(-1, 2))
    assert cost == pytest.approx(slow, rel=1e-9)
    np.testing.assert_allclose(chain[0][-1] + base, tip, rtol=0, atol=1e-13)
    assert np.abs(apart).max() < 1e-13
    assert path.distance_to(tip) < 1e-13
    across = rest[4].copy()
    total = gradient + (across @ pull) @ rates
    assert np.abs(total).max() < 1e-8 * np.abs(gradient).max()  # the fit is stationary
    assert np.abs(pull).max() > 0

    step = 1e-5
    for a in range(size):
        moved = np.zeros(size)
        moved[a] = step
        high, low = at(angles + moved), at(angles - moved)
        assert (high[0] - low[0]) / (2 * step) == pytest.approx(gradient[a], rel=1e-5, abs=1e-9)

    # Second differences of the cost and of the multiplier times the tip's way off, whatever its basis.
    def whole(flat):
        cost, *_ = at(flat, second=False)
        return cost + pull @ (rest[4].T @ rest[2])

    wide = 1e-5
    eye = wide * np.eye(size)
    scale = np.abs(square).max()
    for a in range(size):
        for b in range(a + 1):
            second = whole(angles + eye[a] + eye[b]) - whole(angles + eye[a] - eye[b])
            second += whole(angles - eye[a] - eye[b]) - whole(angles - eye[a] + eye[b])
            assert second / (4 * wide**2) == pytest.approx(square[a, b], abs=2e-5 * scale)


@pytest.mark.parametrize(("kind", "limit"), [("screw", 1.5), ("S", 0.45)])
def test_no_posture_near_is_closer_than_the_fit(kind, limit):
    """scipy, with the cost and the tip's place on the path written anew, from beside the fit: the same minimum."""
    path = shape(kind, 0.6, np.random.default_rng(5))
    model, lengths = arm(["arc"] * 3, [0.2] * 3)
    made = follower(path, model, lengths, limit)
    base, body = np.array([0, 0, 0.5]), made._fit[0]
    joints = made.step(0.5)
    angles = model.angles((joints - joints[0])[None])[0]
    assert np.abs(angles).max() <= limit + 1e-12
    bound = np.abs(angles).max() > limit - 1e-9
    assert bound == (limit < 1)
    cost, tip = cost_of(path, model, body, base, angles)
    assert path.distance_to(tip) < 1e-13
    arc = float(path.arc_length(made._parameters[0])[0])

    def off(x):
        return places(model, body, x[:-1].reshape(-1, 2))[-1] + base - path.point(min(max(x[-1], 0), path.length))

    rng = np.random.default_rng(0)
    start = np.append(np.clip(angles.ravel() + rng.normal(0, 0.05, 6), -limit, limit), arc + 0.01)
    found = minimize(
        lambda x: 1e4 * cost_of(path, model, body, base, x[:-1].reshape(-1, 2))[0],
        start,
        method="SLSQP",
        bounds=[(-limit, limit)] * 6 + [(0.0, path.length)],
        constraints={"type": "eq", "fun": off},
        options={"ftol": 1e-11, "maxiter": 60},
    )
    assert np.abs(off(found.x)).max() < 1e-5  # where it ends depends on how a processor rounds
    assert 1e-4 * found.fun >= cost * (1 - 1e-5)
    np.testing.assert_allclose(found.x[:-1], angles.ravel(), rtol=0, atol=2e-3)


@some
@given(seeds)
def test_a_pose_depends_on_the_feed_alone_to_the_last_bit(seed):
    rng = np.random.default_rng(seed)
    path = shape(str(rng.choice(list(SHAPES))), 0.6, rng).with_end(0.3)
    count = int(rng.integers(1, 7))
    kinds = rng.choice(list(KINDS), count)
    model, lengths = arm(kinds, np.full(count, 0.6 / count), int(rng.integers(2, 6)))
    feeds = np.linspace(0.0, 0.65, 13)
    made = follower(path, model, lengths)
    joints = made.run(feeds)
    np.testing.assert_array_equal(made.run(feeds[::-1])[::-1], joints)
    order = rng.permutation(len(feeds))
    np.testing.assert_array_equal(follower(path, model, lengths).run(feeds[order]), joints[order])
    np.testing.assert_array_equal(follower(path, model, lengths).step(float(feeds[9])), joints[9])
    assert path.distance_to(joints[:, -1]).max() < 1e-12
    np.testing.assert_allclose(joints[:, 0], path.point(feeds), rtol=0, atol=1e-13)
    joints, feeds = joints[feeds <= 0.6], feeds[feeds <= 0.6]  # where the base is on its straight run
    again, _ = model.positions(model.angles(joints - path.point(0.0)), feeds, np.empty(0))
    np.testing.assert_allclose(again, joints, rtol=0, atol=1e-12)


def test_on_a_circle_arcs_are_fitted_to_lie_on_it():
    radius = 0.5
    angle = np.linspace(0, 5.5, 600)
    path = Path.through(np.column_stack([radius * (1 - np.cos(angle)), 0 * angle, radius * np.sin(angle)]), 5)
    model, lengths = arm(["arc"] * 3, [0.3] * 3)
    joints = FittedSections(path, model, lengths).run([0.5, 1.0])
    around = np.unwrap(np.arctan2(joints[..., 2], radius - joints[..., 0]), axis=1)
    np.testing.assert_allclose(np.diff(around, axis=1), 0.3 / radius, rtol=0, atol=1e-8)
    np.testing.assert_allclose(np.hypot(joints[..., 2], radius - joints[..., 0]), radius, rtol=0, atol=1e-9)


def test_the_body_is_closer_than_with_any_other_method():
    places_ = [[0, 0, 0], [0, 0, 0.15], [0.05, 0.02, 0.35], [0.0, 0.08, 0.6], [0.06, 0.03, 0.85], [0.12, 0.1, 1.1]]
    path = Path.through(np.array(places_), 3, SLIDER).with_run(1.1)
    for count, part in ((12, 0.9), (4, 0.85)):
        model, lengths = arm(["arc"] * count, [1.0 / count] * count)
        feeds = np.linspace(0.2, 1.05, 40)
        rms = {}
        for method in ("exact", "aim", "fitted"):
            line = model.vertices(hognose.follow(path, lengths, feeds, method, model=model, axes=np.eye(3)))
            rms[method] = float(np.sqrt((path.distance_to(line) ** 2).mean()))
        assert rms["fitted"] < part * min(rms["exact"], rms["aim"])


def test_what_no_posture_within_the_limits_reaches_is_said():
    path = shape("C", 0.6, np.random.default_rng(1))
    model, lengths = arm(["arc"] * 2, [0.3] * 2)
    made = follower(path, model, lengths, 0.05)
    made.step(0.0)
    with pytest.raises(InfeasibleError, match="no posture within the bend limits was found"):
        made.step(0.55)
    with pytest.raises(InfeasibleError, match=r"link 2 .* cannot reach"):
        follower(Path.through([[0, 0, 0], [0, 0, 1.0]]), model, lengths).step(0.5)


def test_keyframes_are_found_once_for_all_followers_of_a_path_however_long_its_straight_end():
    """What is shared changes nothing, to the last bit, and another arm or another path shares nothing."""
    path, (model, lengths) = shape("C", 0.6, np.random.default_rng(11)), arm(["arc"] * 3, [0.2] * 3)
    feeds = np.linspace(0.0, 0.6, 9)

    def found(path, limit=None):
        made = follower(path, model, lengths, limit)
        return made.run(feeds), made.evaluations

    alone, cost = found(path)
    again, less = found(path.with_end(0.1).with_end(0.2))
    assert np.array_equal(alone, again)
    assert less < 0.6 * cost
    assert found(path, 1.2)[1] > 0.8 * cost
    assert found(shape("C", 0.6, np.random.default_rng(12)))[1] > 0.6 * cost
