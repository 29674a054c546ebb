"""What is mounted behind the first joint is part of the arm's own body: certified like it, and named."""

from __future__ import annotations

import math

import numpy as np
import pytest
from certificate_oracles import halved_at_most
from hypothesis import given
from hypothesis import strategies as st
from planning_makers import altered, between, failed, outcome, random_robot
from scipy.spatial.transform import Rotation, Slerp

import hognose
from hognose.path import Path
from hognose.planning import Task, TaskSpec
from hognose.planning.certificate import (
    OwnClearance,
    certify_own_body,
    gliding_motion,
    interpolated_motion,
)
from hognose.planning.certificate.moving import Moving, Pieces, mounted_body, with_mount
from hognose.planning.checks import Shared
from hognose.planning.penetration import clearance_of
from hognose.planning.planner import plan_along
from hognose.robot import Robot, RobotSpec
from hognose.robot.base import Base, Slider, angles_on, joints_on
from hognose.robot.carrier import Carrier
from hognose.robot.own_body import MOUNT, bends_of
from tests.own_body_oracles import dense_clearance

PIECES = 12
SPACING = 0.01
ROUNDING = 1e-9
seeds = st.integers(0, 2**32 - 1)
sizes = st.floats(-3.0, 0.0).map(lambda exponent: 10.0**exponent)


def on_a_long_mount(rng: np.random.Generator, sections: int) -> Robot:
    spec = random_robot(rng, sections).spec
    return Robot.from_spec(altered(spec, {"base_length": float(rng.uniform(0.1, 0.9))}))


def slider(robot: Robot, rng: np.random.Generator) -> Slider:
    return Slider.before(rng.normal(size=3), robot, Rotation.random(rng=rng).as_matrix())


def backwards(robot: Robot, steps: int, swing: float, rng: np.random.Generator) -> np.ndarray:
    """Angles (T, n, 2) of an arm that turns back towards its mount within its first links, and wavers."""
    count, angles = robot.sections, rng.normal(0.0, 0.15, (robot.sections, 2))
    first, over = int(rng.integers(0, 3)), int(rng.integers(2, 5))
    angles[first : first + over, 0] += rng.uniform(0.9, 1.4) * math.pi / over
    return angles + np.cumsum(rng.normal(0.0, 0.3 * swing, (steps, count, 2)), axis=0)


def densest(robot: Robot, joints: np.ndarray, axes: np.ndarray) -> tuple[float, bool]:
    """The smallest clearance of sampled points of bodies (m, n+1, 3) with axes (m, 3, 3), and if it is the mount's."""
    long = robot.spec.base_length
    bodies = np.concatenate([joints[:, :1] - long * axes[:, None, :, 2], joints], axis=1)
    lengths, radii = np.append(long, robot.link_lengths), np.append(robot.body_radii[0], robot.body_radii)
    value, links = min(dense_clearance(body, lengths, radii, SPACING) for body in bodies)
    return value, links[0] == 0


def assert_never_less(proof: OwnClearance, dense: float) -> None:
    """Samples show at most a spacing more than there is."""
    assert proof.clearance <= min(max(dense, 0.0), proof.horizon) + ROUNDING


@given(seed=seeds, sections=st.integers(4, 12), steps=st.integers(1, 4), swing=sizes, halvings=st.sampled_from([0, 16]))
def test_no_interpolated_motion_on_a_slider_comes_closer_to_its_mount_than_certified(
    seed, sections, steps, swing, halvings
):
    rng = np.random.default_rng(seed)
    robot = on_a_long_mount(rng, sections)
    base, angles = slider(robot, rng), backwards(robot, steps, swing, rng)
    at = np.cumsum(rng.uniform(0.0, 0.03, steps))[:, None]
    vertices = joints_on(base, robot, angles, at)
    moving = interpolated_motion(robot, base, at, angles)
    with halved_at_most(halvings):
        proof = certify_own_body(moving, robot, vertices, bends_of(angles), base)
    many = joints_on(base, robot, between(angles, PIECES), between(at, PIECES)) if steps > 1 else vertices
    assert base.R_task_base is not None
    axes = np.broadcast_to(base.R_task_base, (len(many), 3, 3))
    assert_never_less(proof, densest(robot, many, axes)[0])


def poses(
    carrier: Carrier, steps: int, swing: float, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinates (T, 7) that turn and go, and places (m, 3) and axes (m, 3, 3) of many times between them."""
    places = carrier.start + np.cumsum(rng.normal(0.0, 0.05 * swing, (steps, 3)), axis=0)
    turns = Rotation.from_matrix(carrier.R_task_start) * Rotation.from_rotvec(
        np.cumsum(rng.normal(0.0, 0.4 * swing, (steps, 3)), axis=0)
    )
    quaternions = turns.as_quat(canonical=False)[:, [3, 0, 1, 2]]
    flips = np.where((quaternions[1:] * quaternions[:-1]).sum(axis=1) < 0, -1.0, 1.0)
    quaternions *= np.cumprod(np.append(1.0, flips))[:, None]
    times = between(np.arange(steps, dtype=float), PIECES)
    axes = Slerp(np.arange(steps), turns)(times).as_matrix()
    return np.column_stack([places, quaternions]), between(places, PIECES), axes


@given(seed=seeds, sections=st.integers(4, 10), steps=st.integers(2, 4), swing=sizes, halvings=st.sampled_from([0, 16]))
def test_a_mount_that_goes_and_turns_with_a_carrier_is_certified_too(seed, sections, steps, swing, halvings):
    rng = np.random.default_rng(seed)
    robot = on_a_long_mount(rng, sections)
    carrier = Carrier.before(rng.normal(size=3), robot, Rotation.random(rng=rng).as_matrix())
    angles = backwards(robot, steps, swing, rng)
    at, places, axes = poses(carrier, steps, swing, rng)
    moving, vertices = interpolated_motion(robot, carrier, at, angles), joints_on(carrier, robot, angles, at)
    with halved_at_most(halvings):
        proof = certify_own_body(moving, robot, vertices, bends_of(angles), carrier)
    arms = robot.joint_positions(between(angles, PIECES))
    many = places[:, None] + np.einsum("txy,tky->tkx", axes, arms)
    assert_never_less(proof, densest(robot, many, axes)[0])


@pytest.mark.parametrize("kind", ["slider", "carrier"])
def test_what_samples_show_to_touch_the_mount_is_never_certified(kind):
    """As above, and so that the mount is what is touched."""
    touching = missed = 0
    for seed in range(25):
        rng = np.random.default_rng(seed)
        robot = on_a_long_mount(rng, 9)
        angles = backwards(robot, 3, 0.2, rng)
        if kind == "slider":
            base: Base = slider(robot, rng)
            assert isinstance(base, Slider)
            assert base.R_task_base is not None
            at = np.cumsum(rng.uniform(0.0, 0.03, 3))[:, None]
            many = joints_on(base, robot, between(angles, PIECES), between(at, PIECES))
            axes = np.broadcast_to(base.R_task_base, (len(many), 3, 3))
        else:
            base = Carrier.before(rng.normal(size=3), robot, Rotation.random(rng=rng).as_matrix())
            at, places, axes = poses(base, 3, 0.2, rng)
            many = places[:, None] + np.einsum("txy,tky->tkx", axes, robot.joint_positions(between(angles, PIECES)))
        vertices = joints_on(base, robot, angles, at)
        proof = certify_own_body(interpolated_motion(robot, base, at, angles), robot, vertices, bends_of(angles), base)
        dense, mounts = densest(robot, many, axes)
        if dense <= 0 and mounts:
            touching += 1
            missed += proof.clearance > 0
            alone = certify_own_body(interpolated_motion(robot, base, at, angles), robot, vertices)
            if alone.clearance > 0:
                assert proof.links[0] == MOUNT
    assert missed == 0
    assert touching >= 5


@given(seed=seeds, sections=st.integers(4, 8), step=st.floats(0.002, 0.1), carried=st.booleans(), bent=st.booleans())
def test_no_gliding_motion_comes_closer_to_its_mount_than_certified(seed, sections, step, carried, bent):
    """Round a helix; a carrier takes the mount along with the first link."""
    rng = np.random.default_rng(seed)
    robot = on_a_long_mount(rng, sections)
    radius, rise = rng.uniform(0.12, 0.3), rng.uniform(0.0, 0.03)
    around = np.linspace(0.0, rng.uniform(1.0, 6.5), 40)
    way_points = np.column_stack([radius * (1 - np.cos(around)), rise * around, radius * np.sin(around)])
    path = Path.through(way_points, 3, (0.0, 0.0, 1.0)).with_run(robot.length)
    base = Carrier.before(np.zeros(3), robot, np.eye(3)) if carried else Slider.before(np.zeros(3), robot)
    feeds = np.arange(0.0, max(2 * step, path.length - 1.2 * robot.length), step)
    feeds = feeds[feeds <= (path.length - 1.2 * robot.length if carried else robot.length)]
    moving = gliding_motion(path, robot, feeds) if len(feeds) > 1 else None
    if moving is None:
        return
    many = hognose.follow(path, robot.link_lengths, between(feeds, 4))
    first = many[:, 1] - many[:, 0]
    along = first / np.linalg.norm(first, axis=1, keepdims=True) if carried else np.array([[0.0, 0.0, 1.0]])
    axes = np.broadcast_to(np.eye(3), (len(many), 3, 3)).copy()
    axes[:, :, 2] = along
    dense, _ = densest(robot, many[::3], axes[::3])
    joints = hognose.follow(path, robot.link_lengths, feeds)
    bends = bends_of(angles_on(base, robot, joints, base.coordinates(feeds, joints))) if bent else None
    for halvings in (0, 16):
        with halved_at_most(halvings):
            assert_never_less(certify_own_body(moving, robot, joints, bends, base), dense)


def ways(moving: Moving, base: Base, vertices: np.ndarray) -> np.ndarray:
    """How far (T-1,) m the far end of the mount goes at most, from step to step."""
    bodies, none = mounted_body(moving, base, vertices), np.zeros((len(vertices), 1))
    return with_mount(moving, base).travel(Pieces.between(moving.parameters, bodies, none))[0][:, 0]


@given(seed=seeds, swing=sizes)
def test_the_mount_of_a_carrier_bulges_no_farther_than_is_said(seed, swing):
    rng = np.random.default_rng(seed)
    robot = on_a_long_mount(rng, 2)
    carrier = Carrier.before(rng.normal(size=3), robot, Rotation.random(rng=rng).as_matrix())
    at, places, axes = poses(carrier, 3, swing, rng)
    moving = interpolated_motion(robot, carrier, at, np.zeros((3, 2, 2)))
    bodies = mounted_body(moving, carrier, joints_on(carrier, robot, np.zeros((3, 2, 2)), at))
    pieces = Pieces.between(moving.parameters, bodies, np.zeros((3, 1)))
    said = with_mount(moving, carrier).travel(pieces)[1][:, 0]
    off = places - robot.spec.base_length * axes[:, :, 2] - between(bodies[:, 0], PIECES)
    seen = np.linalg.norm(off, axis=1)
    most = [seen[k * PIECES : (k + 1) * PIECES + 1].max() for k in range(2)]
    assert (most <= said + ROUNDING).all()


@pytest.mark.parametrize("seed", range(8))
def test_the_mount_of_a_gliding_arm_goes_no_farther_than_is_said(seed):
    """On a circle, where it turns all the time."""
    rng = np.random.default_rng(seed)
    radius, step = rng.uniform(0.15, 0.5), float(10 ** rng.uniform(-3.0, -1.0))
    robot = on_a_long_mount(rng, 2)
    around = np.linspace(0.0, 6.0, 60)
    circle = np.column_stack([radius * (1 - np.cos(around)), np.zeros(60), radius * np.sin(around)])
    path = Path.through(circle, 3, (0.0, 0.0, 1.0)).with_run(robot.length)
    feeds = robot.length + step * np.arange(int(min(8, (path.length - 2.4 * robot.length) / step)), dtype=np.float64)
    moving = gliding_motion(path, robot, feeds) if len(feeds) > 1 else None
    if moving is None:
        return
    base = Carrier.before(np.zeros(3), robot, np.eye(3))
    said = ways(moving, base, hognose.follow(path, robot.link_lengths, feeds))
    many = hognose.follow(path, robot.link_lengths, between(feeds, 20))
    ends = many[:, 0] - robot.spec.base_length * (many[:, 1] - many[:, 0]) / robot.link_lengths[0]
    gone = np.linalg.norm(np.diff(ends, axis=0), axis=1)[: 20 * (len(feeds) - 1)].reshape(-1, 20).sum(axis=1)
    assert (gone <= said + ROUNDING).all()


@given(seed=seeds, sections=st.integers(2, 10), step=st.floats(0.002, 0.1))
def test_bends_of_a_gliding_arm_sum_up_to_no_more_than_is_said(seed, sections, step):
    """Of every run of joints: between the steps no more than at one of them and the slack."""
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, sections)
    steady = np.cumsum(rng.normal(0.0, 0.08, (9, 3)) + np.array([0.0, 0.0, 0.15]), axis=0)
    path = Path.through(np.concatenate([np.zeros((1, 3)), steady]), 3, (0.0, 0.0, 1.0)).with_run(robot.length)
    feeds = np.arange(0.0, path.length - 1.2 * robot.length, step, dtype=np.float64)
    moving = gliding_motion(path, robot, feeds) if len(feeds) > 1 else None
    if moving is None:
        return
    bends = bends_of(robot.angles(hognose.follow(path, robot.link_lengths, feeds)))
    sums = np.cumsum(moving.bends_within(bends), axis=1)
    directions = (
        np.diff(hognose.follow(path, robot.link_lengths, between(feeds, 8)), axis=1) / robot.link_lengths[:, None]
    )
    half = 0.5 * np.linalg.norm(np.diff(directions, axis=1), axis=2)
    seen = np.cumsum(2 * np.arcsin(np.minimum(half, 1.0)), axis=1)
    seen = np.concatenate([np.zeros((len(seen), 1)), seen], axis=1)  # of all joints but the first
    for row in range(len(seen)):
        low = min(row // 8, len(feeds) - 2)
        for i in range(sections):
            most = np.maximum(*(sums[k] - sums[k, i] for k in (low, low + 1)))
            assert (seen[row, i:] - seen[row, i] <= most[i:] + 1e-7).all()


@pytest.mark.parametrize("name", ["obstacle-array", "pipe-tank"])
def test_both_cases_of_the_paper_need_no_distance(plans, monkeypatch, name):
    """Bends alone clear the arm of itself and of its mount, in all three motions."""
    monkeypatch.setattr("hognose.planning.certificate.own_body._strides", None)
    monkeypatch.setattr("hognose.planning.certificate.own_body.separation", None)
    plan = plans[name]
    assert plan.task.base.mount is not None
    shared = Shared(plan)
    assert shared.gliding is not None
    assert shared.drives is not None
    found = shared.within_body
    assert (found.clearance, found.step) == (found.horizon, None)


def long_arm(links: int, **more: object) -> Robot:
    """The bundled arm with more links that bend more, as if it had no weight."""
    spec = hognose.load_robot("sjtu-25dof").spec.model_dump(mode="json", by_alias=True)
    spec["cables"] = None
    spec["section"][0] |= {"count": links, "bend_limit_deg": 35.0}
    spec["feed"]["max"], spec["limits"]["cable_travel"] = 0.091 * links, [-1.0, 1.0]
    return Robot.from_spec(RobotSpec.model_validate(spec | more))


def task_through(way_points: np.ndarray, robot: Robot, **base: object) -> Task:
    """In an empty space, slowly."""
    said = {
        "name": "through itself",
        "robot": "sjtu-25dof",
        "margin": 0.0,
        "path": {"way_points": [tuple(place) for place in way_points.tolist()], "detour": False},
        "motion": {"step": 0.01, "period_s": 2.0},
    }
    return Task(TaskSpec.model_validate(said | ({"base": base} if base else {})), robot)


def through_the_mount() -> np.ndarray:
    """Straight on, back in half a turn, and across the axis behind the entrance."""
    half, quarter = np.linspace(0.0, math.pi, 9), np.linspace(0.0, math.pi / 2, 5)
    turn = np.column_stack([0.2 * (1 - np.cos(half)), 0 * half, 0.1 + 0.2 * np.sin(half)])
    back = np.array([[0.4, 0.0, 0.0], [0.4, 0.0, -0.1], [0.4, 0.0, -0.2]])
    across = np.column_stack([0.2 + 0.2 * np.cos(quarter), 0 * quarter, -0.2 - 0.2 * np.sin(quarter)])
    return np.concatenate([[[0.0, 0.0, 0.0]], turn, back, across[1:], [[0.0, 0.0, -0.4], [-0.1, 0.0, -0.4]]])


@pytest.mark.parametrize("kind", ["slider", "cart"])
def test_a_loop_through_its_own_mount_is_not_good_and_names_mount_and_link(kind):
    robot = long_arm(20, base_length=0.7)
    where = {"kind": kind, "position": (0.0, 0.0, -robot.length)} if kind == "cart" else {}
    error = outcome(lambda: plan_along(task_through(through_the_mount(), robot, **where)))
    assert isinstance(error, hognose.InfeasibleError)
    assert failed(error.plan.checks) == {"own_body"}
    check = error.plan.check("own_body")
    assert check.link is not None
    assert f"(the mount and link {check.link} at (0.0, 0.0, -40" in check.sentence.replace("-0.0", "0.0")
    assert check.value == pytest.approx(-2 * robot.body_radii[0], abs=1e-4)
    plan = plan_along(task_through(through_the_mount(), long_arm(20, base_length=0.0), **where))
    assert plan.good


def test_whole_counts_that_make_turns_touch_are_not_good():
    """Once round, rising by little more than the body is thick; drives of few counts do not come as close as that."""
    around = np.radians(np.arange(15.0, 361.0, 15.0))
    turn = np.column_stack([0.4 * (1 - np.cos(around)), 0.0465 * around / (2 * math.pi), 0.4 + 0.4 * np.sin(around)])
    way_points = np.concatenate([[[0.0, 0.0, 0.0], [0.0, 0.0, 0.4]], turn, [[0.0, 0.0465, 0.7]]])
    fine = plan_along(task_through(way_points, long_arm(36)))
    assert fine.good
    assert 0 < fine.check("own_body").value < 0.0016
    section = long_arm(36).spec.model_dump(mode="json", by_alias=True)["section"]
    section[0]["transmission"]["counts_per_turn"] = 4
    error = outcome(lambda: plan_along(task_through(way_points, long_arm(36, section=section))))
    assert isinstance(error, hognose.InfeasibleError)
    assert failed(error.plan.checks) == {"own_body"}
    check, shared = error.plan.check("own_body"), Shared(error.plan)
    robot, body = error.plan.robot, shared.counted_line[check.step]
    dense, links = dense_clearance(body, robot.link_lengths, robot.body_radii, 0.002)
    assert check.value <= dense < 0
    assert f"links {links[0] + 1} and {links[1] + 1} at " in check.sentence
    linear = certify_own_body(shared.linear, robot, error.plan.centre_line, base=error.plan.task.base)
    assert linear.clearance > 0


@pytest.mark.parametrize("beside", [0.1, 0.2, 0.3])
def test_a_carrier_s_mount_that_swings_while_joints_glide_keeps_clear_as_certified(beside):
    """On a path that waves once a step the poses at the steps are alike, while the mount swings in between."""
    wave, high = 0.2, 0.01
    along = np.arange(0.0, 1.4, wave / 8)
    way = np.column_stack([high * np.sin(2 * np.pi * along / wave) * np.clip(along / 0.1, 0.0, 1.0), 0 * along, along])
    robot = long_arm(6, base_length=1.0)
    task = task_through(way, robot, kind="arm")
    fine = np.linspace(0.0, wave, 2001)
    step = float(np.hypot(np.diff(fine), np.diff(high * np.sin(2 * np.pi * fine / wave))).sum())
    box = {"kind": "box", "center": (-beside - 0.05, 0.0, -0.5), "size": (0.1, 0.4, 0.6)}
    spec = task.spec.model_dump(by_alias=True) | {"obstacle": [box], "motion": {"step": step, "period_s": 5.0}}
    task = Task(TaskSpec.model_validate(spec), robot)
    error = outcome(lambda: plan_along(task))
    plan = error.plan if isinstance(error, hognose.InfeasibleError) else error
    assert isinstance(plan, hognose.Plan)
    joints = hognose.follow(plan.path, robot.link_lengths, between(plan.feed, 60))
    far = joints[:, 0] - (joints[:, 1] - joints[:, 0]) / robot.link_lengths[0]
    dense = float((task.scene.distance(far, joints[:, 0]).value - robot.body_radii[0]).min())
    check = plan.check("clearance_of_mount")
    assert check.value is not None
    assert check.value <= max(dense, 0.0) + ROUNDING
    assert check.value >= min(dense, plan.horizon) - (0.005 if dense > 0 else 0.0)
    assert dense > 0 or not check.ok


@pytest.mark.parametrize("step", [0.004, 0.03])
@pytest.mark.parametrize("moves", [False, True])
def test_a_mount_that_touches_is_as_deep_as_it_is_at_the_steps(step, moves):
    """However far it swings from step to step: what it may do in between is not told as if it did."""
    bend = np.linspace(0.0, 0.3, 9)
    way = np.column_stack([0.4 * bend**2, 0 * bend, bend])
    robot = long_arm(4, base_length=1.0)
    task = task_through(way, robot, kind="arm")
    box = {"kind": "box", "center": (-0.05 - 0.001, 0.0, -0.9), "size": (0.1, 0.4, 0.3)}
    later = [{"time_s": 0.0}, {"time_s": 1.0, "position": (0.0, 0.001, 0.0)}]
    said = {"obstacle": [box | {"motion": later} if moves else box], "motion": {"step": step, "period_s": 5.0}}
    task = Task(TaskSpec.model_validate(task.spec.model_dump(by_alias=True) | said), robot)
    error = outcome(lambda: plan_along(task))
    assert isinstance(error, hognose.InfeasibleError)
    plan, radius = error.plan, robot.body_radii[0]
    first, second = plan.joints[:, 0], plan.joints[:, 1]
    far = first - (second - first) / robot.link_lengths[0]
    scene = task.moving[0].scene if moves else task.scene
    seen = float(clearance_of(scene, np.stack([far, first], axis=1), np.array([radius]), plan.horizon).min())
    assert plan.check("clearance_of_mount").value == pytest.approx(seen, abs=1e-9)
    assert seen < -0.001
