"""Plans of an arm whose sections extend: certified against dense motions, checked, saved, and refused where unknown."""

import dataclasses
import itertools
import json

import numpy as np
import pytest
from extension_oracles import arcs_line, extending, posture
from hypothesis import given, settings
from hypothesis import strategies as st
from plan_file_makers import replaced, rewritten

import hognose
from hognose.errors import InputError
from hognose.files import export
from hognose.files.loading import load_task
from hognose.planning import Plan
from hognose.planning.certificate import interpolated_motion
from hognose.planning.certificate.extending import deviations_of_arcs
from hognose.planning.certificate.moving import Pieces
from hognose.planning.planner import plan_along
from hognose.planning.retraction import retraction
from hognose.robot import Robot, RobotSpec
from hognose.robot.base import Slider
from hognose.robot.own_body import clearance_of_neighbours

seeds = st.integers(0, 2**32 - 1)
PIN = Slider(np.zeros(3), 1.0, 0.0, 0.0)

TASK = """
schema = 1
name = "S through two boards"
units = "mm"
robot = "metabot-3arc"
margin = 0.5
[path]
order = 3
way_points = [[0, 0, 0], [4, 2, 28], [-1, 3, 58], [-5, 1, 84]]
[motion]
method = "fitted"
step = 1.0
period_s = 0.3
[[obstacle]]
kind = "board"
name = "first"
center = [4.0, 2.0, 28.0]
size = [58.0, 58.0]
thickness = 0.5
[[obstacle.hole]]
center = [0.0, 0.0]
diameter = 15.0
[[obstacle]]
kind = "board"
name = "second"
center = [-1.0, 3.0, 58.0]
size = [58.0, 58.0]
thickness = 0.5
[[obstacle.hole]]
center = [0.0, 0.0]
diameter = 15.0
"""


def metabot(with_cables=False, **changes):
    """The bundled arm of 30 mm sections, of which it is known that they extend from 16.5 to 40 mm."""
    said = hognose.load_robot("metabot-3arc").spec.model_dump(by_alias=True, exclude_none=True)
    (section,) = said["section"]
    section |= {"pitch": 0.03, "length_range": (0.0165, 0.04), **changes}
    said["section"] = [section]
    if not with_cables:
        said.pop("cables")
        said["assumed"] = [key for key in said["assumed"] if key != "cables"]
    return Robot.from_spec(RobotSpec.model_validate(said))


@pytest.fixture(scope="module")
def task(tmp_path_factory):
    file = tmp_path_factory.mktemp("extending") / "task.toml"
    file.write_text(TASK)
    return dataclasses.replace(load_task(file), robot=metabot())


@pytest.fixture(scope="module")
def plan(task):
    return plan_along(task)


def between(values, parts):
    """Values (T, ...) and so many more between each two, linearly."""
    share = np.arange(parts).reshape(1, -1, *[1] * (values.ndim - 1)) / parts
    dense = values[:-1, None] * (1 - share) + values[1:, None] * share
    return np.concatenate([dense.reshape(-1, *values.shape[1:]), values[-1:]])


def clearance(plan, angles, lengths, feeds):
    """The smallest clearance (m) of bodies of arcs placed anew, each of many chords, with the slider at feeds (T,)."""
    start, parts = plan.task.base.start, 24
    assert plan.task.base.direction == pytest.approx([0, 0, 1])
    lines = np.stack([start + arcs_line(*each, parts)[0] for each in zip(angles, lengths, strict=True)])
    lines[..., 2] += feeds[:, None]
    found = plan.scene.distance(lines[:, :-1].reshape(-1, 3), lines[:, 1:].reshape(-1, 3)).value
    return float(found.min()) - float(plan.robot.body_radii.max())


def test_a_plan_uses_the_lengths_and_is_good(plan):
    assert plan.good
    lengths, (low, high) = plan.section_lengths, plan.robot.length_bounds.T
    assert np.ptp(lengths) > 3e-4
    assert (lengths > low).all()
    assert (lengths < high).all()
    np.testing.assert_allclose(lengths[0], plan.robot.link_lengths, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(plan.motor_counts[0], 0)
    np.testing.assert_allclose(plan.body, plan.joints, rtol=0, atol=1e-12)
    cables = plan.robot.cable_lengths(plan.angles, lengths)
    np.testing.assert_array_equal(plan.cable_lengths, cables)
    assert np.abs(cables - plan.robot.cable_lengths(plan.angles)).max() > 3e-4
    assert plan.check("section_lengths").ok


def test_the_certificates_are_no_more_than_dense_motions_have(plan):
    """200 places between each two of the steps that are closest, with angles and lengths, or with cables, linear."""
    steps = np.unique(np.clip(np.argsort(plan.clearance.min(axis=1))[:3][:, None] + [-1, 0, 1], 0, len(plan.feed) - 1))
    robot, feeds = plan.robot, plan.feed
    counted = robot.lengths_of_counts(plan.motor_counts)
    for key in ("certified_interpolated", "certified_cables"):
        proof, seen = plan.check(key), np.inf
        assert proof.value > plan.task.margin
        for low, high in itertools.pairwise(steps):
            if high != low + 1:
                continue
            rows = [low, high]
            if key == "certified_interpolated":
                angles, lengths = between(plan.angles[rows], 200), between(plan.section_lengths[rows], 200)
            else:
                cables = between(counted[rows], 200)
                near = between(plan.angles[rows], 200)
                angles, lengths = robot.angles_from_cables(cables, near), robot.lengths_from_cables(cables, near)
            seen = min(seen, clearance(plan, angles, lengths, between(feeds[rows], 200)))
        assert proof.value <= seen + 1e-9
        assert seen - proof.value < 1e-3


@settings(deadline=None, max_examples=40)
@given(seed=seeds, sections=st.integers(1, 5), swing=st.floats(1e-3, 1.0), longer=st.floats(0.0, 1.0))
def test_no_vertex_leaves_its_chord_by_more_than_the_bulge(seed, sections, swing, longer):
    """While angles and lengths go linearly."""
    rng = np.random.default_rng(seed)
    robot = extending(*[None] * sections)
    begin, end = posture(robot, rng), posture(robot, rng)
    angles = np.stack([begin[0], begin[0] + swing * (end[0] - begin[0])])
    lengths = np.stack([begin[1], begin[1] + longer * (end[1] - begin[1])])
    motion = interpolated_motion(robot, PIN, np.zeros((2, 1)), angles, lengths)
    dense, chords = motion.place(between(motion.parameters, 200))[1], int(np.max(robot.model.chords))
    anew = [arcs_line(0.5 * angles.sum(axis=0), 0.5 * lengths.sum(axis=0), chords)[0]]
    np.testing.assert_allclose(dense[100:101], anew, rtol=0, atol=1e-12)
    gone, bulge = motion.travel(Pieces.between(motion.parameters, dense[[0, -1]], np.zeros((2, 0))))
    part = np.linspace(0, 1, len(dense))[:, None, None]
    off = np.linalg.norm(dense - (1 - part) * dense[0] - part * dense[-1], axis=2).max(axis=0)
    assert (off <= bulge[0] + 1e-12).all()
    np.testing.assert_allclose(gone[0], np.linalg.norm(dense[-1] - dense[0], axis=1), atol=1e-15)


def test_the_bulge_of_an_arc_that_gets_longer_as_it_bends_is_not_far_from_what_it_does():
    """Twice the change of length times the angular speed counts: without it the bound would be too small."""
    robot = extending(None, bend_limit_deg=80.0)
    angles, lengths = np.array([[[0.3, 0.0]], [[0.9, 0.0]]]), np.array([[0.06], [0.13]])
    motion = interpolated_motion(robot, PIN, np.zeros((2, 1)), angles, lengths)
    dense = motion.place(between(motion.parameters, 100))[1]
    bulge = motion.travel(Pieces.between(motion.parameters, dense[[0, -1]], np.zeros((2, 0))))[1]
    rest = robot.model.bulges(angles[:1], angles[1:], np.full(1, 0.13), np.zeros((1, 3)), np.zeros(1))
    longest = extending(None, bend_limit_deg=80.0, pitch=0.13, length_range=None).model
    kept = longest.bulges(angles[:1], angles[1:], np.full(1, 0.13), np.zeros((1, 3)), np.zeros(1))
    part = np.linspace(0, 1, len(dense))[:, None, None]
    off = np.linalg.norm(dense - (1 - part) * dense[0] - part * dense[-1], axis=2).max(axis=0)
    assert max(kept[0, -1], rest[0, -1]) < off[-1] <= bulge[0, -1] <= 3 * off[-1]


@settings(deadline=None, max_examples=40)
@given(seed=seeds, disks=st.sampled_from([None, 3, 5, 12]), size=st.floats(1e-3, 1.0))
def test_while_cables_go_linearly_angles_and_lengths_leave_lines_by_no_more_than_is_said(seed, disks, size):
    rng = np.random.default_rng(seed)
    robot = extending(disks, disks)
    begin, end = posture(robot, rng), posture(robot, rng)
    angles, lengths = (np.stack([a, a + size * (b - a)]) for a, b in zip(begin, end, strict=True))
    cables = between(robot.cable_lengths(angles, lengths), 100)
    found, long = (ask(cables, between(angles, 100)) for ask in (robot.angles_from_cables, robot.lengths_from_cables))
    turned, longer = deviations_of_arcs(robot, angles[:1], angles[1:], lengths[:1], lengths[1:])
    assert (np.linalg.norm(found - between(angles, 100), axis=2).max(axis=0) <= turned[0] + 1e-11).all()
    assert (np.abs(long - between(lengths, 100)).max(axis=0) <= longer[0] + 1e-12).all()
    if disks is None:
        assert not turned.any()
        assert not longer.any()


def test_what_is_said_of_cables_through_disks_is_not_far_from_what_they_do():
    """Sections that bend on in their plane, and get longer."""
    robot = extending(3, bend_limit_deg=60.0, body_diameter=0.05)
    angles, lengths = np.array([[[0.5, 0.0]], [[1.0, 0.0]]]), np.array([[0.10], [0.12]])
    cables = between(robot.cable_lengths(angles, lengths), 100)
    found, long = (ask(cables, between(angles, 100)) for ask in (robot.angles_from_cables, robot.lengths_from_cables))
    turned, longer = deviations_of_arcs(robot, angles[:1], angles[1:], lengths[:1], lengths[1:])
    assert turned[0, 0] < 2.5 * np.abs(found - between(angles, 100)).max()
    assert longer[0, 0] < 4 * np.abs(long - between(lengths, 100)).max()


def test_lengths_are_columns_of_files_and_come_back(plan, tmp_path):
    plan.save(tmp_path / "plan.parquet")
    again = Plan.load(tmp_path / "plan.parquet")
    assert again.good
    np.testing.assert_array_equal(again.section_lengths, plan.section_lengths)
    export(plan, tmp_path / "plan.csv")
    head = (tmp_path / "plan.csv").read_text().splitlines()[0]
    assert [f"length_{k:02d}_m" in head for k in range(4)] == [False, True, True, True]
    export(plan, tmp_path / "plan.json")
    columns = json.loads((tmp_path / "plan.json").read_text())["columns"]
    np.testing.assert_array_equal(columns["length_02_m"], plan.section_lengths[:, 1])


def test_a_length_that_joints_do_not_have_is_refused(plan, tmp_path):
    plan.save(tmp_path / "plan.parquet")

    def longer(values):
        values[7] += 0.001
        return values

    file = tmp_path / "altered.parquet"
    file.write_bytes(rewritten(tmp_path / "plan.parquet", replaced("length_02_m", longer)))
    with pytest.raises(InputError, match="column 'length_02_m' is 1 mm off at step 7"):
        Plan.load(file)


def test_other_joints_than_the_method_has_fail(plan):
    """Stretched about the first joint: their lengths are consistent, and too long."""
    joints = plan.joints[:, :1] + 1.5 * (plan.joints - plan.joints[:, :1])
    checks = {check.key: check for check in dataclasses.replace(plan, joints=joints).verified().checks}
    assert checks["section_lengths"].failed
    assert "exceeds 40 mm" in checks["section_lengths"].sentence
    assert checks["joints_agree_with_following"].failed
    assert checks["starts_straight"].failed
    assert "longer or shorter than at rest" in checks["starts_straight"].sentence
    shorter = plan.joints[:, :1] + 0.5 * (plan.joints - plan.joints[:, :1])
    checks = {check.key: check for check in dataclasses.replace(plan, joints=shorter).verified().checks}
    assert checks["section_lengths"].failed
    assert checks["section_lengths"].limit == pytest.approx(0.0165)


def test_by_exact_sections_keep_their_rest(task):
    motion = task.spec.motion.model_copy(update={"method": "exact"})
    resting = dataclasses.replace(task, spec=task.spec.model_copy(update={"motion": motion}))
    fixed = dataclasses.replace(resting, robot=metabot(length_range=None))
    able, still = (plan_along(each) for each in (resting, fixed))
    np.testing.assert_allclose(able.section_lengths, 0.03, rtol=0, atol=1e-10)
    np.testing.assert_array_equal(able.joints, still.joints)
    np.testing.assert_allclose(able.cable_lengths, still.cable_lengths, rtol=0, atol=1e-10)


def test_a_retraction_has_the_same_lengths_backwards(plan):
    back = retraction(plan)
    assert back.good
    np.testing.assert_array_equal(back.section_lengths, plan.section_lengths[::-1])


def test_a_fastest_profile_keeps_the_limits_of_cables_with_lengths(task):
    motion = task.spec.motion.model_copy(update={"profile": "fastest", "period_s": 0.1})
    found = plan_along(dataclasses.replace(task, spec=task.spec.model_copy(update={"motion": motion})))
    assert found.good
    speed = np.abs(np.diff(found.cable_lengths, axis=0)) / np.diff(found.time)[:, None]
    assert speed.max() <= found.robot.spec.limits.cable_speed
    assert np.ptp(found.section_lengths) > 3e-4


def test_where_sections_are_short_what_counts_as_neighbours_keeps_clear():
    """Random pairs of places of bodies at their limits, more than half a turn apart but neighbours when shortest."""
    robot, rng, seen = metabot(), np.random.default_rng(0), np.inf
    kept, (low, high) = clearance_of_neighbours(robot), robot.length_bounds.T
    assert 0.0 < kept < np.inf
    apart = np.pi * robot.body_radii[0]
    for _ in range(150):
        lengths = np.where(rng.random(3) < 0.6, low, rng.uniform(low, high))
        way = rng.uniform(-np.pi, np.pi, 3)
        angles = robot.bend_limits[:, :1] * np.stack([np.sign(np.cos(way)), np.sign(np.sin(way))], axis=1)
        points, _ = arcs_line(angles, lengths, 60)
        arcs = np.concatenate([[0.0], np.cumsum(np.repeat(lengths / 60, 60))])
        short = np.concatenate([[0.0], np.cumsum(np.repeat(low / 60, 60))])
        i, j = np.triu_indices(len(arcs), 1)
        pairs = (arcs[j] - arcs[i] >= apart) & (short[j] - short[i] < apart)
        away = np.linalg.norm(points[j[pairs]] - points[i[pairs]], axis=1)
        seen = min(seen, float(away.min(initial=np.inf)) - 2 * robot.body_radii[0])
    assert kept <= seen < kept + 2e-3
    assert clearance_of_neighbours(metabot(length_range=None)) == np.inf


def test_a_clearance_of_sections_at_their_shortest_is_not_said_of_the_motion(plan):
    check = plan.check("own_body")
    assert check.value == clearance_of_neighbours(plan.robot) < plan.robot.body_radii.min()
    assert "which may where sections are as short and as bent as they can be" in check.detail


def test_of_sections_that_may_bend_too_sharply_where_short_nothing_is_said_of_the_body_itself(plan):
    sharp = metabot(length_range=(0.0085, 0.04))
    assert clearance_of_neighbours(sharp) <= 0.0
    task = dataclasses.replace(plan.task, robot=sharp)
    judged = dataclasses.replace(plan, task=task).verified().check("own_body")
    assert not judged.judged
    assert "sections are short" in judged.sentence


def test_tolerances_are_refused_in_words(task):
    spec = task.spec.model_dump(by_alias=True, exclude_none=True) | {"tolerance": {"calibration_deg": 0.1}}
    with pytest.raises(InputError, match=r"tolerance: what tolerances take is known for straight links"):
        plan_along(dataclasses.replace(task, spec=type(task.spec).model_validate(spec)))
