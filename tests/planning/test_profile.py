"""The fastest feed profile: properties over random paths and limits, closed forms, and a dense oracle."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planning_makers import altered, failed, outcome, random_robot, retasked, variant
from pydantic import ValidationError
from scipy.interpolate import CubicSpline
from scipy.ndimage import minimum_filter1d

import hognose
from hognose.planning import Task, TaskSpec, retraction
from hognose.planning.planner import arrival
from hognose.planning.profile import FeedLimits, FeedProfile, Moved
from hognose.planning.profile.between import overruns
from hognose.robot import Robot

#: By how much a limit may be exceeded between the set-points.
DENSE = 1.001

seeds = st.integers(0, 2**32 - 1)


def even(length: float, speed: float, acceleration: float, places: int = 300) -> FeedLimits:
    """The same limits everywhere."""
    return FeedLimits(np.linspace(0.0, length, places), np.full(places, speed), np.full(places, acceleration))


def uneven(seed: int, places: int = 400) -> FeedLimits:
    """Limits that change by up to a hundredfold, smoothly or from place to place."""
    rng = np.random.default_rng(seed)
    knots = np.linspace(0.0, 1.0, rng.integers(2, 40))
    at = np.linspace(0.0, 1.0, places)
    speed, acceleration = (np.exp(np.interp(at, knots, rng.uniform(-2.3, 2.3, knots.size))) for _ in range(2))
    return FeedLimits(at * rng.uniform(0.05, 2.0), 0.05 * speed, 0.1 * acceleration)


def speed_at(made: FeedProfile, times: np.ndarray) -> np.ndarray:
    """Feed speeds (k,) m/s at times (k,) s."""
    return (made._place(times) - made._place(times - made.smoothing_time)) / made.smoothing_time


@given(seeds, st.floats(0.01, 2.0))
def test_speed_acceleration_and_jerk_keep_their_limits_from_rest_to_rest(seed, smoothing_time):
    limits = uneven(seed)
    made = FeedProfile.within(limits, smoothing_time)
    pause = made.duration / 20_000
    times = pause * np.arange(-2, 20_003, dtype=np.float64)
    feed, speed = made.at(times), speed_at(made, times)
    assert feed[:3] == pytest.approx(0.0, abs=1e-12)
    assert feed[-3:] == pytest.approx(limits.feeds[-1], rel=1e-10)
    assert speed[[0, 1, 2, -3, -2, -1]] == pytest.approx(0.0, abs=1e-9)
    assert (speed > -1e-12).all()
    np.testing.assert_allclose(np.diff(feed) / pause, (speed[1:] + speed[:-1]) / 2, atol=2e-3 * speed.max())

    def at_most(values, over, allowed):
        places = np.clip(np.searchsorted(limits.feeds, over), 1, len(limits.feeds) - 1)
        return (values <= np.maximum(allowed[places], allowed[places - 1]) * (1 + 1e-9) + 1e-12).all()

    change = np.abs(np.diff(speed)) / pause
    assert at_most(speed, feed, limits.speed)
    assert at_most(change, (feed[1:] + feed[:-1]) / 2, limits.acceleration)
    jerk = np.abs(np.diff(speed, 2)) / pause**2
    assert jerk.max() <= 2 * limits.acceleration.max() / smoothing_time * (1 + 1e-6)


@given(st.floats(0.05, 2.0), st.floats(0.01, 0.2), st.floats(0.02, 1.0), st.floats(0.01, 1.0))
def test_with_even_limits_the_duration_is_that_of_a_trapezium(length, speed, acceleration, smoothing_time):
    made = FeedProfile.within(even(length, speed, acceleration, 4001), smoothing_time)
    ramp = speed**2 / acceleration
    plateau = length / speed + speed / acceleration
    expected = plateau if ramp <= length else 2 * math.sqrt(length / acceleration)
    assert made.duration - smoothing_time == pytest.approx(expected, rel=1e-3)


@given(seeds, st.floats(0.01, 2.0))
def test_backwards_the_fastest_profile_is_the_same(seed, smoothing_time):
    limits = uneven(seed)
    turned = FeedLimits(limits.feeds, limits.speed[::-1], limits.acceleration[::-1])
    there, back = (FeedProfile.within(each, smoothing_time) for each in (limits, turned))
    assert there.duration == pytest.approx(back.duration, rel=1e-9)
    times = np.linspace(0.0, there.duration, 200)
    np.testing.assert_allclose(there.at(times), limits.feeds[-1] - back.at(there.duration - times), atol=1e-9)


@given(seeds, st.floats(0.01, 1.0))
def test_looser_limits_never_make_it_slower(seed, smoothing_time):
    limits = uneven(seed)
    looser = FeedLimits(limits.feeds, limits.speed, 1.3 * limits.acceleration)
    made, faster = (FeedProfile.within(each, smoothing_time) for each in (limits, looser))
    assert faster.duration <= made.duration * (1 + 1e-12)
    assert (faster.speed >= made.speed * (1 - 1e-12)).all()


@given(seeds, st.integers(0, 700))
def test_erosion_takes_the_smallest_nearby(seed, places):
    limits = uneven(seed)
    reach = (places - 0.5) * limits.feeds[1] if places else 0.0
    made = limits.eroded(reach)
    for name in ("speed", "acceleration"):
        expected = minimum_filter1d(getattr(limits, name), 2 * min(places, 399) + 1, mode="nearest")
        assert np.array_equal(getattr(made, name), expected)


@given(seeds, st.integers(2, 60), st.floats(0.01, 1.0))
def test_cubics_between_set_points_are_those_of_a_clamped_spline(seed, rows, period):
    rng = np.random.default_rng(seed)
    values = np.cumsum(rng.normal(size=(rows, 3)), axis=0)
    times = period * np.arange(rows)
    spline = CubicSpline(times, values, bc_type="clamped")
    dense = np.linspace(0.0, times[-1], 400 * rows)
    speed, change = overruns(values, period, 1.0, 1.0)
    assert change == pytest.approx(np.abs(spline(times, 2)).max(), rel=1e-6)
    assert speed == pytest.approx(np.abs(spline(dense, 1)).max(), rel=1e-4)
    assert overruns(values, period, 1e9, math.inf)[1] == 0.0


def random_task(seed: int, period: float) -> Task:
    """An arm of random links and limits on a winding path, with nothing around it."""
    rng = np.random.default_rng(seed)
    arm = random_robot(rng, int(rng.integers(3, 9)))

    def spread(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(math.log(low), math.log(high))))

    changes = {
        "feed.speed": spread(0.01, 0.2),
        "feed.acceleration": spread(0.02, 1.0),
        "limits.joint_speed_deg_s": spread(1.0, 40.0),
        "limits.joint_acceleration_deg_s2": spread(1.0, 200.0),
        "limits.cable_speed": spread(0.0005, 0.05),
        "limits.cable_acceleration": spread(0.001, 0.5) if rng.random() < 0.5 else None,
    }
    robot = Robot.from_spec(altered(arm.spec, changes))
    side = np.cumsum(rng.uniform(-0.05, 0.05, (4, 2)), axis=0) * robot.length
    along = np.linspace(0.0, 0.75, 5)[1:, None] * robot.length
    points = np.concatenate([np.zeros((1, 3)), np.hstack([side, along])])
    data = {
        "name": "random",
        "robot": "random",
        "path": {"way_points": points.tolist(), "detour": False},
        "motion": {"profile": "fastest", "period_s": period},
    }
    return Task(TaskSpec.model_validate(data), robot)


def parts_of_limits(plan: hognose.Plan) -> dict[str, float]:
    """Speeds and accelerations by a dense oracle, as parts of their limits: straight lines and cubics."""
    robot, period = plan.robot, plan.task.spec.motion.period_s
    said, axis = robot.spec.limits, robot.spec.feed
    quantities = {
        "feed": (plan.feed[:, None], axis.speed, axis.acceleration_limit),
        "joint": (
            plan.angles.reshape(len(plan.time), -1),
            math.radians(said.joint_speed_deg_s),
            math.radians(said.joint_acceleration_deg_s2),
        ),
        "cable": (plan.cable_lengths, said.cable_speed, said.cable_acceleration or math.inf),
    }
    found = {}
    for name, (values, fastest, hardest) in quantities.items():
        rest = np.concatenate([values[:1], values, values[-1:]])
        lines = np.diff(rest, axis=0) / period
        spline = CubicSpline(plan.time, values, bc_type="clamped")
        dense = np.linspace(0.0, plan.time[-1], 20 * len(plan.time))
        found[f"{name} speed"] = max(np.abs(lines).max(), np.abs(spline(dense, 1)).max()) / fastest
        changes = np.abs(np.diff(lines, axis=0)).max() / period
        found[f"{name} acceleration"] = max(changes, np.abs(spline(dense, 2)).max()) / hardest
    return found


def true_parts_of_limits(plan: hognose.Plan) -> dict[str, float]:
    """The same of the motion on the path itself, followed at feeds in between."""
    feeds = CubicSpline(plan.time, plan.feed, bc_type="clamped")
    pause = 0.005
    times = np.arange(0.0, plan.time[-1], pause)
    joints = hognose.follow(plan.path, plan.robot.link_lengths, np.clip(feeds(times), 0.0, plan.feed[-1]))
    angles = plan.robot.angles(joints)
    said = plan.robot.spec.limits
    speed, change = np.diff(angles, axis=0) / pause, np.diff(angles, 2, axis=0) / pause**2
    return {
        "joint speed": np.abs(speed).max() / math.radians(said.joint_speed_deg_s),
        "joint acceleration": np.abs(change).max() / math.radians(said.joint_acceleration_deg_s2),
        "cable speed": np.abs(np.diff(plan.robot.cable_lengths(angles), axis=0)).max() / pause / said.cable_speed,
    }


@given(seeds)
def test_random_limits_hold_for_joints_and_cables_along_the_whole_way(seed):
    task = random_task(seed, 0.02)
    robot = task.robot
    feeds = np.linspace(0.0, 0.5, 801)
    rng = np.random.default_rng(seed)
    waves, phases = rng.uniform(0.0, 30.0, (2, robot.sections, 2)), rng.uniform(0.0, 6.0, (robot.sections, 2))
    angles = 0.3 * np.sin(waves[0] * feeds[:, None, None] + phases)
    cables = robot.cable_lengths(angles)
    said, axis = robot.spec.limits, robot.spec.feed
    hardest_turn = said.joint_acceleration_deg_s2 * math.pi / 180
    moved = [
        Moved(np.ones((801, 1)), np.zeros((801, 1)), axis.speed, axis.acceleration_limit),
        Moved.along(feeds, angles, said.joint_speed_deg_s * math.pi / 180, hardest_turn),
        Moved.along(feeds, cables, said.cable_speed, said.cable_acceleration),
    ]
    limits = FeedLimits.of(feeds, moved)
    speed = rng.uniform(0.9, 1.0) * limits.speed
    quantities = [
        (angles.reshape(801, -1), said.joint_speed_deg_s * math.pi / 180, hardest_turn),
        (cables, said.cable_speed, said.cable_acceleration or math.inf),
    ]
    used = [limits.acceleration.max() / robot.spec.feed.acceleration_limit, speed.max() / robot.spec.feed.speed]
    for values, fastest, hardest in quantities:
        curve = CubicSpline(feeds, values)
        slope, bend = curve(feeds, 1), curve(feeds, 2)
        used.append(np.abs(slope * speed[:, None]).max() / fastest)
        for change in (limits.acceleration, -limits.acceleration):
            turned = slope * change[:, None] + bend * speed[:, None] ** 2
            used.append(np.abs(turned).max() / hardest)
    assert max(used) <= 1.01
    assert (limits.acceleration > 0).all()


@settings(max_examples=40)
@given(seeds, st.sampled_from([0.02, 0.15]))
def test_random_arms_on_random_paths_keep_all_limits_between_the_set_points_too(seed, period):
    task = random_task(seed, period)
    made = outcome(lambda: hognose.plan(task))
    plan = made.plan if isinstance(made, hognose.InfeasibleError) else made
    assert isinstance(plan, hognose.Plan)
    assert failed(plan.checks) <= {"bend_limits", "certified_along_path"}  # too sharp a path, whatever the speed
    assert max(parts_of_limits(plan).values()) <= DENSE


@pytest.mark.parametrize("period", [0.02, 0.15])
@pytest.mark.parametrize("name", ["obstacle-array", "pipe-tank"])
def test_both_cases_take_no_more_than_24_seconds_within_all_limits(tasks, name, period):
    plan = hognose.plan(variant(tasks[name], {"motion.profile": "fastest", "motion.period_s": period}))
    assert plan.good
    assert plan.time[-1] <= 24.0
    assert plan.robot.spec.feed.acceleration_limit == 0.1
    np.testing.assert_allclose(np.diff(plan.time), period, rtol=1e-9)
    parts = {**parts_of_limits(plan), **{f"true {k}": v for k, v in true_parts_of_limits(plan).items()}}
    assert max(parts.values()) <= DENSE
    assert parts["feed speed"] > 0.98  # nothing faster is possible where the slider is what limits
    assert plan.feed[0] == 0.0
    assert plan.feed[-1] == arrival(plan.task, plan.path)


@pytest.fixture(scope="module")
def fast(tasks):
    return hognose.plan(variant(tasks["pipe-tank"], {"motion.profile": "fastest"}))


def test_the_path_is_the_same_and_the_summary_says_how_it_is_fed(fast, plans):
    slow = plans["pipe-tank"]
    assert fast.feed[-1] == slow.feed[-1]
    np.testing.assert_allclose(fast.joints[[0, -1]], slow.joints[[0, -1]], atol=1e-12)
    assert fast.time[-1] < 0.5 * slow.time[-1]
    assert "steps of 150 ms, as fast as the limits allow, in 22." in fast.summary()
    assert fast.certified_clearance == pytest.approx(slow.certified_clearance, abs=0.0005)


def test_a_fast_plan_is_saved_read_and_checked_like_any_other(fast, tmp_path):
    fast.save(tmp_path / "fast.parquet")
    read = hognose.Plan.load(tmp_path / "fast.parquet")
    assert read.good
    assert np.array_equal(read.feed, fast.feed)
    assert {"feed_acceleration", "feed_jerk", "set_points_go_on"} <= {check.key for check in read.checks}
    assert "set_points_a_step_apart" not in {check.key for check in read.checks}


@pytest.mark.parametrize("profiles", [("fastest", None), ("constant", "fastest"), ("fastest", "constant")])
def test_a_retraction_has_its_own_profile(tasks, profiles):
    plan = hognose.plan(
        variant(tasks["pipe-tank"], {"motion.profile": profiles[0], "motion.retraction_profile": profiles[1]})
    )
    back = retraction(plan)
    assert back.good
    assert back.feed[0] == plan.feed[-1]
    assert back.feed[-1] == 0.0
    keys = {check.key for check in back.checks}
    assert ("feed_jerk" in keys) == ((profiles[1] or profiles[0]) == "fastest")
    again = retraction(back)
    assert again.good
    assert np.array_equal(again.feed, plan.feed)
    assert np.array_equal(again.angles, plan.angles)


@pytest.mark.parametrize(
    ("key", "robot"),
    [
        ("feed_acceleration", {"feed.acceleration": 0.05}),
        ("feed_jerk", {"feed.acceleration": 0.03}),
        ("cable_acceleration", {"limits.cable_acceleration": 0.001}),
        ("joint_acceleration", {"limits.joint_acceleration_deg_s2": 5.0}),
        ("feed_speed", {"feed.speed": 0.04}),
    ],
)
def test_a_fast_plan_fails_the_checks_of_a_weaker_robot_and_is_planned_anew_for_it(fast, key, robot):
    weaker = retasked(fast, robot=robot)
    assert key in failed(weaker.verified().checks)
    assert hognose.plan(weaker.task).good


def test_a_set_point_that_goes_back_fails(fast):
    import dataclasses

    feed = fast.feed.copy()
    feed[40] = feed[39] - 1e-4
    judged = dataclasses.replace(fast, feed=feed, checks=()).verified()
    assert "set_points_go_on" in failed(judged.checks)


def test_constant_feed_says_what_its_start_and_stop_take(plans):
    said = plans["obstacle-array"].check("feed_speed").detail
    assert said.startswith("constant: starts and stops within a period, with 155.6 mm/s² of the slider and ")


def test_constant_feed_is_refused_where_the_robot_says_that_its_slider_cannot_start_so_hard(plans):
    able = retasked(plans["pipe-tank"], robot={"feed.acceleration": 0.2}).verified()
    assert able.good
    assert able.check("feed_acceleration").value == pytest.approx(0.0035 / 0.15**2)
    weak = retasked(plans["pipe-tank"], robot={"feed.acceleration": 0.1}).verified()
    assert failed(weak.checks) == {"feed_acceleration"}


def test_where_a_whole_period_would_stop_a_joint_too_hard_the_short_step_takes_its_part(tasks):
    step = 0.02 * 0.0035 / 0.15
    hard = variant(
        tasks["pipe-tank"], {"motion.step": step, "motion.period_s": 0.02}, {"limits.joint_acceleration_deg_s2": 40.0}
    )
    plan = hognose.plan(hard)
    assert plan.good
    pauses, steps = np.diff(plan.time), np.diff(plan.feed)
    np.testing.assert_allclose(pauses[:-1], 0.02, rtol=1e-9)
    assert pauses[-1] == pytest.approx(0.02 * steps[-1] / step, rel=1e-6)
    assert steps[-1] / pauses[-1] == pytest.approx(step / 0.02, rel=1e-6)
    assert "its part" in plan.check("set_points_a_period_apart").detail
    back = retraction(plan)
    assert back.good
    assert np.diff(back.time)[0] == pytest.approx(pauses[-1])


def test_a_short_step_that_takes_any_other_time_fails(boards):
    import dataclasses

    time = boards.time.copy()
    time[-1] -= 0.01
    assert "set_points_a_period_apart" in failed(dataclasses.replace(boards, time=time).verified().checks)


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("feed.speed", "feed.speed"),
        ("feed.acceleration", "feed.acceleration"),
        ("limits.joint_speed_deg_s", "limits.joint_speed_deg_s"),
        ("limits.joint_acceleration_deg_s2", "limits.joint_acceleration_deg_s2"),
        ("limits.cable_speed", "limits.cable_speed"),
        ("limits.cable_acceleration", "limits.cable_acceleration"),
    ],
)
@pytest.mark.parametrize("value", [0.0, -1.0, math.inf, math.nan])
def test_limits_of_zero_are_refused(key, said, value):
    with pytest.raises(ValidationError, match=said):
        altered(hognose.load_robot("sjtu-25dof").spec, {key: value})


def test_limits_near_zero_make_a_motion_that_is_too_long_and_say_so(tasks):
    slow = variant(tasks["pipe-tank"], {"motion.profile": "fastest"}, {"feed.acceleration": 1e-9})
    with pytest.raises(
        hognose.InputError, match=r"motion\.profile: the fastest motion within the robot's limits takes"
    ):
        hognose.plan(slow)
    many = variant(tasks["pipe-tank"], {"motion.profile": "fastest", "motion.period_s": 1e-6})
    with pytest.raises(hognose.InputError, match=r"expected at most 1,000,000 s and 230,769 periods"):
        hognose.plan(many)


def test_a_slider_that_is_given_the_assumed_acceleration_differs_only_in_that_it_is_said():
    robot = hognose.load_robot("sjtu-25dof")
    assert robot.spec.feed.acceleration is None
    assert Robot.from_spec(altered(robot.spec, {"feed.acceleration": 0.1})).fingerprint != robot.fingerprint
