"""The optimisation search against exact following, and against a general optimiser where a limit binds."""

import numpy as np
import pytest
from following_oracles import SLIDER, random_path
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

import hognose
from hognose.following.optimization import Optimization
from hognose.path import Path
from hognose.robot.kinematics import angles_of, positions_of

LENGTHS = np.full(8, 0.091)


@pytest.mark.parametrize("as_published", [False, True])
@settings(deadline=None, max_examples=6)
@given(st.integers(0, 2**32 - 1))
def test_within_the_limits_it_finds_the_exact_joints(as_published, seed):
    path = random_path(seed)
    feeds = np.concatenate([np.arange(0.6, 1.0, 0.0035), np.arange(1.0, 0.8, -0.01)])
    follower = Optimization(path, LENGTHS, as_published=as_published)
    exact = hognose.follow(path, LENGTHS, feeds)
    assert np.abs(follower.run(feeds) - exact).max() < 10 * follower.tolerance


def squeezed():
    """A bend of 0.15 m radius, for which links of 91 mm need 0.62 rad a joint."""
    turn = np.linspace(0, np.pi / 2, 12)
    arc = np.column_stack([0.15 * (1 - np.cos(turn)), 0 * turn, 0.5 + 0.15 * np.sin(turn)])
    points = np.concatenate([[[0, 0, 0]], arc, arc[-1:] + np.array([[0.3, 0, 0], [0.6, 0, 0]])])
    return Path.through(points, 3, SLIDER).with_run(0.8)


@pytest.mark.parametrize("as_published", [False, True])
def test_where_limits_bind_it_is_the_nearest_posture_within_them(as_published):
    path, limit = squeezed(), 0.4
    feeds = np.arange(0.7, 0.95, 0.0035)
    follower = Optimization(path, LENGTHS, bend_limits=limit, as_published=as_published)
    joints = follower.run(feeds)
    angles = angles_of(joints)
    assert np.abs(angles).max() <= limit + 1e-12
    assert np.abs(angles_of(hognose.follow(path, LENGTHS, feeds))).max() > 0.5
    links = np.linalg.norm(np.diff(joints, axis=1), axis=2)
    np.testing.assert_allclose(links, np.broadcast_to(LENGTHS, links.shape), rtol=0, atol=1e-12)
    weights = np.append(np.ones(7), 10.0)

    def distances(flat, base):
        chain = positions_of(flat.reshape(1, -1, 2), np.zeros(1), LENGTHS)[0][0] + base
        return weights * path.distance_to(chain[1:])

    away = path.distance_to(joints).max(axis=1)
    assert away.max() > 1e-3
    base, found = path.point(feeds[-1]), angles[-1].ravel()
    start = np.clip(found, -0.999 * limit, 0.999 * limit)
    best = least_squares(distances, start, bounds=(-limit, limit), args=(base,), method="dogbox", max_nfev=100)
    assert np.sum(distances(found, base) ** 2) <= 1.02 * np.sum(best.fun**2) + 1e-12


def test_its_time_is_spent_on_far_fewer_distances_than_as_published():
    path, feeds = random_path(5), np.arange(0.6, 0.9, 0.0035)
    tuned, published = Optimization(path, LENGTHS), Optimization(path, LENGTHS, as_published=True)
    tuned.run(feeds)
    published.run(feeds)
    assert 2 * 8 <= tuned.evaluations / len(feeds) < 5 * 8
    # A finite difference for each of 16 angles, of 8 distances each.
    assert published.evaluations / len(feeds) > 16 * 8
