"""The fastest feed of an arm on a carrier keeps the carrier's limits, by a dense oracle; and on other bases theirs."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planning_makers import failed, outcome, retasked, variant
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

import hognose
from hognose.planning import retraction, run_checks

#: By how much a limit may be exceeded between the set-points.
DENSE = 1.001
#: A way that is longer than the arm, so that a carrier follows into its bends.
LONG = [[0, 0, 0], [0.03, 0.06, 0.3], [-0.03, 0.05, 0.7], [0.0, -0.1, 1.1], [0.1, -0.2, 1.5]]
LIMITED = {"kind": "arm", "speed": 0.2, "acceleration": 0.3, "turn_speed_deg_s": 8.0, "turn_acceleration_deg_s2": 9.0}

seeds = st.integers(0, 2**32 - 1)


def carried(base, period=0.15, way_points=LONG, robot=None, **motion):
    """A task in empty space with the fastest profile."""
    changes = {"base": base, "path.way_points": way_points, "obstacle": [], "motion.profile": "fastest"}
    changes |= {"motion.period_s": period} | {f"motion.{key}": value for key, value in motion.items()}
    return variant(hognose.load_task("pipe-tank"), changes, robot)


def used(plan) -> dict[str, float]:
    """The largest speeds and accelerations of the carrier, of straight lines and cubics through the set-points."""
    period = plan.task.spec.motion.period_s
    times = period * np.arange(len(plan.time))
    dense = np.linspace(0.0, times[-1], 8 * len(times) + 1)
    place = CubicSpline(times, plan.base_pose[:, :3], bc_type="clamped")
    turned = CubicSpline(times, plan.base_pose[:, 3:], bc_type="clamped")
    poses = Rotation.from_quat(plan.base_pose[:, 3:], scalar_first=True)
    steps = np.linalg.norm(np.diff(plan.base_pose[:, :3], axis=0), axis=1)
    return {
        "speed": max(np.linalg.norm(place(dense, 1), axis=1).max(), steps.max() / period),
        "acceleration": np.linalg.norm(place(dense, 2), axis=1).max(),
        "turn_speed_deg_s": max(
            np.degrees(_vector(turned(dense, 1), turned(dense))).max(),
            np.degrees((poses[1:] * poses[:-1].inv()).magnitude()).max() / period,
        ),
        "turn_acceleration_deg_s2": np.degrees(_vector(turned(dense, 2), turned(dense))).max(),
    }


def _vector(changed, quaternions):
    """The length of 2 q' q*: an angular velocity of first derivatives, an angular acceleration of second ones."""
    w, v = quaternions[:, :1], quaternions[:, 1:]
    return np.linalg.norm(2 * (changed[:, 1:] * w - changed[:, :1] * v - np.cross(changed[:, 1:], v)), axis=1)


@pytest.mark.slow
@settings(max_examples=15)
@given(seeds, st.sampled_from([0.02, 0.15]))
def test_a_carrier_on_random_paths_keeps_its_limits_between_the_set_points_too(seed, period):
    rng = np.random.default_rng(seed)
    low, high = np.log([0.03, 0.03, 1.0, 2.0]), np.log([0.5, 2.0, 30.0, 100.0])
    keys = ("speed", "acceleration", "turn_speed_deg_s", "turn_acceleration_deg_s2")
    limits: dict[str, float] = dict(zip(keys, np.exp(rng.uniform(low, high)).tolist(), strict=True))
    aside, along = np.cumsum(rng.uniform(-0.08, 0.08, (5, 2)), axis=0), np.linspace(0.3, 1.6, 5)[:, None]
    way = [[0.0, 0.0, 0.0], *np.hstack([aside, along]).tolist()]
    made = outcome(lambda: hognose.plan(carried({"kind": "arm", **limits}, period, way)))
    plan = made.plan if isinstance(made, hognose.InfeasibleError) else made
    assert isinstance(plan, hognose.Plan)
    # Too sharp a path, or one that crosses itself, whatever the speed.
    assert failed(plan.checks) <= {"bend_limits", "certified_along_path", "own_body", "cable_travel"}
    assert max(value / limits[key] for key, value in used(plan).items()) <= DENSE


@pytest.mark.parametrize("period", [0.02, 0.15])
def test_a_carrier_is_fed_as_fast_as_it_can_be(period):
    plan = hognose.plan(carried(LIMITED, period))
    parts = {key: value / LIMITED[key] for key, value in used(plan).items()}
    assert max(parts.values()) <= DENSE
    assert max(parts.values()) > 0.98
    slow = hognose.plan(carried({**LIMITED, "speed": 0.03}, period))
    assert used(slow)["speed"] == pytest.approx(0.03, rel=5e-3)
    assert slow.time[-1] > slow.feed[-1] / 0.03
    assert retraction(slow).good


def test_the_limits_of_the_slider_do_not_count_on_a_carrier():
    weak = {"feed.speed": 0.01, "feed.acceleration": 0.01}
    plan, other = hognose.plan(carried(LIMITED)), hognose.plan(carried(LIMITED, robot=weak))
    np.testing.assert_array_equal(plan.time, other.time)
    np.testing.assert_array_equal(plan.feed, other.feed)
    keys = {check.key for check in plan.checks}
    assert {"carrier_speed", "carrier_acceleration", "carrier_turn_speed", "carrier_turn_acceleration"} <= keys
    assert not keys & {"feed_speed", "feed_acceleration", "slider_travel"}


@pytest.mark.parametrize("key", [key for key in LIMITED if key != "kind"])
def test_each_limit_of_a_carrier_is_judged_by_a_check_of_its_own(key):
    plan = hognose.plan(carried(LIMITED))
    check = "carrier_" + key.removesuffix("_deg_s2").removesuffix("_deg_s")
    found = plan.check(check)
    in_units = math.degrees(found.value) if "turn" in key else found.value
    assert in_units == pytest.approx(used(plan)[key], rel=0.2)
    weaker = retasked(plan, {f"base.{key}": 0.9 * in_units})
    wrong = {check, "feed_jerk"} if key == "acceleration" else {check}
    assert check in failed(run_checks(weaker)) <= wrong
    assert hognose.plan(weaker.task).good


def test_limits_that_nobody_gave_are_assumed_and_said():
    plan = hognose.plan(carried({"kind": "arm"}))
    assert used(plan)["speed"] <= DENSE * plan.robot.spec.feed.speed
    assert used(plan)["acceleration"] <= DENSE * 0.1
    assert plan.check("carrier_speed").detail == (
        "the limit is feed.speed of the robot file, as the task gives no base.speed"
    )
    assert plan.check("carrier_acceleration").detail == (
        "from rest to rest; the limit is assumed, as the task gives no base.acceleration"
    )
    assert plan.check("carrier_turn_speed").ok is None
    steady = run_checks(retasked(plan, {"motion.profile": "constant"}))
    assert {check.key for check in steady if check.ok is None} == {
        "carrier_workspace", "carrier_speed", "carrier_turn_speed"
    }  # fmt: skip
    assert not {"carrier_acceleration", "carrier_turn_acceleration"} & {check.key for check in steady}


def test_constant_feed_is_judged_by_the_acceleration_that_a_task_gives_of_its_carrier():
    able, weak = ({"kind": "arm", "speed": 0.03, "acceleration": limit} for limit in (0.16, 0.15))
    assert hognose.plan(carried(able, profile="constant")).good
    made = outcome(lambda: hognose.plan(carried(weak, profile="constant")))
    assert isinstance(made, hognose.InfeasibleError)
    assert "carrier acceleration: 155.56 mm/s² exceeds 150 mm/s²" in str(made)
    assert 'motion.profile = "fastest" does not' in str(made)


def test_a_drum_turns_by_what_the_robot_file_says_of_the_feed():
    drum = {"kind": "drum", "radius": 0.24, "nozzle": 0.1}
    limits = {"feed.speed": 0.03, "feed.acceleration": 0.05}
    plan = hognose.plan(carried(drum, way_points=LONG[:3], robot=limits))
    times = 0.15 * np.arange(len(plan.time))
    feed, dense = CubicSpline(times, plan.feed, bc_type="clamped"), np.linspace(0.0, times[-1], 5000)
    assert 0.98 < feed(dense, 1).max() / 0.03 <= DENSE
    assert np.abs(feed(dense, 2)).max() / 0.05 <= DENSE
    assert {"feed_speed", "feed_acceleration", "drum_travel"} <= {check.key for check in plan.checks}


def test_a_carrier_without_poses_is_a_failed_check_and_no_other():
    plan = hognose.plan(carried(LIMITED))
    checks = run_checks(dataclasses.replace(plan, base_pose=None, checks=()))
    assert failed(checks) == {"base_pose_agrees_with_joints"}
    (check,) = (check for check in checks if check.failed)
    assert "the plan has no poses of its carrier" in check.sentence
    assert [each.key for each in checks] == [each.key for each in plan.checks]


@pytest.mark.parametrize("base", [{}, {"direction": [1.0, 2.0, -0.5]}, {"kind": "drum", "radius": 0.24, "nozzle": 0.1}])
def test_poses_on_another_base_change_no_verdict_and_are_compared_with_it(base):
    way = np.array(LONG[:3])
    if base.get("direction"):
        way = way @ np.array(Rotation.align_vectors([base["direction"]], [[0, 0, 1]])[0].as_matrix()).T
    plan = hognose.plan(carried(base, way_points=way.tolist(), profile="constant"))
    kept, axes = plan.task.base, np.eye(3)
    turned = np.swapaxes(kept.turned(np.broadcast_to(axes, (len(plan.time), 3, 3)), plan.at), 1, 2)
    poses = np.hstack([plan.joints[:, 0], Rotation.from_matrix(turned).as_quat(scalar_first=True)])
    poses[1:, 3:] *= np.cumprod(np.sign((poses[1:, 3:] * poses[:-1, 3:]).sum(axis=1)))[:, None]
    with_poses = run_checks(dataclasses.replace(plan, base_pose=poses, checks=()))
    assert failed(with_poses) == set()
    same = [check for check in with_poses if check.key != "base_pose_agrees_with_joints"]
    assert same == list(plan.checks)
    poses[40, 2] += 1e-4
    assert failed(run_checks(dataclasses.replace(plan, base_pose=poses, checks=()))) == {"base_pose_agrees_with_joints"}
