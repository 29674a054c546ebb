"""Plans and certificates of arms whose sections are of other kinds than links."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planning_makers import between, random_scene
from robot_oracles import robot_file
from section_makers import mixed, mixed_robot, of_kind

import hognose
from hognose.errors import InputError
from hognose.planning import Plan, Task, TaskSpec, retraction, run_checks
from hognose.planning.arrival import arrival
from hognose.planning.certificate import certify, interpolated_motion
from hognose.planning.certificate.moving import Pieces
from hognose.planning.followed import method_of
from hognose.planning.penetration import clearance_of, section_clearance
from hognose.planning.planner import desired_path
from hognose.robot import Robot, RobotSpec
from hognose.robot.base import Slider, centre_line, joints_on
from hognose.robot.section_cable import CableLaw
from hognose.robot.sections import KINDS, Geometry, Piece
from tests.recipes import recipe

seeds = st.integers(0, 2**32 - 1)
START = np.array([0.1, -0.2, 0.3])
#: How close the certificate comes to what was seen, m: docs/certificate.md.
TIGHTNESS = 2.5e-4


def moves(rng, robot, steps=4, swing=0.1):
    """Angles (T, n, 2) within the limits, and feeds (T,)."""
    angles = np.cumsum(rng.normal(0, swing, (steps, robot.sections, 2)), axis=0)
    return np.clip(angles, -robot.bend_limits, robot.bend_limits), np.cumsum(rng.uniform(0, 0.05, steps))


def dense_clearance(scene, robot, base, angles, at):
    """The smallest clearance (m) of the true centre line, by balls a tenth of a millimetre of sagitta apart."""
    model, worst = mixed(robot), math.inf
    fine = type(model)(model.kinds, model.sections, robot.spec.tool_length)
    fine.counts = np.where(model.table[:, 3] > 0, 24, 1)
    joints = joints_on(base, robot, angles, at)
    line = base.turned(_vertices(fine, base.aligned(joints, at)), at)
    radii = np.repeat(robot.body_radii[np.repeat(np.arange(robot.sections), np.diff(model.first))], fine.counts)
    return min(worst, float(clearance_of(scene, line, radii, 1.0).min()))


def _vertices(model, joints):
    from hognose.robot.sections.chain import vertices_along

    out = np.empty((len(joints), int(model.counts.sum()) + 1, 3))
    joints = np.ascontiguousarray(joints)
    vertices_along(model.angles(joints), joints, model.table, model.counts, model.first, out)
    return out


@settings(deadline=None, max_examples=25)
@given(seed=seeds, sections=st.integers(1, 5))
def test_nothing_comes_closer_than_is_certified(seed, sections):
    rng = np.random.default_rng(seed)
    robot, base = mixed_robot(seed, sections), Slider(START, 1.0, 0.0, 0.0)
    angles, feeds = moves(rng, robot)
    at = feeds[:, None]
    joints = joints_on(base, robot, angles, at)
    scene = random_scene(rng, joints.min(axis=(0, 1)), joints.max(axis=(0, 1)))
    line = centre_line(base, robot, joints, at)
    found = section_clearance(scene, robot, line, 1.0)
    proof = certify(interpolated_motion(robot, base, at, angles), robot, scene, line, found, 1.0)
    seen = dense_clearance(scene, robot, base, between(angles, 50), between(at, 50))
    assert proof.clearance <= max(seen, 0.0) + 1e-9
    moved = np.linalg.norm(np.diff(joints_on(base, robot, between(angles, 50), between(at, 50)), axis=0), axis=2).max()
    left_out = float(robot.model.sagitta(robot.link_lengths, robot.bend_limits).max())
    assert proof.clearance <= 0 or proof.clearance >= seen - TIGHTNESS - left_out - 0.6 * moved
    assert 0 <= proof.link < sections


@settings(deadline=None, max_examples=60)
@given(seed=seeds, sections=st.integers(1, 6), swing=st.floats(1e-4, 1.2))
def test_no_vertex_leaves_its_chord_by_more_than_the_bulge(seed, sections, swing):
    rng = np.random.default_rng(seed)
    robot, base = mixed_robot(seed, sections), Slider(np.zeros(3), 1.0, 0.0, 0.0)
    angles = rng.uniform(-0.8, 0.8, (1, sections, 2))
    angles = np.concatenate([angles, angles + rng.uniform(-swing, swing, angles.shape)])
    at = np.zeros((2, 1))
    motion = interpolated_motion(robot, base, at, angles)
    dense = motion.place(between(motion.parameters, 200))[1]
    pieces = Pieces.between(motion.parameters, dense[[0, -1]], np.zeros((2, 0)))
    gone, bulge = motion.travel(pieces)
    part = np.linspace(0, 1, len(dense))[:, None, None]
    off = np.linalg.norm(dense - (1 - part) * dense[0] - part * dense[-1], axis=2).max(axis=0)
    assert (off <= bulge[0] + 1e-12).all()
    np.testing.assert_allclose(gone[0], np.linalg.norm(dense[-1] - dense[0], axis=1), atol=1e-15)


@pytest.mark.parametrize("bend", [0.0, 0.4, 1.5])
def test_the_bulge_of_an_arc_is_not_far_from_what_it_does(bend):
    """An arc that bends on in its plane: the bound is no more than twice the truth."""
    robot, base = Robot.from_spec(spec_of([of_kind("arc", bend_limit_deg=80.0)])), Slider(np.zeros(3), 1.0, 0.0, 0.0)
    angles = np.array([[[bend, 0.0]], [[bend + 0.02, 0.0]]])
    motion = interpolated_motion(robot, base, np.zeros((2, 1)), angles)
    dense = motion.place(between(motion.parameters, 20))[1]
    bulge = motion.travel(Pieces.between(motion.parameters, dense[[0, -1]], np.zeros((2, 0))))[1]
    part = np.linspace(0, 1, len(dense))[:, None, None]
    off = np.linalg.norm(dense - (1 - part) * dense[0] - part * dense[-1], axis=2).max(axis=0)
    assert off[-1] <= bulge[0, -1] <= 3 * off[-1]


@settings(deadline=None, max_examples=40)
@given(seeds)
def test_along_an_arc_the_rate_of_turning_changes_by_no_more_than_is_taken(seed):
    """|d/dt of the angular velocity of exp(σ w(t))| <= min(1/2, σ θ/6) (σ |ẇ|)², by differences of differences."""
    rng = np.random.default_rng(seed)
    start, rate, step = rng.uniform(-1.5, 1.5, 2), rng.uniform(-1, 1, 2), 1e-3
    times = step * np.arange(-200, 201)

    def frames(times):
        vectors = start + times[:, None] * rate
        from scipy.spatial.transform import Rotation

        return Rotation.from_rotvec(np.column_stack([vectors[:, 1], vectors[:, 0], np.zeros(len(times))]))

    turned = frames(times + step / 2) * frames(times - step / 2).inv()
    velocity = turned.as_rotvec() / step
    change = np.linalg.norm(np.diff(velocity, axis=0), axis=1) / step
    largest = np.linalg.norm(start + times[:, None] * rate, axis=1).max()
    speed = np.linalg.norm(rate)
    assert np.linalg.norm(velocity, axis=1).max() <= speed * (1 + 1e-5)
    assert change.max() <= min(0.5, largest / 6) * speed**2 * (1 + 1e-3)


def spec_of(sections, **changes):
    return RobotSpec.model_validate(robot_file(sections, **changes))


def task_of(boards, sections, method="aim", **motion):
    """The task of the boards for an arm of other sections, at a gentle speed."""
    arm = boards.robot.spec
    spec = spec_of(sections, feed=arm.feed, limits=arm.limits)
    changed = boards.task.spec.motion.model_copy(update={"method": method, **motion})
    return Task(boards.task.spec.model_copy(update={"motion": changed}), Robot.from_spec(spec))


ARMS = {
    "arcs": [of_kind("arc", count=12, disks=6)],
    "led arcs": [of_kind("arc", count=12)],
    "stacks": [of_kind("joints", count=12, half_lengths=(0.003, 0.003))],
    "hinges": [of_kind("hinges", count=12)],
    "mixed": [
        of_kind("link", count=4),
        of_kind("arc", count=4),
        of_kind("hinges", count=2),
        of_kind("joints", count=2),
    ],
}


@pytest.fixture(scope="module")
def arm_plans(boards):
    return {name: hognose.plan(task_of(boards, sections)) for name, sections in ARMS.items()}


@pytest.mark.parametrize("name", list(ARMS))
def test_arms_of_every_kind_are_planned_and_proven(arm_plans, name):
    plan = arm_plans[name]
    assert plan.good
    assert plan.tip_error.max() <= 1e-12
    target = plan.path.point(plan.path.length)
    np.testing.assert_allclose(plan.joints[-1, -1], target, rtol=0, atol=1e-9)
    checks = {check.key: check for check in plan.checks}
    assert checks["certified_interpolated"].ok
    assert checks["certified_interpolated"].value <= plan.clearance.min()
    assert checks["own_body"].ok
    not_known = {key for key, check in checks.items() if check.ok is None}
    assert not_known == {"peak_tension"}
    assert checks["certified_cables"].value <= plan.clearance.min()
    # Steps are small: cables cost less than their tightness.
    assert checks["certified_cables"].value == pytest.approx(checks["certified_interpolated"].value, abs=2 * TIGHTNESS)
    again = joints_on(plan.task.base, plan.robot, plan.angles, plan.at)
    np.testing.assert_allclose(again, plan.joints, rtol=0, atol=1e-12)
    assert not np.abs(plan.angles[0]).max() > 1e-12
    assert plan.body_deviation.max() < 0.006  # where an arc begins behind a link, it begins beside the tangent


def test_exact_following_lays_ends_on_the_path_and_does_not_judge_gliding(boards):
    plan = hognose.plan(task_of(boards, ARMS["stacks"], "exact"))
    checks = {check.key: check for check in plan.checks}
    assert plan.path.distance_to(plan.joints).max() <= 1e-12
    assert checks["joints_on_path"].ok
    assert checks["certified_along_path"].ok is None


@pytest.mark.parametrize("name", ["arcs", "mixed"])
def test_whole_arm_fits_are_planned_proven_and_closer_to_the_path(boards, arm_plans, name):
    plan = hognose.plan(task_of(boards, ARMS[name], "fitted"))
    assert plan.good
    assert plan.tip_error.max() <= 1e-9  # Newton ends by its step
    np.testing.assert_allclose(plan.joints[-1, -1], plan.path.point(plan.path.length), rtol=0, atol=1e-9)
    assert np.abs(plan.angles[0]).max() <= 1e-12
    assert (np.abs(plan.angles) <= plan.robot.bend_limits + 1e-12).all()
    away = [
        plan.path.distance_to(each.robot.model.vertices(each.joints[::10])).ravel() for each in (plan, arm_plans[name])
    ]
    assert np.sqrt((away[0] ** 2).mean()) < 0.9 * np.sqrt((away[1] ** 2).mean())


def test_a_plan_is_the_same_from_its_file(arm_plans, tmp_path):
    plan = arm_plans["mixed"]
    plan.save(tmp_path / "plan.parquet")
    again = Plan.load(tmp_path / "plan.parquet")
    assert again.robot.fingerprint == plan.robot.fingerprint
    np.testing.assert_array_equal(again.joints, plan.joints)
    assert [(check.key, check.ok) for check in run_checks(again)] == [(check.key, check.ok) for check in plan.checks]


def test_the_way_out_is_the_way_in(arm_plans):
    out = retraction(arm_plans["arcs"])
    assert out.good
    np.testing.assert_array_equal(out.angles, arm_plans["arcs"].angles[::-1])


def test_the_fastest_profile_keeps_the_limits(boards):
    plan = hognose.plan(task_of(boards, ARMS["arcs"], profile="fastest"))
    assert plan.good
    assert {check.key for check in plan.checks if check.ok is None} == {"peak_tension"}


def test_a_turned_slider_makes_the_same_motion(boards, arm_plans):
    """The whole task in another frame: angles are the same, joints are turned."""
    from planning_makers import moved

    task = task_of(boards, ARMS["mixed"])
    turned, put = moved(task, 3)
    plan = hognose.plan(turned)
    np.testing.assert_allclose(plan.angles, arm_plans["mixed"].angles, rtol=0, atol=1e-8)
    np.testing.assert_allclose(plan.joints, put(arm_plans["mixed"].joints), rtol=0, atol=1e-8)


def test_a_body_that_meets_a_board_is_found_where_it_is(boards):
    """An arm too thick for the holes, so that the curved body meets a board between its joints."""
    thick = [of_kind("arc", count=12, body_diameter=0.075, pitch=0.091)]
    with pytest.raises(hognose.InfeasibleError, match="board"):
        hognose.plan(task_of(boards, thick))


def test_a_target_out_of_reach_is_said(boards):
    short = [of_kind("arc", count=4)]
    with pytest.raises(hognose.HognoseError, match=r"mm"):
        hognose.plan(task_of(boards, short))


def test_methods_for_links_are_refused_for_other_sections(boards):
    with pytest.raises(InputError, match="'fabrik' is for arms of rigid links"):
        hognose.plan(task_of(boards, ARMS["arcs"], "fabrik"))


def test_a_task_for_links_does_not_aim(boards):
    changed = boards.task.spec.motion.model_copy(update={"method": "aim"})
    with pytest.raises(InputError, match="for rigid links take exact"):
        hognose.plan(Task(boards.task.spec.model_copy(update={"motion": changed}), boards.robot))


def test_a_kind_by_the_recipe_is_planned_and_proven(boards, monkeypatch):
    """A file and a row in the table: nothing else knows of it."""
    names = {"Geometry": Geometry, "Piece": Piece, "CableLaw": CableLaw, "Array": np.ndarray}
    exec(recipe("A kind of section"), names)
    monkeypatch.setitem(KINDS, "neck", names["Neck"]())
    plan = hognose.plan(task_of(boards, [of_kind("arc", count=12) | {"kind": "neck"}]))
    assert plan.good
    assert mixed(plan.robot).chords.min() > 1
    again = plan.robot.angles_from_cables(plan.cable_lengths, 0.9 * plan.angles)
    np.testing.assert_allclose(again, plan.angles, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    "way", [{"way_points": [[0, 0, 0], [0, 0, 0.5]]}, {"entrance": [0, 0, 0], "target": [0, 0.1, 0.5]}]
)
def test_a_drum_is_refused_before_anything_is_planned_or_searched(boards, way):
    spec = boards.task.spec.model_dump(by_alias=True) | {"base": {"kind": "drum", "radius": 0.5}, "path": way}
    motion = boards.task.spec.motion.model_copy(update={"method": "aim"})
    drummed = TaskSpec.model_validate(spec).model_copy(update={"motion": motion})
    with pytest.raises(
        InputError, match="how they bend round a drum is not known; expected a slider, a cart or a carr"
    ):
        hognose.plan(Task(drummed, task_of(boards, ARMS["arcs"]).robot))


def test_between_counts_of_arcs_without_disks_angles_go_linearly(arm_plans):
    """The certificate of interpolated cables against dense cable lengths, rounded at their ends."""
    plan = arm_plans["led arcs"]
    robot, rows = plan.robot, slice(200, 260)
    lengths = robot.lengths_of_counts(plan.motor_counts[rows])
    dense = between(lengths, 8)
    found = robot.angles_from_cables(dense, between(plan.angles[rows], 8))
    ends = robot.angles_from_cables(lengths, plan.angles[rows])
    np.testing.assert_allclose(found, between(ends, 8), rtol=0, atol=1e-9)
    checks = {check.key: check for check in plan.checks}
    at = between(plan.at[rows], 8)
    seen = dense_clearance(plan.scene, robot, plan.task.base, found, at)
    assert checks["certified_cables"].ok
    assert checks["certified_cables"].value <= seen
    assert 0 < checks["rounding_to_counts"].value < 1e-4


def test_the_clearance_of_a_section_is_the_smallest_of_its_chords():
    rng = np.random.default_rng(2)
    robot = mixed_robot(2)
    line = robot.model.vertices(robot.joint_positions(moves(rng, robot)[0]))
    scene = random_scene(rng, line.min(axis=(0, 1)) - 0.1, line.max(axis=(0, 1)) + 0.1)
    chords = clearance_of(scene, line, robot.chord_radii, 1.0)
    smallest = [chords[:, robot.chord_sections == i].min(axis=1) for i in range(robot.sections)]
    np.testing.assert_array_equal(section_clearance(scene, robot, line, 1.0), np.transpose(smallest))


def test_the_fastest_feed_is_of_the_tasks_own_method():
    """Three arcs bend too much for ends on the path: what the task follows with decides how fast it can go."""
    task = hognose.load_task("baffled-tank")
    spec = task.spec.model_copy(update={"motion": task.spec.motion.model_copy(update={"profile": "fastest"})})
    fast = hognose.plan(Task(spec, task.robot))
    assert fast.good
    assert fast.time[-1] < hognose.plan(task).time[-1]


@pytest.mark.parametrize("method", ["exact", "aim"])
@pytest.mark.parametrize("kind", ["arc", "joints"])
def test_the_target_is_arrived_at_where_the_arm_cannot_be_followed_beyond_the_run(kind, method):
    """A screw of one turn and a quarter: farther in than the target, the slider's line would have to bend."""
    parts = [
        of_kind(kind, count=15, pitch=0.06, half_lengths=None if kind == "arc" else (0.003, 0.003), bend_limit_deg=60.0)
    ]
    robot = Robot.from_spec(RobotSpec.model_validate(robot_file(parts)))
    turned = np.linspace(0, 2.5 * np.pi, 16)[1:]
    screw = [[0.095 - 0.095 * math.cos(a), 0.035 * a / (2 * np.pi), 0.02 + 0.095 * math.sin(a)] for a in turned]
    spec = {"name": "screw", "robot": robot.name, "motion": {"method": method, "step": 0.01, "period_s": 2.0}}
    spec["path"] = {"way_points": [[0, 0, 0], [0, 0, 0.02], *screw], "detour": False}
    task = Task(TaskSpec.model_validate(spec), robot)
    path = desired_path(task)[1]
    feed = arrival(task, path)
    assert 0.7 < feed < 0.8
    tip = method_of(task, path).step(feed)[-1]
    np.testing.assert_allclose(tip, screw[-1], rtol=0, atol=1e-11)
