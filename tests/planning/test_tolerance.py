"""The budget of tolerances: against closed forms, exact kinematics with drawn errors, and dense motions."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from planning_makers import altered, random_robot
from scipy.spatial.transform import Rotation

import hognose
from hognose.errors import InputError
from hognose.planning import drawn_arms, run_checks
from hognose.planning.certificate import bound, cables_motion, certify, interpolated_motion
from hognose.planning.certificate.bound import TIGHTNESS
from hognose.planning.certificate.moving import Moving, Pieces
from hognose.planning.checks.shared import Shared
from hognose.planning.drawn_arms import draw
from hognose.planning.room_for_tolerances import refuse_wide_tolerances, taken_at_least
from hognose.planning.task import TaskSpec
from hognose.planning.tolerance.allowance import Allowance
from hognose.planning.tolerance.budget import COVERAGE, Budget, along_chords
from hognose.planning.tolerance.jacobian import joint_axes
from hognose.planning.tolerance.spec import ToleranceSpec
from hognose.robot import Robot
from hognose.robot.base import Slider, joints_on
from hognose.robot.cable_gains import angles_per_length
from hognose.route.search.bottleneck import crowded
from hognose.scene import Scene, Sphere

SPEC = {
    "cad": 0.001,
    "sag": 0.002,
    "registration": 0.0005,
    "registration_deg": 0.05,
    "calibration_deg": 0.1,
    "cable_zero": 0.0001,
}


def base_of(robot: Robot, seed: int) -> Slider:
    """A slider in any frame."""
    rng = np.random.default_rng(seed)
    return Slider.before(rng.normal(size=3), robot, Rotation.random(rng=rng).as_matrix())


def budget_of(robot: Robot, base: Slider, **said: object) -> Budget:
    """The budget of a tolerance table."""
    found = Budget.of(ToleranceSpec.model_validate(said), robot, base.start)
    assert found is not None
    return found


def pose(seed: int, sections: int = 6) -> tuple[Robot, Slider, np.ndarray, np.ndarray]:
    """A random arm, its base, random angles (1, n, 2) and a feed (1, 1)."""
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, sections)
    return robot, base_of(robot, seed), rng.uniform(-0.4, 0.4, (1, sections, 2)), rng.uniform(0, 0.5, (1, 1))


def test_the_straight_arm_needs_what_the_closed_form_says():
    robot = hognose.load_robot("sjtu-25dof")
    base, n, feed = base_of(robot, 0), robot.sections, 0.3
    at, none = np.array([[feed]]), np.zeros((1, robot.sections, 2))
    joints = joints_on(base, robot, none, at)
    found = Allowance.of(budget_of(robot, base, **SPEC), base, none, at, joints).at_steps(joints)[0]
    end = np.cumsum(robot.link_lengths)
    levers = [end[i] - np.append(0.0, end[:-1])[: i + 1] for i in range(n)]
    shift, turn = 0.0005, np.radians(0.05) * (feed + end)
    bent = np.radians(0.1) * np.array([np.sqrt(np.sum(each**2)) for each in levers])
    zero = 0.0001 * np.sqrt(2.0 / 3.0) / 0.019 * np.sqrt(np.cumsum(robot.link_lengths**2))
    expected = 0.001 + 0.002 * end / end[-1] + 2.0 * np.sqrt(shift**2 + turn**2 + bent**2 + zero**2)
    np.testing.assert_allclose(found, expected, rtol=1e-7)


@pytest.mark.parametrize("seed", range(5))
def test_a_straight_arm_that_is_fed_as_far_as_it_goes_needs_what_is_looked_for(seed):
    robot, base, angles, _ = pose(seed)
    budget, at, none = budget_of(robot, base, **SPEC), np.array([[base.farthest]]), np.zeros_like(angles)
    joints = joints_on(base, robot, none, at)
    found = Allowance.of(budget, base, none, at, joints).at_steps(joints)[0]
    np.testing.assert_allclose(budget.straight(base, np.inf), found, rtol=1e-7)


@pytest.mark.parametrize("seed", range(5))
def test_changes_of_angles_with_lengths_are_those_of_the_angles_that_belong_to_them(seed):
    robot, _, angles, _ = pose(seed)
    lengths, gains = robot.cable_lengths(angles), angles_per_length(robot, angles)[0]
    for cable in range(robot.cables):
        off = np.zeros(robot.cables)
        off[cable] = 1e-6
        more, less = (robot.angles_from_cables(lengths + sign * off, angles)[0] for sign in (1, -1))
        np.testing.assert_allclose((more - less) / 2e-6, gains[..., cable], atol=1e-3 * (1 + np.abs(gains).max()))


def by_angles(joints: np.ndarray, axes: np.ndarray, point: np.ndarray, link: int) -> np.ndarray:
    """How a point (3,) m on a link moves with all angles, (3, n, 2) m/rad; joints behind the link do not move it."""
    before = np.arange(len(axes)) <= link
    moved = np.cross(axes, (point - joints[:-1])[:, None]) * before[:, None, None]
    return np.moveaxis(moved, 2, 0)


@pytest.mark.parametrize("seed", range(5))
def test_points_move_with_angles_as_in_the_kinematics(seed):
    robot, base, angles, at = pose(seed)
    joints, axes = joints_on(base, robot, angles, at), joint_axes(base, angles, at)
    for link in range(robot.sections):
        found = by_angles(joints[0], axes[0], joints[0, link + 1], link)
        for j, k in np.ndindex(robot.sections, 2):
            off = np.zeros_like(angles)
            off[0, j, k] = 1e-6
            more, less = (joints_on(base, robot, angles + sign * off, at)[0, link + 1] for sign in (1, -1))
            np.testing.assert_allclose((more - less) / 2e-6, found[:, j, k], atol=1e-8)


def drawn(robot: Robot, base: Slider, angles: np.ndarray, at: np.ndarray, count: int, seed: int) -> np.ndarray:
    """Joints (count, n+1, 3) of an arm with drawn errors of all random kinds, by the exact kinematics."""
    rng = np.random.default_rng(seed)
    many, where = np.repeat(angles, count, axis=0), np.repeat(at, count, axis=0)
    lengths = np.repeat(robot.cable_lengths(angles), count, axis=0)
    lengths = lengths + rng.normal(0, SPEC["cable_zero"], lengths.shape)
    many = robot.angles_from_cables(lengths, many) + rng.normal(0, np.radians(SPEC["calibration_deg"]), many.shape)
    joints = joints_on(base, robot, many, where) - base.start
    turned = Rotation.from_rotvec(rng.normal(0, np.radians(SPEC["registration_deg"]), (count, 3))).as_matrix()
    shifts = rng.normal(0, SPEC["registration"], (count, 1, 3))
    return np.einsum("kab,kjb->kja", turned, joints) + shifts + base.start


@pytest.mark.parametrize("seed", range(6))
def test_drawn_arms_spread_no_more_than_the_budget_says_and_not_much_less(seed):
    robot, base, angles, at = pose(seed)
    if seed % 2:
        angles[..., 1] = 0.0  # in a plane, across which the spread is what the budget says
    budget = budget_of(robot, base, **{key: value for key, value in SPEC.items() if key not in ("cad", "sag")})
    joints = joints_on(base, robot, angles, at)
    taken = Allowance.of(budget, base, angles, at, joints).at_steps(joints)[0]
    points = drawn(robot, base, angles, at, 20_000, seed)
    off = points - joints
    spread = np.sqrt([np.linalg.eigvalsh(np.cov(off[:, i].T))[-1] for i in range(1, robot.sections + 1)])
    assert (COVERAGE * spread <= 1.03 * taken).all()
    assert (COVERAGE * spread >= (0.97 if seed % 2 else 0.8) * taken)[1:].all()


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("size", [0.01, 0.1, 0.4])
def test_between_the_steps_no_pose_needs_more_than_is_taken(seed, size):
    robot, base, low, at = pose(seed)
    rng = np.random.default_rng(seed)
    angles = np.concatenate([low, low + rng.uniform(-size, size, low.shape)])
    places = np.concatenate([at, at + 0.1 * size])
    share = np.linspace(0, 1, 41)
    dense_at = at + share[:, None] * np.diff(places, axis=0)
    linear = angles[0] + share[:, None, None] * (angles[1] - angles[0])
    budget = budget_of(robot, base, **{**SPEC, "cable_zero": SPEC["cable_zero"] * (seed % 2)})
    line = joints_on(base, robot, angles, places)
    allowance = Allowance.of(budget, base, angles, places, line)
    moving = interpolated_motion(robot, base, places, angles)
    pieces = Pieces.between(moving.parameters, line, np.zeros((2, robot.sections)))
    motion, bulge = moving.travel(pieces)
    first = robot.cable_lengths(angles)[0]
    lengths = first + share[:, None] * (robot.cable_lengths(angles)[1] - first)
    by_cables = robot.angles_from_cables(lengths, linear)
    off = np.linalg.norm(joints_on(base, robot, by_cables, dense_at) - joints_on(base, robot, linear, dense_at), axis=2)
    for dense, more in ((linear, 0.0), (by_cables, off.max(axis=0))):
        joints = joints_on(base, robot, dense, dense_at)
        needed = Allowance.of(budget, base, dense, dense_at, joints).at_steps(joints).max(axis=0)
        for way in (None, motion):
            taken = allowance.between(pieces.low_body, pieces.high_body, pieces.step, way, bulge + more)[0]
            assert (needed <= taken + 1e-12).all()


def linear(values: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Values at shares (k,) of the way from the first of two to the second."""
    return values[0] + share.reshape(-1, *[1] * (values.ndim - 1)) * (values[1] - values[0])


def cables_between(seed: int, size: float) -> tuple[Robot, Slider, np.ndarray, np.ndarray, Moving]:
    """A random arm, its base and their coordinates (2, 1), angles (2, n, 2) and the motion of cables between these."""
    robot, base, low, at = pose(seed, sections=1 + seed % 8)
    rng = np.random.default_rng(seed)
    angles = np.concatenate([low, low + rng.uniform(-size, size, low.shape)])
    places = np.concatenate([at, at + 0.2 * size])
    return robot, base, places, angles, cables_motion(robot, base, places, angles, robot.cable_lengths(angles))


@pytest.mark.parametrize("seed", range(25))
@pytest.mark.parametrize("size", [0.003, 0.03, 0.1, 0.3])
def test_cables_that_are_off_displace_joints_between_the_steps_along_lines_but_for_the_bulges(seed, size):
    robot, base, places, angles, moving = cables_between(seed, size)
    joints, rng, share = joints_on(base, robot, angles, places), np.random.default_rng(seed), np.linspace(0, 1, 33)
    bulge = moving.travel(Pieces.between(moving.parameters, joints, np.zeros((2, 0))))[1]
    if bulge.max() > 1e3:  # nothing is certified
        return
    budget = budget_of(robot, base, cable_zero=2e-4)
    allowance = Allowance.of(budget, base, angles, places, joints).with_bulge(bulge)
    away = 2.0 * allowance.bulge[0] + allowance.growth[0]
    lengths = linear(robot.cable_lengths(angles), share)
    near, where = linear(angles, share), linear(places, share)
    planned = joints_on(base, robot, robot.angles_from_cables(lengths, near), where)
    for _ in range(8):
        off = rng.normal(size=robot.cables)
        off *= COVERAGE * budget.zero / np.linalg.norm(off)
        displaced = joints_on(base, robot, robot.angles_from_cables(lengths + off, near), where) - planned
        line = displaced[0] + share[:, None, None] * (displaced[-1] - displaced[0])
        assert (np.linalg.norm(displaced - line, axis=2) <= away + 1e-12).all()


@pytest.mark.parametrize("seed", range(25))
@pytest.mark.parametrize("size", [0.003, 0.03, 0.1, 0.3])
def test_nowhere_between_coarse_steps_the_zeros_of_cables_need_more_than_is_taken(seed, size):
    robot, base, places, angles, moving = cables_between(seed, size)
    joints, share = joints_on(base, robot, angles, places), np.linspace(0, 1, 65)
    bulge = moving.travel(Pieces.between(moving.parameters, joints, np.zeros((2, 0))))[1]
    budget = budget_of(robot, base, cable_zero=2e-4)
    allowance = Allowance.of(budget, base, angles, places, joints)
    near, where = linear(angles, share), linear(places, share)
    by_cables = robot.angles_from_cables(linear(robot.cable_lengths(angles), share), near)
    for dense, taken in ((near, allowance), (by_cables, allowance.with_bulge(bulge))):
        dense_joints = joints_on(base, robot, dense, where)
        needed = Allowance.of(budget, base, dense, where, dense_joints).zeros.max(axis=0)
        assert (needed <= taken.zeros_between[0] + 1e-12).all()


@pytest.mark.parametrize("seed", range(10))
def test_certified_clearance_is_kept_by_dense_poses_and_more_tolerance_never_raises_it(seed):
    robot, base, low, at = pose(seed)
    rng = np.random.default_rng(seed)
    angles = np.cumsum(np.concatenate([low, rng.uniform(-0.1, 0.1, (4, *low.shape[1:]))]), axis=0)
    places = at + np.linspace(0.0, 0.04, 5)[:, None]
    line = joints_on(base, robot, angles, places)
    ball = Sphere(center=tuple(line[2, 4] + rng.normal(size=3) * 0.05), diameter=0.01)
    scene = Scene.from_obstacles([ball], tolerance=1e-4)
    horizon, before = 1.0, np.inf

    def clear(joints: np.ndarray) -> np.ndarray:
        return scene.clearance(joints[:, :-1], joints[:, 1:], robot.body_radii, horizon).value

    for times in (0.0, 0.5, 1.0, 2.0):
        spec = {key: times * value for key, value in SPEC.items()}
        budget = Budget.of(ToleranceSpec.model_validate(spec), robot, base.start)
        allowance = None if budget is None else Allowance.of(budget, base, angles, places, line)
        moving = interpolated_motion(robot, base, places, angles)
        proof = certify(moving, robot, scene, line, clear(line), horizon, np.inf, allowance)
        dense = np.linspace(0, 4, 401)
        steps = np.minimum(dense.astype(int), 3)
        part = (dense - steps)[:, None]
        between = angles[steps] + part[..., None] * (angles[steps + 1] - angles[steps])
        where = places[steps] + part * (places[steps + 1] - places[steps])
        joints = joints_on(base, robot, between, where)
        left = clear(joints)
        if budget is not None:
            left = left - Allowance.of(budget, base, between, where, joints).at_steps(joints)
        assert proof.clearance <= max(left.min(), 0.0) + 1e-12
        assert proof.clearance <= max(before, 0.0) + TIGHTNESS
        before = proof.clearance


def test_what_all_points_need_is_taken_off_the_bound_itself(monkeypatch):
    monkeypatch.setattr(bound, "MOST_HALVINGS", 0)
    robot, base, low, at = pose(1)
    angles, places = np.concatenate([low, low + 0.2]), np.concatenate([at, at + 0.01])
    line = joints_on(base, robot, angles, places)
    scene, clear = Scene.from_obstacles([]), np.full((2, robot.sections), 0.5)
    allowance = Allowance.of(budget_of(robot, base, cad=0.003), base, angles, places, line)
    moving = interpolated_motion(robot, base, places, angles)
    plain, less = (certify(moving, robot, scene, line, clear, 1.0, np.inf, each) for each in (None, allowance))
    assert plain.clearance < 0.49
    assert less.clearance == pytest.approx(plain.clearance - 0.003, abs=1e-12)


def test_without_tolerances_there_is_no_budget_and_the_robot_is_the_same():
    task = hognose.load_task("obstacle-array")
    assert task.budget is None
    assert (task.clearances_wanted == task.margin).all()
    zero = altered(task.robot.spec, {"tolerance": {"calibration_deg": 0.0}})
    assert Robot.from_spec(zero).fingerprint == task.robot.fingerprint
    other = altered(task.robot.spec, {"tolerance": {"calibration_deg": 0.1}})
    assert Robot.from_spec(other).fingerprint != task.robot.fingerprint


def test_the_spread_of_points_between_the_ends_of_a_link_is_smaller():
    robot, base, angles, at = pose(3)
    joints = joints_on(base, robot, angles, at)
    budget = budget_of(robot, base, registration_deg=0.1)
    middles = 0.5 * (joints[:, 1:] + joints[:, :-1])
    spread = budget.turn * np.linalg.norm(middles - base.start, axis=2)
    assert (spread < along_chords(budget.turned(joints))).all()


def test_the_task_overrides_the_robot_and_says_what_is_assumed():
    robot = hognose.load_robot("sjtu-25dof")
    given = {"tolerance": {"calibration_deg": 0.2, "sag": 0.003}, "assumed": ["tolerance.sag"]}
    own = Robot.from_spec(altered(robot.spec, given))
    start = np.zeros(3)
    of_robot = Budget.of(ToleranceSpec(), own, start)
    of_task = Budget.of(ToleranceSpec(calibration_deg=0.1, cad=0.001, assumed=("cad",)), own, start)
    assert of_robot is not None
    assert of_task is not None
    assert of_robot.given == ("sag", "calibration_deg")
    assert of_robot.assumed == {"sag"}
    assert of_task.assumed == {"sag", "cad"}
    np.testing.assert_allclose(of_task.joints, np.radians(0.1))
    np.testing.assert_allclose(of_robot.joints, np.radians(0.2))


def test_values_for_another_number_of_sections_are_refused():
    robot = hognose.load_robot("sjtu-25dof")
    with pytest.raises(InputError, match=r"tolerance\.calibration_deg: 2 values, but the arm has 12 sections"):
        Budget.of(ToleranceSpec(calibration_deg=(0.1, 0.2)), robot, np.zeros(3))
    with pytest.raises(ValueError, match=r"tolerance\.sag: 1 values, but the arm has 12 sections"):
        altered(robot.spec, {"tolerance": {"sag": [0.001]}})


def test_a_tolerance_larger_than_the_gap_is_said_before_anything_is_planned():
    task = hognose.load_task("obstacle-array")
    spec = altered(task.spec, {"tolerance": {"cad": 0.5}})
    with pytest.raises(hognose.InfeasibleError, match=r"tolerance: .* but tolerances take 500\.00 mm") as caught:
        hognose.plan(hognose.Task(spec, task.robot))
    assert "lower the margin" in str(caught.value)


def near_a_ball(at: str, apart: float) -> hognose.Task:
    """A task with a target and a ball so far (m) beside the body there; the base was measured at the entrance."""
    place = {"entrance": 0.0, "target": 0.6}[at]
    radius = 0.0225  # of the body
    ball = {"kind": "sphere", "name": "ball", "diameter": 0.1, "center": [0.0, 0.05 + radius + apart, place]}
    path = {"entrance": [0, 0, 0], "target": [0, 0, 0.6]}
    tolerance = {"registration_deg": 0.5, "registration_at": [0, 0, 0]}
    spec = hognose.load_task("obstacle-array").spec.model_dump(mode="json", by_alias=True)
    spec |= {"path": path, "tolerance": tolerance, "obstacle": [ball], "margin": 0.005}
    return hognose.Task(TaskSpec.model_validate(spec), hognose.load_robot("sjtu-25dof"))


def test_a_search_begins_unless_tolerances_surely_do_not_fit_where_the_arm_must_pass():
    """Less room than the straight arm takes, fed as far as it goes, is not too little where little is taken."""
    fits, tight = near_a_ball("entrance", 0.015), near_a_ball("target", 0.015)
    assert fits.clearance_wanted > 0.02
    np.testing.assert_allclose(taken_at_least(fits)[1], 2.0 * np.radians(0.5) * 0.6)
    assert crowded(fits) is None
    refuse_wide_tolerances(fits)
    with pytest.raises(hognose.InfeasibleError, match=r"'ball' .* but tolerances take 10\.47 mm"):
        refuse_wide_tolerances(tight)
    found = crowded(tight)
    assert found is not None
    assert found.proven
    assert "5 mm margin and 10.5 mm tolerances" in found.sentences[0]


@pytest.fixture(scope="module")
def budgeted():
    """A plan with tolerances, of few steps."""
    task = hognose.load_task("tolerances")
    motion = {"motion.step": 0.02, "motion.period_s": 1.0}
    return hognose.plan(hognose.Task(altered(task.spec, motion), task.robot))


def test_drawn_clearances_are_those_of_the_exact_kinematics(budgeted):
    task, count = budgeted.task, 400
    found = draw(budgeted, task.budget, Shared(budgeted).taken, 20_000, seed=1)
    rng = np.random.default_rng(2)
    spec, robot = task.spec.tolerance, task.robot
    steps, exact = len(budgeted.time), np.empty(count)
    for k in range(count):
        lengths = budgeted.cable_lengths + rng.normal(0, spec.cable_zero, robot.cables)
        angles = robot.angles_from_cables(lengths, budgeted.angles)
        angles = angles + rng.normal(0, np.radians(spec.calibration_deg), angles.shape[1:])
        turned = Rotation.from_rotvec(rng.normal(0, np.radians(spec.registration_deg), 3)).as_matrix()
        joints = joints_on(task.base, robot, angles, budgeted.at) @ turned.T + rng.normal(0, spec.registration, 3)
        left = task.scene.clearance(joints[:, :-1], joints[:, 1:], robot.body_radii, 1.0).value
        exact[k] = (left - task.budget.bounded).min()
    assert steps > 40
    for share in (0.05, 0.25, 0.5, 0.75):
        assert abs(found.quantile(share) - np.quantile(exact, share)) < 5e-4


def test_the_same_seed_draws_the_same_arms_and_more_tolerance_loses_the_margin_more_often(budgeted):
    task, lost = budgeted.task, []
    for times in (1.0, 2.0, 4.0):
        spec = altered(task.spec, {"tolerance.calibration_deg": 0.1 * times})
        more = hognose.Task(spec, task.robot).budget
        assert more is not None
        one, other = (draw(budgeted, more, times * Shared(budgeted).taken, seed=3) for _ in range(2))
        np.testing.assert_array_equal(one.clearance, other.clearance)
        lost.append(one.loses)
    assert 0.0 <= lost[0] < lost[1] < lost[2]


def test_checks_are_of_what_tolerances_leave(budgeted):
    at_steps, taken = budgeted.check("clearance_at_steps"), Shared(budgeted).taken
    left = budgeted.clearance - taken
    assert at_steps.value == left.min()
    assert "calibration 0.1° (assumed) is" in at_steps.detail
    assert budgeted.certified_clearance <= at_steps.value
    spec = altered(budgeted.task.spec, {"margin": float(left.min()) + 1e-4})
    closer = run_checks(dataclasses.replace(budgeted, task=hognose.Task(spec, budgeted.robot)))
    assert "clearance_at_steps" in {check.key for check in closer if check.failed}


def test_a_plan_file_keeps_the_tolerances(budgeted, tmp_path):
    budgeted.save(tmp_path / "plan.parquet")
    again = hognose.Plan.load(tmp_path / "plan.parquet")
    assert again.good
    assert again.task.spec.tolerance == budgeted.task.spec.tolerance
    assert again.certified_clearance == budgeted.certified_clearance


def test_the_mount_needs_what_the_base_does(budgeted):
    budget = budgeted.task.budget
    starts = np.array([[0.0, 0.0, -1.0]])
    expected = 0.001 + 2.0 * np.hypot(0.0003, np.radians(0.02) * 1.0)
    np.testing.assert_allclose(budget.of_base(starts), expected, rtol=1e-12)
    np.testing.assert_allclose(budget.of_base(0.5 * starts, 0.5), expected, rtol=1e-12)


@pytest.mark.parametrize("rank", [1, 3, 8])
def test_fewer_errors_change_clearances_alike(rank):
    rng = np.random.default_rng(rank)
    gradient = rng.normal(size=(40, rank)) @ rng.normal(size=(rank, 30))
    few = drawn_arms._of_few(gradient)
    assert few.shape == (40, rank)
    np.testing.assert_allclose(few @ few.T, gradient @ gradient.T, atol=1e-9)
