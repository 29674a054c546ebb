"""What is exported of arms whose sections extend: in other programs it is where Hognose has it, at any length."""

import dataclasses
import re

import numpy as np
import pytest
from model_makers import SPRINGS, Mujoco, Urdf, mj
from robot_oracles import random_angles, robot_of
from section_makers import dense_line, mixed, of_kind
from test_export_drives import bag_of, tables_of
from test_exports_of_other_sections import off_the_line
from test_extending_plans import TASK, metabot

from hognose.files.exports import export
from hognose.files.exports.arc_joints import cable_error, errors_of
from hognose.files.exports.jointed_arm import WITHIN, JointedArm
from hognose.files.exports.mjcf_cables import GIVES
from hognose.files.exports.ros2 import ARM, MOTORS
from hognose.files.loading import load_task
from hognose.planning.planner import plan_along
from hognose.robot import Robot, RobotSpec

EXACT, FEED, PARTS = 1e-12, 0.02, 120
MIXED = robot_of(
    [
        of_kind("link", passing_cable_radius=0.015),
        of_kind("arc", length_range=(0.06, 0.12)),
        of_kind("arc", disks=5),
        of_kind("arc", disks=6, length_range=(0.08, 0.13)),
        of_kind("link", centre_of_mass=0.03),
    ],
    cables=SPRINGS,
    tool_length=0.02,
    tool_mass=0.03,
)
ARMS = {"metabot": metabot(with_cables=True), "mixed": MIXED}
#: How the sections of both are led: disks, or None, of those that extend.
DISKS = {"metabot": {0: 10, 1: 10, 2: 10}, "mixed": {1: None, 3: 6}}


@pytest.fixture(params=list(ARMS), scope="module")
def name(request):
    return request.param


@pytest.fixture
def robot(name):
    return ARMS[name]


@pytest.fixture(scope="module")
def models(name, tmp_path_factory):
    folder = tmp_path_factory.mktemp("models")
    export(ARMS[name], folder / "model.xml")
    export(ARMS[name], folder / "model.urdf")
    return Mujoco((folder / "model.xml").read_bytes()), Urdf(folder / "model.urdf")


def stiff():
    """The small arm without rods, which spring back as at rest in a model, and with stiffer cables."""
    said = ARMS["metabot"].spec.model_dump(by_alias=True, exclude_none=True)
    said["section"][0].pop("bending_stiffness_N_m2")
    said["assumed"] = [key for key in said["assumed"] if key != "section.bending_stiffness_N_m2"]
    said["cables"] |= {"axial_stiffness_N": 30e3, "pretension_N": 50.0}
    return Robot.from_spec(RobotSpec.model_validate(said))


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    file = tmp_path_factory.mktemp("extending") / "task.toml"
    file.write_text(TASK)
    return plan_along(dataclasses.replace(load_task(file), robot=stiff()))


@pytest.fixture(scope="module")
def keyframes(plan, tmp_path_factory):
    file = tmp_path_factory.mktemp("extending") / "plan.xml"
    export(plan, file)
    return Mujoco(file.read_bytes())


def postures(robot):
    """Angles (n, 2) and lengths (n,) at rest, at random, and at limits."""
    rng, (low, high) = np.random.default_rng(5), robot.length_bounds.T
    yield np.zeros((robot.sections, 2)), robot.link_lengths
    yield np.zeros((robot.sections, 2)), rng.uniform(low, high)
    for _ in range(3):
        yield random_angles(robot, rng), rng.uniform(low, high)
    for lengths in (low, high, np.where(rng.random(robot.sections) < 0.5, low, high)):
        yield np.sign(rng.normal(size=(robot.sections, 2))) * robot.bend_limits, lengths


def as_long(robot, lengths):
    """The same arm with sections that are always as long."""
    said = robot.spec.model_dump(by_alias=True, exclude_none=True)
    groups = [dict(group) for group in said["section"] for _ in range(group["count"])]
    for group, length in zip(groups, lengths, strict=True):
        if group.pop("length_range", None):
            group |= {"pitch": float(length)}
        group["count"] = 1
        group.pop("cable_azimuth_step_deg", None)
    said["section"] = groups
    return Robot.from_spec(RobotSpec.model_validate(said))


def set_mujoco(model, robot, angles, lengths):
    """Set every joint by its name and its range: that of a slide is its share of the section's."""
    names = [model.model.joint(j).name for j in range(model.model.njnt)]
    kinds = [name.rsplit("_", 1)[0] if name.count("_") == 2 else name for name in names]
    for name, kind in zip(names, kinds, strict=True):
        joint = model.model.joint(name)
        if name == "feed":
            value = FEED
        else:
            axis, number = kind.split("_")
            section = int(number) - 1
            if axis == "length":
                rest, (low, high) = robot.link_lengths[section], robot.length_bounds[section]
                value = (joint.range[1] - joint.range[0]) * (lengths[section] - rest) / (high - low)
            else:
                value = angles[section, int(axis == "beta")] / kinds.count(kind)
        model.data.qpos[joint.qposadr[0]] = value
    mj.mj_forward(model.model, model.data)


def disks_of_mujoco(model, section):
    """Where (d, 3) m the bodies are that nothing but a slide of a section (0-based) moves."""
    model, data = model.model, model.data
    slides = [j for j in range(model.njnt) if model.joint(j).name.startswith(f"length_{section + 1:02d}")]
    return np.array([data.xpos[b] for b in model.jnt_bodyid[slides] if model.body_jntnum[b] == 1])


def test_disks_tip_and_cables_are_where_hognose_has_them_at_any_length(name, robot, models):
    arm, (model, urdf) = JointedArm.of(robot), models
    slides = [joint for joint in urdf.model.actuated_joint_names if joint.startswith("length_")]
    assert [joint[:9] for joint in slides] == [f"length_{i + 1:02d}" for i in DISKS[name]]
    assert len(urdf.model.actuated_joint_names) == 1 + 2 * robot.sections + len(slides)
    for angles, lengths in postures(robot):
        set_mujoco(model, robot, angles, lengths)
        assert np.abs(model.data.efc_pos[: model.model.neq]).max() < EXACT
        tip = model.data.body("tip")
        assert np.linalg.norm(tip.xpos - robot.joint_positions(angles, FEED, lengths)[-1]) <= arm.off + EXACT
        fixed = as_long(robot, lengths)
        line, ends, _ = dense_line(fixed, angles, PARTS)
        for section, disks in DISKS[name].items():
            places = disks_of_mujoco(model, section) - [0.0, 0.0, FEED]
            assert len(places) == (arm.counts[section] if disks is None else disks)
            at = ends[section] + PARTS * np.arange(1, len(places) + 1) / len(places)
            wanted = np.stack([np.interp(at, np.arange(len(line)), line[:, i]) for i in range(3)], axis=1)
            assert np.linalg.norm(places - wanted, axis=1).max() <= arm.off + 1e-6
        bodies = [model.data.xpos[b] for b in range(2, model.model.nbody)] - np.array([0.0, 0.0, FEED])
        assert off_the_line(bodies, line).max() <= arm.off + 1e-6
        cables = model.data.ten_length[: robot.cables]
        assert np.abs(cables - robot.cable_lengths(angles, lengths)).max() <= arm.cables_off + EXACT
        urdf.model.update_cfg({j: float(model.data.joint(j).qpos[0]) for j in urdf.model.actuated_joint_names})
        at = urdf.model.get_transform("tip", "task")
        np.testing.assert_allclose(at[:3, 3], tip.xpos, rtol=0, atol=1e-11)
        np.testing.assert_allclose(at[:3, :3], tip.xmat.reshape(3, 3), rtol=0, atol=1e-11)


def test_how_far_chains_are_off_holds_at_any_length_and_is_said(robot, tmp_path):
    arm, rng = JointedArm.of(robot), np.random.default_rng(8)
    angles, (low, high) = random_angles(robot, rng, (300,)), robot.length_bounds.T
    angles[200:] = np.sign(angles[200:]) * robot.bend_limits
    lengths = rng.uniform(low, high, (300, robot.sections))
    tips = robot.joint_positions(angles, np.zeros(300), lengths)[:, -1]
    off = np.linalg.norm(arm.frames(angles, lengths)[0][:, -1] - tips, axis=1)
    assert off.max() <= arm.off <= WITHIN * robot.length
    off = np.abs(arm.cable_lengths(angles, lengths) - robot.cable_lengths(angles, lengths))
    assert 0.25 * arm.cables_off <= off.max() <= arm.cables_off
    for file in ("model.xml", "model.urdf"):
        said = " ".join(export(robot, tmp_path / file).remarks)
        assert "sections that extend have slides between their joints" in said
        assert "at any bends and lengths within the limits no point of the arm's line is off by more than" in said
        written = re.sub(r"\s+", " ", (tmp_path / file).read_text())
        assert f"is off by more than {1e3 * arm.off:.2g} mm" in written


@pytest.mark.parametrize("disks", [None, 4, 12])
def test_what_is_said_of_a_cable_is_what_it_is_off_at_the_worst_length(disks):
    """Of one section, at many angles and lengths; the longest one is off the most."""
    robot = robot_of([of_kind("arc", disks=disks, length_range=(0.055, 0.16), bend_limit_deg=70.0)])
    arm, section, axis = JointedArm.of(robot), mixed(robot).sections[0], np.linspace(-1.0, 1.0, 21)
    assert arm.off == pytest.approx(errors_of(0.16, section.bend_limits, arm.counts[0])[0], rel=1e-12)
    own = cable_error(section, arm.counts[0], robot.cable_radii, robot.cable_azimuths)
    grid = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 1, 2) * robot.bend_limits
    worst = []
    for length in np.linspace(0.055, 0.16, 12):
        lengths = np.full((len(grid), 1), length)
        off = np.abs(arm.cable_lengths(grid, lengths) - robot.cable_lengths(grid, lengths)).max(axis=0)
        assert (off <= 1.02 * own).all()
        worst.append(off)
    assert (np.max(worst, axis=0) >= 0.98 * own).all()


def test_sections_weigh_what_the_robot_file_says_and_masses_go_with_the_lengths(robot, models):
    model, urdf = models[0].model, models[1].model
    total = robot.link_masses.sum() + robot.tool_mass
    inner = [b for b in range(model.nbody) if model.body(b).name.startswith(("link_", "tip"))]
    assert model.body_mass[inner].sum() == pytest.approx(total, rel=1e-9)
    links = [link.inertial.mass for name, link in urdf.link_map.items() if name != "mount" and link.inertial]
    assert sum(links) == pytest.approx(total, rel=1e-9)
    assert min(links) > 0.0
    for angles, lengths in list(postures(robot))[:2]:
        set_mujoco(models[0], robot, angles, lengths)
        begins = np.append(0.0, np.cumsum(lengths[:-1]))
        own = np.where(robot.extending, 0.5 * lengths, robot.centres_of_mass)
        moment = robot.link_masses @ (begins + own) + robot.tool_mass * lengths.sum()
        centre = model.body_mass[inner] @ models[0].data.xipos[inner, 2] / total - FEED
        assert centre == pytest.approx(moment / total, rel=1e-5)


def test_the_mass_of_a_section_may_be_in_one_place_of_it():
    robot = robot_of([of_kind("arc", disks=5, length_range=(0.06, 0.12), centre_of_mass=0.091)])
    arm = JointedArm.of(robot)
    assert sum(part.mass for part in arm.parts) == pytest.approx(robot.link_masses[0], rel=1e-4)
    assert arm.parts[-2].mass > 0.99 * robot.link_masses[0]


def test_slides_follow_the_first_within_limits_and_add_up(name, robot, models):
    model, urdf = models[0].model, models[1].model
    arm, sliding = JointedArm.of(robot), {}
    assert model.neq == sum(joint.mimic is not None for joint in urdf.joint_map.values()) == len(arm.following)
    for joint in arm.joints:
        if joint.slides:
            longer = robot.length_bounds[joint.section] - robot.link_lengths[joint.section]
            sliding.setdefault(joint.section, []).append(joint.share)
            assert model.joint(joint.name).range.tolist() == pytest.approx((joint.share * longer).tolist())
            limit = urdf.joint_map[joint.name].limit
            assert [limit.lower, limit.upper] == pytest.approx((joint.share * longer).tolist())
            assert limit.velocity == pytest.approx(joint.share * robot.spec.limits.cable_speed)
            assert urdf.joint_map[joint.name].type == "prismatic"
    assert list(sliding) == list(DISKS[name])
    for section, shares in sliding.items():
        parts = DISKS[name][section] or arm.counts[section]
        assert sum(shares) == pytest.approx(1.0, rel=1e-12)
        assert len(shares) == arm.counts[section] + parts


def test_derivatives_by_lengths_are_those_of_the_values(robot):
    arm, (angles, lengths) = JointedArm.of(robot), list(postures(robot))[3]
    values = arm.values(angles[None], lengths[None])[0]
    longer = (lengths - robot.link_lengths) * robot.extending
    np.testing.assert_allclose(arm.shares @ angles.ravel() + arm.length_shares @ longer, values, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(arm.values(angles[None])[0], arm.values(angles[None], robot.link_lengths[None])[0])
    np.testing.assert_array_equal(arm.frames(angles[None])[0], arm.frames(angles[None], robot.link_lengths[None])[0])


def test_every_step_of_a_plan_is_a_keyframe(plan, keyframes):
    arm, (model, data) = JointedArm.of(plan.robot), (keyframes.model, keyframes.data)
    lengths = plan.section_lengths
    assert model.nkey == len(plan.time)
    assert np.ptp(lengths) > 3e-4
    for step in range(0, len(plan.time), 12):
        mj.mj_resetDataKeyframe(model, data, step)
        mj.mj_forward(model, data)
        assert np.linalg.norm(data.body("tip").xpos - plan.joints[step, -1]) <= arm.off
        assert np.abs(data.ten_length[: plan.robot.cables] - plan.cable_lengths[step]).max() <= arm.cables_off
        longer = lengths[step] - plan.robot.link_lengths
        np.testing.assert_allclose(data.ten_length[plan.robot.cables :], longer, rtol=0, atol=EXACT)
        np.testing.assert_allclose(data.ctrl[-3:], longer, rtol=0, atol=EXACT)
        assert np.abs(data.efc_pos[: model.neq]).max() < EXACT
        np.testing.assert_allclose(data.actuator_force[1 : 1 + plan.robot.cables], -plan.held.tensions[step], rtol=1e-6)


def test_drives_hold_the_lengths_against_the_cables(plan, keyframes):
    """Nine cables pull with about 50 N each, and gravity is on: after a second the arm is where it was, and at rest."""
    (model, data), cables, small = (keyframes.model, keyframes.data), plan.robot.cables, 1e-6
    for step in (0, len(plan.time) // 2, len(plan.time) - 1):
        mj.mj_resetDataKeyframe(model, data, step)
        mj.mj_step(model, data, 500)
        assert np.linalg.norm(data.body("tip").xpos - plan.joints[step, -1]) < 0.2e-3
        off = np.abs(data.ten_length[cables:] - data.ctrl[-3:])
        assert off.max() < 0.55 * GIVES * 0.03
        assert np.abs(data.qvel).max() < 1e-3
        angles, lengths = plan.angles[step], plan.section_lengths[step]
        for section in range(3):
            longer = lengths + small * np.eye(3)[section]
            pulls = plan.robot.cable_lengths(angles, longer) - plan.robot.cable_lengths(angles, lengths)
            pressed = -data.actuator_force[1 : 1 + cables] @ pulls / small
            assert data.actuator_force[-3 + section] == pytest.approx(pressed, rel=0.01)


def test_controls_of_keyframes_move_the_arm_and_its_lengths_along_the_plan(plan, keyframes):
    model, data = keyframes.model, keyframes.data
    mj.mj_resetDataKeyframe(model, data, 0)
    for step in range(1, len(plan.time)):
        data.ctrl[:] = model.key_ctrl[step]
        mj.mj_step(model, data, 8)
    mj.mj_step(model, data, 100)
    assert data.warning.number.sum() == 0
    assert np.linalg.norm(data.body("tip").xpos - plan.joints[-1, -1]) < 0.4e-3
    lengths = data.ten_length[plan.robot.cables :] + plan.robot.link_lengths
    assert np.abs(lengths - plan.section_lengths[-1]).max() < GIVES * 0.03
    assert np.ptp(plan.section_lengths[[0, -1]], axis=0).max() > 10 * GIVES * 0.03


def test_without_cables_that_pull_slides_are_free(tmp_path):
    robot = metabot()
    export(robot, tmp_path / "model.xml")
    model = Mujoco((tmp_path / "model.xml").read_bytes()).model
    assert (model.nu, model.ntendon) == (0, robot.cables)
    slides = [j for j in range(model.njnt) if model.joint(j).name.startswith("length_")]
    added, shares = model.dof_armature[slides], np.abs(model.jnt_range[slides, 1]) / 0.01
    np.testing.assert_allclose(added * shares, 10 * robot.link_masses.sum(), rtol=1e-12)
    np.testing.assert_allclose(model.dof_damping[slides] * 0.1, added, rtol=1e-12)


def test_axes_and_bags_have_the_lengths(plan, tmp_path):
    names = [f"length_{i:02d}" for i in (1, 2, 3)]
    tables, arm = tables_of(plan, tmp_path), JointedArm.of(plan.robot)
    _, (axes, units, scales) = tables["axes.csv"]
    assert list(axes[9:]) == [*names, "slider"]
    assert (units[9:12], [float(scale) for scale in scales[9:12]]) == (("m",) * 3, [1.0] * 3)
    for section, axis in enumerate(names):
        headings, cells = tables[f"{axis}.csv"]
        assert headings == ["time_s", "position_m", "velocity_m_s"]
        np.testing.assert_array_equal(np.array(cells[1], float), plan.section_lengths[:, section])
    bag = bag_of(plan, tmp_path)
    _, joints, _, positions = bag[MOTORS]
    assert joints[9:] == [*names, "slider"]
    np.testing.assert_array_equal(positions[:, 9:12], plan.section_lengths)
    _, joints, _, positions = bag[ARM]
    leading = [joint for joint in joints if joint.startswith("length_")]
    assert leading == ["length_01_01", "length_02_01", "length_03_01"]
    for section, joint in enumerate(leading):
        longer = (plan.section_lengths[:, section] - 0.03) / (2 * arm.counts[section])
        np.testing.assert_allclose(positions[:, joints.index(joint)], longer, rtol=0, atol=1e-15)
