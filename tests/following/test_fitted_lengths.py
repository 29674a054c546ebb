"""The whole-arm fit of sections that extend: derivatives and minima against slow second opinions, and its limits."""

import numpy as np
import pytest
from following_oracles import places
from scipy.optimize import minimize

import hognose
from hognose.errors import InfeasibleError
from hognose.evaluation.shapes import SHAPES, shape
from hognose.following.fit_lengths import lengthened, lengths_set
from hognose.following.fit_model import assembled, laid
from hognose.following.fitted import FittedSections
from hognose.robot.sections import KINDS, Geometry, MixedSections

RANGE = (0.11, 0.27)


def arm(kinds=("arc", "arc", "arc"), fixed=(), length_range=RANGE):
    """A model of sections of 0.2 m, of which the arcs extend unless they are fixed, and their lengths."""
    sections = []
    for i, kind in enumerate(kinds):
        extends = length_range if kind == "arc" and i not in fixed else None
        joints = 4 if kind == "joints" else None
        sections.append(Geometry(0.2, 0.0, 0.0, 0.01, (1.5, 1.5), joints, length_range=extends))
    return MixedSections([KINDS[kind] for kind in kinds], sections, 0.0), np.full(len(kinds), 0.2)


def follower(path, model, lengths, limit=None, **more):
    return FittedSections(path, model, lengths, bend_limits=limit, axes=np.eye(3), **more)


def lengthened_model(model, longer):
    """The same sections with other pitches, as they are with so much (n,) m more."""
    return MixedSections(
        model.kinds,
        [Geometry(s.pitch + d, 0, 0, 0.01, (1.5, 1.5), s.joints) for s, d in zip(model.sections, longer, strict=True)],
        0.0,
    )


def cost_of(path, model, body, base, angles, longer):
    """What is made smallest but for the ties, and the tip (3,), of sections that are so much (n,) m longer."""
    points = base + places(lengthened_model(model, longer), body, angles)
    half = 0.5 * path.distance_to(points[:-1]) ** 2
    return float((body[5] * (half + 0.5 * body[6] * half**2)).sum()), points[-1]


def tied(made, parts, feed):
    """What the ties add at a feed, of how much longer sections are in parts of a mean one."""
    ties, stretch, freedom = made._fit[2], made._stretch, made._keyframes.freedom
    own = ties[ties.size - parts.size :] / np.interp(feed / made._stride, np.arange(freedom.size), freedom) ** 2
    return float(0.5 * (own * parts**2).sum() + 0.5 * stretch[5] * parts.sum() ** 2)


@pytest.mark.parametrize(
    ("kinds", "fixed"), [(("arc",) * 3, ()), (("arc", "link", "arc", "joints"), ()), (("arc",) * 4, (1,))]
)
def test_derivatives_are_those_of_differences(kinds, fixed):
    """Gradient, second derivatives with the tip's multiplier, and rates of the tip, near a fit."""
    path = shape("screw", 0.2 * len(kinds), np.random.default_rng(3))
    model, lengths = arm(kinds, fixed)
    made = follower(path, model, lengths)
    feed = 0.15 * len(kinds)
    made.step(feed)
    body, stretch, chain, rest = made._fit[0], made._stretch, made._room[0], made._room[1]
    key = round(feed / made._stride)
    state = made._keyframes.found[0][key].copy()
    turns, size, base = 2 * len(kinds), made._fit[2].size, np.array([0, 0, key * made._stride])
    feet, pull = state[size:-3] + base[2] + path.breaks[0], state[-3:]
    unknowns, unit = state[:size], stretch[4]
    assert size == turns + int(model.extends.sum())
    assert unit == pytest.approx(0.2)
    chain[1][0] = np.eye(3)
    which = np.flatnonzero(model.extends)

    def at(flat, second=True):
        lengths_set(body, stretch, flat[turns:])
        laid(body, flat[:turns].reshape(-1, 2), second, chain)
        cost = assembled(made._pieces, body, base, pull, feet, second, chain, rest)
        lengthened(made._pieces, body, stretch, flat[turns:], base, pull, feet, second, chain, rest)
        cost += 0.5 * stretch[5] * flat[turns:].sum() ** 2
        return cost, rest[0].copy(), np.tril(rest[1]) + np.tril(rest[1], -1).T, rest[3].copy(), rest[2].copy()

    cost, gradient, square, rates, apart = at(unknowns)
    longer = np.zeros(len(kinds))
    longer[which] = unit * unknowns[turns:]
    slow, tip = cost_of(path, model, body, base, unknowns[:turns].reshape(-1, 2), longer)
    assert cost == pytest.approx(slow + 0.5 * stretch[5] * unknowns[turns:].sum() ** 2, rel=1e-9)
    np.testing.assert_allclose(chain[0][-1] + base, tip, rtol=0, atol=1e-13)
    assert np.abs(apart).max() < 1e-12
    assert np.abs(unknowns[turns:]).max() > 1e-4
    across = rest[4].copy()
    total = gradient + (across @ pull) @ rates
    total[turns:] += made._fit[2][turns:] * unknowns[turns:] / made._keyframes.freedom[key] ** 2
    free = np.append(np.ones(turns, bool), np.abs(unknowns[turns:, None] - stretch[3]).min(axis=1) > 1e-12)
    assert np.abs(total[free]).max() < 1e-7 * np.abs(gradient).max()  # the fit is stationary

    def whole(flat):
        cost, *_ = at(flat, second=False)
        return cost + pull @ (rest[4].T @ rest[2])

    step, scale = 1e-5, np.abs(square[:turns, :turns]).max()
    eye = step * np.eye(size)
    for a in range(turns, size):
        high, low = at(unknowns + eye[a]), at(unknowns - eye[a])
        assert (high[0] - low[0]) / (2 * step) == pytest.approx(gradient[a], rel=1e-4, abs=1e-9)
        for b in range(a + 1):
            second = whole(unknowns + eye[a] + eye[b]) - whole(unknowns + eye[a] - eye[b])
            second += whole(unknowns - eye[a] - eye[b]) - whole(unknowns - eye[a] + eye[b])
            assert second / (4 * step**2) == pytest.approx(square[a, b], abs=1e-4 * scale)


@pytest.mark.parametrize(("kind", "length_range"), [("screw", RANGE), ("S", RANGE), ("S", (0.197, 0.204))])
def test_no_posture_near_is_closer_than_the_fit(kind, length_range):
    """scipy, with the cost, the ties and the tip's place on the path written anew, from beside the fit."""
    path = shape(kind, 0.6, np.random.default_rng(5))
    model, lengths = arm(length_range=length_range)
    made = follower(path, model, lengths, 1.5)
    base, body, unit = np.array([0, 0, 0.5]), made._fit[0], 0.2
    joints = made.step(0.5)
    own = (joints - joints[0])[None]
    angles = model.angles(own)
    parts = (model.lengths(own, angles)[0] - 0.2) / unit
    low, high = (np.array(length_range) - 0.2) / unit
    assert (parts >= low - 1e-12).all()
    assert (parts <= high + 1e-12).all()
    assert (length_range == RANGE) == (np.minimum(parts - low, high - parts).min() > 1e-9)

    def cost(x):
        longer = unit * x[6:9]
        return cost_of(path, model, body, base, x[:6].reshape(-1, 2), longer)[0] + tied(made, x[6:9], 0.5)

    def off(x):
        points = places(lengthened_model(model, unit * x[6:9]), body, x[:6].reshape(-1, 2))
        return points[-1] + base - path.point(min(max(x[9], 0), path.length))

    arc = float(path.arc_length(made._parameters[0])[0])
    found_by_fit = np.concatenate([angles.ravel(), parts, [arc]])
    rng = np.random.default_rng(0)
    start = found_by_fit + np.append(rng.normal(0, 0.02, 9), 0.005)
    start[6:9] = np.clip(start[6:9], low, high)
    found = minimize(
        lambda x: 1e4 * cost(x),
        start,
        method="SLSQP",
        bounds=[(-1.5, 1.5)] * 6 + [(low, high)] * 3 + [(0.0, path.length)],
        constraints={"type": "eq", "fun": off},
        options={"ftol": 1e-11, "maxiter": 80},
    )
    assert np.abs(off(found_by_fit)).max() < 1e-9
    assert np.abs(off(found.x)).max() < 1e-5  # where it ends depends on how a processor rounds
    assert 1e-4 * found.fun >= cost(found_by_fit) * (1 - 1e-5)
    np.testing.assert_allclose(found.x[:9], found_by_fit[:9], rtol=0, atol=4e-3)


@pytest.mark.parametrize("carried", [False, True])
def test_a_pose_depends_on_the_feed_alone_and_begins_straight_and_at_rest(carried):
    path = shape("C", 0.6, np.random.default_rng(2)).with_end(0.3)
    model, lengths = arm()
    feeds, order = np.linspace(0.0, 0.6, 13), np.random.default_rng(1).permutation(13)
    made = follower(path, model, lengths, carried=carried)
    joints, axes = made.run_with_axes(feeds)
    np.testing.assert_array_equal(follower(path, model, lengths, carried=carried).run(feeds[order]), joints[order])
    np.testing.assert_array_equal(made.run(feeds[::-1])[::-1], joints)
    own = np.einsum("tji,tnj->tni", axes, joints)
    found = model.lengths(own, model.angles(own))
    np.testing.assert_allclose(found[0], 0.2, rtol=0, atol=1e-12)
    assert (found >= RANGE[0]).all()
    assert (found <= RANGE[1]).all()
    assert np.abs(found - 0.2).max() > (2e-5 if carried else 2e-3)
    np.testing.assert_allclose(found.sum(axis=1), 0.6, rtol=0, atol=2e-3)
    assert path.distance_to(joints[:, -1]).max() < 1e-11


def test_an_arm_that_extends_is_closer_to_the_path_in_the_mean():
    """Of random shapes of all kinds, taken together."""
    both = {}
    for length_range in (None, RANGE):
        model, lengths = arm(length_range=length_range)
        away = []
        for seed, kind in enumerate(SHAPES):
            path = shape(kind, 0.6, np.random.default_rng(seed))
            joints = follower(path, model, lengths, 1.5).run(np.linspace(0.0, 0.6, 13))
            away.append(path.distance_to(model.vertices(joints)))
        both[length_range is None] = float((np.array([each.mean() for each in away])).mean())
    assert both[False] < 0.95 * both[True]


@pytest.mark.parametrize("method", ["exact", "aim"])
def test_other_methods_keep_the_length_at_rest(method):
    path = shape("screw", 0.6, np.random.default_rng(2))
    feeds = np.linspace(0.0, 0.5, 6)
    found = []
    for length_range in (RANGE, None):
        model, lengths = arm(length_range=length_range)
        found.append(hognose.follow(path, lengths, feeds, method, model=model, axes=np.eye(3)))
    np.testing.assert_array_equal(*found)


@pytest.mark.parametrize("pitch", [0.2, 6.0])
def test_lengths_at_rest_at_the_end_of_their_range_stay_in_it_whatever_the_size_of_the_arm(pitch):
    sections = [Geometry(pitch, 0.0, 0.0, 0.05 * pitch, (1.5, 1.5), None, length_range=(0.6 * pitch, pitch))] * 3
    model, lengths = MixedSections([KINDS["arc"]] * 3, sections, 0.0), np.full(3, pitch)
    path = shape("S", 3 * pitch, np.random.default_rng(1))
    joints = follower(path, model, lengths).run(np.linspace(0.0, 2.5 * pitch, 8))
    found = model.lengths(joints, model.angles(joints))
    assert found.min() < 0.9999 * pitch
    assert found.max() <= pitch + 5e-10 + 1e-13 * pitch


def test_where_there_is_no_posture_the_same_is_said_as_of_the_arm_at_rest():
    path, said = shape("C", 0.6, np.random.default_rng(0)), []
    for fixed in ((), (0, 1, 2)):
        model, lengths = arm(fixed=fixed)
        with pytest.raises(InfeasibleError) as caught:
            follower(path, model, lengths, 0.02).run(np.array([0.55]))
        said.append(str(caught.value))
    assert said[0] == said[1]
    assert said[0].endswith("Make the path gentler, take more sections, or raise bend_limit_deg")
