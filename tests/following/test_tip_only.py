"""Inverse kinematics as comparisons: what they promise, and the textbook's versions of each beside them."""

import numpy as np
import pytest
from following_oracles import random_path
from hypothesis import given, note, reject, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import hognose
from hognose.errors import InfeasibleError
from hognose.files import with_method
from hognose.following import METHODS, body_deviation
from hognose.following.chain import laid_along
from hognose.robot.kinematics import angles_of, positions_of

LENGTHS = np.full(9, 0.091)
LIMIT = 0.5
TIP_ONLY = [name for name, method in METHODS.items() if not method.glides]
methods = pytest.mark.parametrize("method", TIP_ONLY)
seeds = st.integers(0, 2**32 - 1)


def bend(a, b):
    return np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)


def into_cone(direction, axis, limit):
    """A unit direction turned back towards the axis until it is within the limit."""
    direction = direction / np.linalg.norm(direction)
    angle = bend(axis, direction)
    if angle <= limit:
        return direction
    normal = np.cross(axis, direction)
    return Rotation.from_rotvec(limit * normal / np.linalg.norm(normal)).apply(axis)


def fabrik_pass(chain, base, goal):
    chain = chain.copy()
    chain[-1] = goal
    for i in range(len(LENGTHS) - 1, -1, -1):
        direction = chain[i] - chain[i + 1]
        if i < len(LENGTHS) - 1:
            direction = into_cone(direction, (chain[i + 1] - chain[i + 2]) / LENGTHS[i + 1], LIMIT)
        chain[i] = chain[i + 1] + LENGTHS[i] * direction / np.linalg.norm(direction)
    chain[0], axis = base, np.array([0.0, 0.0, 1.0])
    for i in range(len(LENGTHS)):
        axis = into_cone(chain[i + 1] - chain[i], axis, LIMIT)
        chain[i + 1] = chain[i] + LENGTHS[i] * axis
    return chain


def ccd_pass(chain, base, goal):
    chain = chain + (base - chain[0])
    for i in range(len(LENGTHS) - 1, -1, -1):
        before = (chain[i] - chain[i - 1]) / LENGTHS[i - 1] if i else np.array([0.0, 0.0, 1.0])
        link = (chain[i + 1] - chain[i]) / LENGTHS[i]
        normal = np.cross(chain[-1] - chain[i], goal - chain[i])
        size = np.linalg.norm(normal)
        turn = bend(chain[-1] - chain[i], goal - chain[i])
        wanted = Rotation.from_rotvec(turn * normal / size if size > 0 else np.zeros(3))
        turned = wanted.apply(link)
        held = into_cone(turned, before, LIMIT)
        if bend(turned, held) > 1e-12:
            normal = np.cross(link, held)
            wanted = Rotation.from_rotvec(bend(link, held) * normal / max(np.linalg.norm(normal), 1e-300))
        chain[i + 1 :] = chain[i] + wanted.apply(chain[i + 1 :] - chain[i])
    return chain


def jacobian_pass(angles, base, goal, centring):
    """One damped step with J from differences, the pseudo-inverse and the projector written out."""

    def tip(flat):
        return positions_of(flat.reshape(1, -1, 2), np.zeros(1), LENGTHS)[0][0, -1] + base

    flat, h = angles.ravel(), 1e-6
    columns = np.stack([(tip(flat + h * e) - tip(flat - h * e)) / (2 * h) for e in np.eye(flat.size)], axis=1)
    damped = columns.T @ np.linalg.inv(columns @ columns.T + 1e-6 * np.eye(3))
    change = damped @ (goal - tip(flat)) + (np.eye(flat.size) - damped @ columns) @ (-centring * flat)
    return np.clip(flat + change, -LIMIT, LIMIT).reshape(-1, 2)


def reference(method, path, feeds, goals):
    """The same warm-started motion by the passes above."""
    chain = laid_along(path, LENGTHS, feeds[0])
    rows = []
    for base, goal in zip(path.point(feeds), goals, strict=True):
        chain = chain + (base - chain[0])
        angles, passes = angles_of(chain[None])[0], 0
        while np.linalg.norm(chain[-1] - goal) > 1e-5 or (method == "jacobian" and passes == 0):
            if method == "jacobian":
                angles = jacobian_pass(angles, base, goal, 0.1 if passes == 0 else 0.0)
                chain = positions_of(angles[None], np.zeros(1), LENGTHS)[0][0] + base
            else:
                chain = {"fabrik": fabrik_pass, "ccd": ccd_pass}[method](chain, base, goal)
            passes += 1
            assert passes < 10_000
        rows.append(chain)
    return np.array(rows)


@methods
@pytest.mark.parametrize("seed", [1, 4])
def test_it_is_the_textbooks_method(method, seed):
    path = random_path(seed)
    feeds = np.arange(0.75, 0.80, 0.0035)
    goals = hognose.follow(path, LENGTHS, feeds)[:, -1]
    follower = hognose.follower(path, LENGTHS, method, bend_limits=LIMIT)
    follower.begin(feeds[0])
    found = follower.run(feeds)
    np.testing.assert_allclose(found, reference(method, path, feeds, goals), rtol=0, atol=1e-6)


@methods
def test_a_posture_is_the_same_whatever_came_before(method):
    path, rng = random_path(4), np.random.default_rng(1)
    feeds = rng.uniform(0.0, 0.9, 40)
    follower = hognose.follower(path, LENGTHS, method, bend_limits=LIMIT)
    first = follower.run(feeds)
    rounding = {"rtol": 0, "atol": 1e-10}
    np.testing.assert_allclose(follower.run(feeds[::-1])[::-1], first, **rounding)
    other = hognose.follow(path, LENGTHS, np.sort(feeds), method, bend_limits=LIMIT)
    np.testing.assert_allclose(other, first[np.argsort(feeds)], **rounding)
    before = follower.step(0.75)
    follower.begin(0.75)  # another way leads elsewhere
    assert np.abs(follower.step(0.75) - before).max() > 1e-3
    np.testing.assert_allclose(follower.step(feeds.min()), first[np.argmin(feeds)], **rounding)  # from 0 again


@methods
@settings(deadline=None, max_examples=8)
@given(seeds)
def test_base_tip_links_and_bends_are_as_promised_and_the_body_is_not_on_the_path(method, seed):
    path = random_path(seed)
    feeds = np.arange(0.4, 1.0, 0.0035)
    follower = hognose.follower(path, LENGTHS, method, bend_limits=LIMIT)
    exact = hognose.follow(path, LENGTHS, feeds)
    try:
        joints = follower.run(feeds)
    except InfeasibleError as error:
        note(f"{error}")
        reject()
    np.testing.assert_allclose(joints[:, 0], path.point(feeds), rtol=0, atol=1e-12)
    assert np.linalg.norm(joints[:, -1] - exact[:, -1], axis=1).max() <= follower.tolerance
    links = np.linalg.norm(np.diff(joints, axis=1), axis=2)
    np.testing.assert_allclose(links, np.broadcast_to(LENGTHS, links.shape), rtol=0, atol=1e-12)
    assert np.abs(angles_of(joints)).max() <= LIMIT + 1e-9
    assert body_deviation(path, joints).max() > 2 * body_deviation(path, exact).max()


@methods
def test_the_bundled_tasks_show_why_it_is_no_way_to_steer_a_body_round_obstacles(method):
    task = hognose.load_task("pipe-tank")
    with pytest.raises(InfeasibleError, match="clearance at steps") as caught:
        hognose.plan(with_method(task, method))
    plan = caught.value.plan
    keys = [check.key for check in plan.checks]
    assert "joints_on_path" not in keys
    assert "certified_along_path" not in keys
    assert plan.check("tip_error").ok
    assert plan.check("tip_on_target").ok
    assert plan.check("bend_limits").ok
    assert plan.body_deviation.max() > 0.05


@methods
def test_a_tip_that_finds_no_way_says_so(method):
    """Limits of 0.02 rad let no arm round this bend."""
    path = random_path(4)
    feeds = np.arange(0.5, 1.0, 0.0035)
    with pytest.raises(
        InfeasibleError,
        match=rf"step 0, feed 500\.00 mm: on the way there, at feed \d+\.\d+ mm, {method} left the tip .* bend limits",
    ):
        hognose.follow(path, LENGTHS, feeds, method, bend_limits=0.02)


@pytest.mark.parametrize("bad", [0.0, -0.1, 2.0, np.nan, [0.1, 0.2, 0.3], "wide"])
def test_bend_limits_must_be_angles_up_to_a_right_angle(bad):
    with pytest.raises(hognose.InputError, match="bend_limits"):
        hognose.follow(random_path(1), LENGTHS, [0.0], "ccd", bend_limits=bad)
