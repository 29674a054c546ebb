"""Arms of other sections than links on a carrier: plans, files, verdicts, and certificates against dense motions."""

import dataclasses

import numpy as np
import pytest
from planning_makers import assert_same_cells, between, failed, random_scene, variant, with_cell
from scipy.spatial.transform import Rotation, Slerp
from section_makers import mixed_robot

import hognose
from hognose.planning import Plan, retraction, run_checks
from hognose.planning.certificate import certify, interpolated_motion
from hognose.planning.checks.shared import Shared
from hognose.planning.penetration import clearance_of, section_clearance
from hognose.robot.base import axes_of, centre_line, joints_on
from hognose.robot.carrier import Carrier
from hognose.robot.sections import MixedSections
from hognose.robot.sections.chain import vertices_along

BASE = {
    "kind": "arm",
    "direction": [0.0, 0.6, 0.8],
    "workspace": {"low": [-0.2, -0.2, -0.2], "high": [0.2, 0.2, 0.2]},
    "speed": 0.1,
    "turn_speed_deg_s": 60.0,
}
#: 150 mm beyond the entrance, on which the arm of 120 mm is taken in.
WAY = np.array([[0, 0, 0], [0.003, 0.004, 0.045], [-0.006, 0.006, 0.095], [0.004, -0.003, 0.15]])


def turned(points):
    """Into the frame in which the arm enters along `BASE`."""
    return points @ np.array([[1, 0, 0], [0, 0.8, -0.6], [0, 0.6, 0.8]])


def task_of(method, **more):
    beam = {
        "kind": "box",
        "name": "beam",
        "center": turned(np.array([0, -0.02, 0.06])).tolist(),
        "size": [0.08] + [0.01] * 2,
    }
    changes = {"base": BASE, "path": {"way_points": turned(WAY).tolist()}, "obstacle": [beam], "margin": 0.001}
    changes |= {"motion.method": method, "motion.step": 0.002, "motion.period_s": 0.6, "tolerance": {}}
    return variant(hognose.load_task("baffled-tank"), changes | more)


@pytest.fixture(scope="module")
def plan():
    return hognose.plan(task_of("fitted"))


def dense_line(robot, base, angles, at):
    """The centre line (T', q, 3) at angles (T', n, 2) on the way between T poses, and radii of its chords.

    The carrier goes straight, and turns steadily as scipy's Slerp does.
    """
    parts = (len(angles) - 1) // (len(at) - 1)
    assert isinstance(robot.model, MixedSections)
    fine = MixedSections(robot.model.kinds, robot.model.sections, robot.spec.tool_length)
    fine.counts = np.where(fine.table[:, 3] > 0, 24, 1)
    times = np.linspace(0, len(at) - 1, (len(at) - 1) * parts + 1)
    spun = Slerp(np.arange(len(at)), Rotation.from_quat(at[:, 3:], scalar_first=True))(times)
    where = np.column_stack([between(at[:, :3], parts), spun.as_quat(scalar_first=True)])
    joints = joints_on(base, robot, angles, where)
    own = np.ascontiguousarray(base.aligned(joints, where))
    out = np.empty((len(own), int(fine.counts.sum()) + 1, 3))
    vertices_along(fine.angles(own), own, fine.table, fine.counts, fine.first, out)
    radii = np.repeat(robot.body_radii[np.repeat(np.arange(robot.sections), np.diff(fine.first))], fine.counts)
    return base.turned(out, where), radii


def test_three_arcs_are_carried_and_everything_holds(plan):
    robot, base = plan.robot, plan.task.base
    assert plan.good
    assert isinstance(base, Carrier)
    assert plan.base_pose is not None
    assert {check.key for check in plan.checks} >= {
        "base_pose_agrees_with_joints",
        "carrier_workspace",
        "carrier_speed",
        "carrier_turn_speed",
        "certified_interpolated",
        "certified_cables",
        "clearance_of_mount",
    }
    np.testing.assert_allclose(plan.angles[0], 0, atol=1e-12)
    np.testing.assert_allclose(plan.base_pose[0, :3], base.start, atol=1e-12)
    assert plan.path.distance_to(plan.body[:, -1]).max() < 1e-12
    np.testing.assert_allclose(plan.body[-1, -1], turned(WAY)[-1], atol=1e-11)
    # Beside the path, at the arc length that the feed says.
    beside = plan.base_pose[:, :3] - plan.path.point(plan.feed)
    assert np.linalg.norm(beside, axis=1).max() > 1e-5
    np.testing.assert_allclose((beside * plan.path.tangent(plan.feed)).sum(axis=1), 0, atol=1e-12)
    again = robot.angles_from_cables(plan.cable_lengths, 0.9 * plan.angles)
    np.testing.assert_allclose(again, plan.angles, atol=1e-9)


def test_a_carried_plan_is_saved_loaded_checked_and_taken_back(plan, tmp_path):
    plan.save(tmp_path / "plan.parquet")
    loaded = Plan.load(tmp_path / "plan.parquet")
    assert_same_cells(loaded, plan)
    assert not failed(run_checks(loaded))
    back = retraction(plan)
    assert back.good
    np.testing.assert_array_equal(back.base_pose, plan.base_pose[::-1])
    blind = dataclasses.replace(plan, base_pose=None)
    assert "base_pose_agrees_with_joints" in failed(run_checks(blind))
    np.testing.assert_array_equal(blind.at, plan.base_pose)


@pytest.mark.parametrize("cell", [(40, 1), (60, 5)])
def test_a_pose_that_is_another_is_found(plan, cell):
    assert "base_pose_agrees_with_joints" in failed(run_checks(with_cell(plan, "base_pose", cell, 1e-4)))


def test_dense_motions_are_no_closer_than_certified(plan):
    """Between set-points angles go linearly, or cables do."""
    rows, checks = slice(50, None), {check.key: check for check in plan.checks}
    lengths = between(Shared(plan).counted_lengths[rows], 6)
    angles = between(plan.angles[rows], 6)
    ways = {"certified_interpolated": angles, "certified_cables": plan.robot.angles_from_cables(lengths, angles)}
    for key, way in ways.items():
        line, radii = dense_line(plan.robot, plan.task.base, way, plan.base_pose[rows])
        seen = float(clearance_of(plan.scene, line, radii, 1.0).min())
        assert seen - 5e-4 <= checks[key].value <= seen


@pytest.mark.parametrize("seed", range(6))
def test_nothing_comes_closer_than_is_certified_on_a_carrier(seed):
    rng = np.random.default_rng(seed)
    robot = mixed_robot(seed, int(rng.integers(1, 5)))
    base = Carrier(rng.normal(size=3), 1.0, 0.1, 0.02, Rotation.random(rng=rng).as_matrix())
    steps = rng.normal(0, 0.1, (4, robot.sections, 2))
    angles = np.clip(np.cumsum(steps, axis=0), -robot.bend_limits, robot.bend_limits)
    axes = Rotation.from_rotvec(np.cumsum(rng.normal(0, 0.15, (4, 3)), axis=0)) * Rotation.from_matrix(
        base.R_task_start
    )
    at = base.posed(base.start + np.cumsum(rng.normal(0, 0.03, (4, 3)), axis=0), axes.as_matrix())
    np.testing.assert_allclose(axes_of(base, at), axes.as_matrix(), atol=1e-12)
    joints = joints_on(base, robot, angles, at)
    scene = random_scene(rng, joints.min(axis=(0, 1)), joints.max(axis=(0, 1)))
    line = centre_line(base, robot, joints, at)
    proof = certify(
        interpolated_motion(robot, base, at, angles),
        robot,
        scene,
        line,
        section_clearance(scene, robot, line, 1.0),
        1.0,
    )
    dense, radii = dense_line(robot, base, between(angles, 30), at)
    seen = float(clearance_of(scene, dense, radii, 1.0).min())
    assert proof.clearance <= max(seen, 0.0) + 1e-9
    moved = np.linalg.norm(np.diff(dense, axis=0), axis=2).max()
    left_out = float(robot.model.sagitta(robot.link_lengths, robot.bend_limits).max())
    assert proof.clearance <= 0 or proof.clearance >= seen - 2.5e-4 - left_out - 0.6 * moved


def test_a_way_to_a_target_is_searched_and_taken_as_fast_as_the_carrier_can():
    path = {"entrance": [0.0, 0.0, 0.0], "target": turned(WAY)[-1].tolist()}
    task = task_of("fitted", path=path, **{"motion.profile": "fastest", "base.turn_acceleration_deg_s2": 40.0})
    found = hognose.plan(variant(task, {"base.speed": 0.008, "base.acceleration": 0.01}))
    assert found.good
    rates = [check for check in found.checks if check.key.startswith("carrier_") and check.key != "carrier_workspace"]
    assert len(rates) == 4
    assert max(check.value / check.limit for check in rates) > 0.9
