"""Plans on a drum and on a carrier: they end on the target, are certified, and what the base cannot do is said."""

import dataclasses
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from planning_makers import failed, retasked, variant

import hognose
from hognose.errors import InputError
from hognose.planning import retraction, run_checks
from hognose.planning.checks.base import drum_travel
from hognose.planning.checks.shared import Shared
from hognose.robot.base import SAME_PLACE
from hognose.robot.carrier import Carrier

#: A way that is longer than the arm, so that a carrier follows into its bends.
LONG = [[0, 0, 0], [0.03, 0.06, 0.3], [-0.03, 0.05, 0.7], [0.0, -0.1, 1.1], [0.1, -0.2, 1.5]]
BOX = {"low": [-0.5, -0.5, -1.5], "high": [0.5, 0.5, 0.6]}


def on(base, way_points):
    """A plan in empty space with a base."""
    task = hognose.load_task("pipe-tank")
    changes = {"base": base, "path.way_points": way_points, "obstacle": []}
    return hognose.plan(variant(task, changes))


@pytest.fixture(scope="module")
def carried():
    return on({"kind": "arm", "workspace": BOX, "speed": 0.03, "turn_speed_deg_s": 10.0}, LONG)


@pytest.fixture(scope="module")
def coiled():
    return on({"kind": "drum", "radius": 0.24, "nozzle": 0.1, "rotation_deg": [0, 0, 30]}, LONG[:3])


def test_a_carrier_follows_into_the_bends(carried):
    assert carried.good
    assert carried.feed[-1] > carried.robot.length
    assert np.abs(carried.joints[-1, 0] - carried.task.base.direction * carried.joints[-1, 0, 2]).max() > 1e-3
    np.testing.assert_allclose(carried.body, carried.joints, rtol=0, atol=1e-11)
    np.testing.assert_allclose(carried.angles[:, 0], 0, atol=1e-9)
    np.testing.assert_allclose(carried.body[-1, -1], LONG[-1], rtol=0, atol=1e-9)


def test_a_drum_feeds_the_arm_from_its_coil(coiled):
    assert coiled.good
    base = coiled.task.base
    np.testing.assert_allclose(coiled.body, coiled.joints, rtol=0, atol=1e-11)
    np.testing.assert_allclose(coiled.body[0, -1], LONG[0], rtol=0, atol=1e-9)
    centre = base.entrance - base.nozzle * base.direction + base.radius * base.R_task_nozzle[:, 0]
    assert np.linalg.norm(coiled.joints[0, 0] - centre) == pytest.approx(base.radius, abs=1e-12)
    assert coiled.feed[-1] < base.farthest
    assert {"drum_travel"} <= {check.key for check in coiled.checks}
    assert not {"slider_travel", "clearance_of_mount"} & {check.key for check in coiled.checks}


@pytest.mark.parametrize("which", ["carried", "coiled"])
def test_a_way_out_is_the_way_in_backwards(which, request, tmp_path):
    plan = request.getfixturevalue(which)
    out = retraction(plan)
    assert out.good
    np.testing.assert_array_equal(out.body[::-1], plan.body)
    file = tmp_path / "out.parquet"
    out.save(file)
    back = hognose.Plan.load(file)
    assert back.good
    np.testing.assert_array_equal(back.at, out.at)


@pytest.mark.parametrize(
    ("key", "value", "check"),
    [
        ("base.workspace.high", [0.5, 0.5, -0.2], "carrier_workspace"),
        ("base.speed", 0.02, "carrier_speed"),
        ("base.turn_speed_deg_s", 0.5, "carrier_turn_speed"),
    ],
)
def test_what_a_carrier_cannot_do_fails_this_check_alone(carried, key, value, check):
    assert failed(run_checks(retasked(carried, {key: value}))) == {check}


def test_what_a_task_does_not_say_of_its_carrier_is_not_judged(carried):
    checks = run_checks(retasked(carried, {"base": {"kind": "arm"}}))
    assert failed(checks) == set()
    assert {each.key for each in checks if each.ok is None} == {
        "carrier_workspace", "carrier_speed", "carrier_turn_speed"
    }  # fmt: skip


@pytest.mark.parametrize(("number", "change"), [(0, 1e-8), (4, 1e-7)])
def test_a_pose_that_was_altered_is_found(carried, number, change):
    pose = carried.base_pose.copy()
    pose[200, number] += change
    assert "base_pose_agrees_with_joints" in failed(run_checks(dataclasses.replace(carried, base_pose=pose, checks=())))


def test_a_feed_beyond_the_drum_is_found(coiled):
    feed = coiled.feed.copy()
    feed[-1] = coiled.task.base.farthest + 1e-6
    longer = dataclasses.replace(coiled, feed=feed, way_points=np.array(LONG), checks=())  # else the path ends before
    assert "drum_travel" in failed(run_checks(longer))


def test_the_last_bits_of_a_feed_do_not_decide_whether_the_arm_is_on_its_drum(coiled):
    limit = coiled.task.base.farthest
    for beyond, fits in ((1e-13, True), (1e-10, False)):
        feed = coiled.feed.copy()
        feed[-1] = limit * (1 + beyond)
        (check,) = drum_travel(dataclasses.replace(coiled, feed=feed, checks=()), Shared(coiled))
        assert check.failed != fits


@given(seed=st.integers(0, 2**32 - 1))
def test_what_rounding_takes_beyond_a_wall_is_not_outside(seed):
    random = np.random.default_rng(seed)
    box = np.sort(random.normal(size=(2, 3)), axis=0)
    carrier = Carrier.before(np.zeros(3), hognose.load_robot("sjtu-25dof"), np.eye(3), box)
    away = -np.abs(random.normal(size=3))
    away /= np.linalg.norm(away)
    near, far = box[0] + np.outer((0.0, 0.999 * SAME_PLACE), away), box[0] + 1.001 * SAME_PLACE * away
    assert not carrier.outside(near).any()
    np.testing.assert_allclose(carrier.outside(far[None])[0], 1.001 * SAME_PLACE * away, rtol=0, atol=1e-15)


def test_quaternions_whose_sign_jumps_are_found(carried):
    pose = carried.base_pose.copy()
    pose[200:, 3:] *= -1
    checks = run_checks(dataclasses.replace(carried, base_pose=pose, checks=()))
    assert "base_pose_agrees_with_joints" in failed(checks)


def cart(position, way_points=((0, 0, 0), (0, 0.02, 0.2), (0, 0, 0.5)), **more):
    base = {"kind": "cart", "position": position, **more}
    return variant(hognose.load_task("pipe-tank"), {"base": base, "path.way_points": way_points, "obstacle": []})


@pytest.mark.parametrize(("position", "more"), [((0, 0, -0.9), {}), ((0, -0.9, 0), {"direction": (0, 1, 0)})])
def test_a_cart_whose_nose_is_past_the_entrance_is_told_where_to_stand(position, more):
    with pytest.raises(InputError, match=r"^base\.position: ") as caught:
        hognose.plan(cart(position, **more))
    said = str(caught.value)
    assert "is 192 mm past the entrance at (0, 0, 0) mm" in said
    assert "e-" not in said
    place = re.search(r"Move base\.position back, to \((.*?)\) mm or farther", said)
    assert place is not None
    back = tuple(1e-3 * float(c) for c in place[1].split(","))
    assert np.linalg.norm(back) == pytest.approx(1.092)
    assert hognose.plan(cart(back, ((0, 0, 0), tuple(-0.3 * c for c in back)), **more)).good


def test_a_cart_whose_nose_is_before_the_entrance_is_planned():
    assert hognose.plan(cart((0, 0, -1.2))).good


def test_a_cart_beside_the_entrance_is_told_how_far_and_where_it_would_be_in_line(tasks):
    task = tasks["obstacle-array"]
    arm = task.robot.length
    places = [[0.0, 0.0, 0.0], [0.03, 0.095, 0.43], [-0.06, -0.05, 1.0]]
    changes = {"obstacle": [], "path.way_points": places, "base": {"kind": "cart", "position": [0.3, 0.0, -1.2]}}
    with pytest.raises(hognose.InputError) as caught:
        hognose.plan(variant(task, changes))
    said = str(caught.value)
    assert said.startswith(
        "base.position: the target is too far: the path from the nose of the straight arm at (300, 0, -108) mm to it is"
    )
    assert "The nose is 300 mm beside the entrance at (0, 0, 0) mm: move base.position, to (0, 0, -1092) mm" in said
    changes["base"] = {"kind": "cart", "position": [0.0, 0.0, -arm]}
    assert hognose.plan(variant(task, changes)).good
