"""Models for MuJoCo and as URDF: where they put the arm, its cables and the obstacles, once they are loaded."""

import re

import numpy as np
import pytest
from model_makers import KINDS, SPRINGS, Mujoco, Urdf, all_robots, expected, mj, random_poses, sprung_robot, task_on
from robot_oracles import robot_of, section, tapered_robot

import hognose
from hognose.errors import InputError
from hognose.files.exports import export, formats
from hognose.files.exports.urdf import CROSS
from hognose.robot.base import joints_on

ROBOTS = {**all_robots(), "tapered 1": tapered_robot(1), "changing circles": tapered_robot(2, passing=True)}


@pytest.fixture(params=KINDS)
def kind(request):
    return request.param


@pytest.fixture(params=list(ROBOTS))
def robot(request):
    return ROBOTS[request.param]


def mujoco_of(source, folder):
    export(source, folder / "model.xml")
    return Mujoco((folder / "model.xml").read_bytes())


def urdf_of(source, folder):
    export(source, folder / "model.urdf")
    return Urdf(folder / "model.urdf")


@pytest.mark.parametrize("seed", range(2))
def test_mujoco_puts_joints_and_cables_where_hognose_does(kind, robot, seed, tmp_path):
    task = task_on(kind, robot, seed)
    model = mujoco_of(task, tmp_path)
    for at, angles in zip(*random_poses(task, seed), strict=True):
        model.set(task, at, angles)
        for found, wanted in zip(model.joints(robot.sections), expected(task, at, angles), strict=True):
            np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12)
        np.testing.assert_allclose(model.data.ten_length, robot.cable_lengths(angles), rtol=0, atol=1e-12)


@pytest.mark.parametrize("seed", range(2))
def test_a_urdf_puts_joints_where_hognose_does(kind, robot, seed, tmp_path):
    task = task_on(kind, robot, seed)
    model = urdf_of(task, tmp_path)
    for at, angles in zip(*random_poses(task, seed), strict=True):
        model.set(task, at, angles)
        for found, wanted in zip(model.joints(robot.sections), expected(task, at, angles), strict=True):
            np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12)


def test_a_robot_alone_is_on_its_slider_along_z(robot, tmp_path):
    models = mujoco_of(robot, tmp_path), urdf_of(robot, tmp_path)
    still = task_on("slider", robot, 0)  # only to say how coordinates are set
    _, angles = random_poses(still, 3, 2)
    for model in models:
        model.set(still, np.array([0.17]), angles[1])
        np.testing.assert_allclose(
            model.joints(robot.sections)[0], robot.joint_positions(angles[1], 0.17), rtol=0, atol=1e-12
        )


@pytest.mark.parametrize("name", ["pipe-tank", "drum", "carrier"])
def test_every_step_of_a_plan_is_a_keyframe(name, tmp_path):
    plan = hognose.plan(hognose.load_task(name))
    model = mujoco_of(plan, tmp_path)
    assert model.model.nkey == len(plan.time)
    np.testing.assert_array_equal(model.model.key_time, plan.time)
    wanted = joints_on(plan.task.base, plan.robot, plan.angles, plan.at)
    for step in range(0, len(plan.time), 9):
        mj.mj_resetDataKeyframe(model.model, model.data, step)
        mj.mj_forward(model.model, model.data)
        np.testing.assert_allclose(model.joints(plan.robot.sections)[0], wanted[step], rtol=0, atol=1e-12)
        np.testing.assert_allclose(model.data.ten_length, plan.cable_lengths[step], rtol=0, atol=1e-12)


def test_joints_have_the_robots_limits(kind, robot, tmp_path):
    task = task_on(kind, robot, 0)
    model, spec = mujoco_of(task, tmp_path).model, robot.spec
    other = urdf_of(task, tmp_path).model.joint_map
    groups = [group for group in spec.section for _ in range(group.count)]
    for i, group in enumerate(groups, 1):
        for name, bounds in zip((f"alpha_{i:02d}", f"beta_{i:02d}"), np.radians(group.bend_ranges), strict=True):
            assert model.joint(name).range.tolist() == bounds.tolist()
            assert model.joint(name).limited
            assert [other[name].limit.lower, other[name].limit.upper] == bounds.tolist()
            assert other[name].limit.velocity == pytest.approx(np.radians(spec.limits.joint_speed_deg_s), rel=1e-15)
    if kind == "arm":
        assert model.nmocap == 1
        assert model.nq == 2 * robot.sections
        return
    lever = 0.6 if kind == "drum" else 1.0
    name, high = ("drum", task.base.farthest) if kind == "drum" else ("feed", spec.feed.max)
    travel = [spec.feed.min / lever, min(high, spec.feed.max) / lever]
    np.testing.assert_allclose(model.joint(name).range, travel, rtol=1e-15)
    np.testing.assert_allclose([other[name].limit.lower, other[name].limit.upper], travel, rtol=1e-15)


def test_a_carrier_has_the_limits_of_its_workspace(tmp_path):
    base = {"kind": "arm", "workspace": {"low": (-1.0, -2.0, -3.0), "high": (4.0, 5.0, 6.0)}, "speed": 0.2,
            "turn_speed_deg_s": 90.0}  # fmt: skip
    task = task_on("arm", ROBOTS["sprung"], 0, base=base)
    limits = {name: joint.limit for name, joint in urdf_of(task, tmp_path).model.joint_map.items()}
    for axis, name in enumerate(("base_x", "base_y", "base_z")):
        assert limits[name].lower + task.base.start[axis] == pytest.approx([-1.0, -2.0, -3.0][axis])
        assert limits[name].upper + task.base.start[axis] == pytest.approx([4.0, 5.0, 6.0][axis])
        assert limits[name].velocity == 0.2
    assert [limits[f"base_{name}"].velocity for name in ("alpha", "beta", "roll")] == [np.pi / 2] * 3


def test_links_weigh_what_the_robot_file_says(robot, tmp_path):
    model = mujoco_of(robot, tmp_path).model
    links = urdf_of(robot, tmp_path).model.link_map
    for i, (mass, centre) in enumerate(zip(robot.link_masses, robot.centres_of_mass, strict=True)):
        body, link, cross = model.body(f"link_{i + 1:02d}"), links[f"link_{i + 1:02d}"], links[f"cross_{i + 1:02d}"]
        radius, length = robot.body_radii[i], robot.pitches[i]
        across, along = mass * (3 * radius**2 + length**2) / 12, mass * radius**2 / 2
        assert body.mass[0] == mass
        np.testing.assert_allclose(body.ipos, [0, 0, centre], rtol=0, atol=1e-15)
        np.testing.assert_allclose(body.inertia, [across, across, along], rtol=1e-12)
        assert link.inertial.mass + cross.inertial.mass == pytest.approx(mass, rel=1e-15)
        assert cross.inertial.mass == pytest.approx(CROSS * mass)
        np.testing.assert_allclose(link.inertial.origin[:3, 3], [0, 0, centre], rtol=0, atol=1e-15)
        np.testing.assert_allclose(link.inertial.inertia, np.diag([across, across, along]), rtol=1e-12)
    assert model.body("tip").mass[0] == robot.tool_mass
    assert model.body_subtreemass[model.body("link_01").id] == pytest.approx(robot.link_masses.sum() + robot.tool_mass)


def test_nothing_touches_anything_unless_asked(tmp_path):
    task = hognose.load_task("pipe-tank")
    model = mujoco_of(task, tmp_path).model
    assert not model.geom_contype.any()
    assert not model.geom_conaffinity.any()
    text = (tmp_path / "model.xml").read_text()
    asked = mj.MjModel.from_xml_string(text.replace('contype="0" conaffinity="0"', 'contype="1" conaffinity="1"'))
    assert asked.geom_contype.all()


def test_cables_pull_as_springs_and_hold_the_arm(tmp_path):
    robot = sprung_robot()
    task = task_on("slider", robot, 1)
    model = mujoco_of(task, tmp_path)
    data, pretension, most = model.data, SPRINGS["pretension_N"], SPRINGS["tension_max_N"]
    model.set(task, np.zeros(1), np.zeros((robot.sections, 2)))
    cables = [model.model.actuator(f"cable_{k:02d}").id for k in range(1, robot.cables + 1)]
    np.testing.assert_allclose(data.actuator_force[cables], -pretension, rtol=1e-9)
    data.ctrl[cables[0]] = 1e-4  # paid out by so much
    mj.mj_forward(model.model, data)
    lost = 1e-4 * SPRINGS["axial_stiffness_N"] / (robot.straight_cable_lengths[0] + SPRINGS["free_length"])
    assert data.actuator_force[cables[0]] == pytest.approx(lost - pretension, rel=1e-9)
    data.ctrl[cables] = [0.01, -0.01] + [0.0] * (robot.cables - 2)
    mj.mj_forward(model.model, data)
    np.testing.assert_allclose(data.actuator_force[cables[:2]], [0.0, -most], atol=1e-9)  # only pull
    data.ctrl[:] = 0
    mj.mj_step(model.model, data, 1000)
    straight = joints_on(task.base, robot, np.zeros((1, robot.sections, 2)), np.zeros((1, 1)))[0]
    assert 1e-6 < np.linalg.norm(data.body("tip").xpos - straight[-1]) < 2e-3


@pytest.mark.parametrize("kind", ["slider", "drum", "arm"])
def test_the_plans_tensions_hold_the_arm_at_every_step(kind, tmp_path):
    robot = sprung_robot()
    plan = hognose.plan(task_on(kind, robot, 2, gravity_m_s2=(3.0, -8.0, 4.0)))
    assert plan.held is not None
    assert plan.held.is_held.all()
    model = mujoco_of(plan, tmp_path)
    data, hinges = model.data, slice(-2 * robot.sections, None)
    assert model.model.opt.gravity.tolist() == [3.0, -8.0, 4.0]
    for step in range(0, len(plan.time), 5):
        mj.mj_resetDataKeyframe(model.model, data, step)
        mj.mj_forward(model.model, data)
        pulls = [float(data.actuator(f"cable_{k:02d}").force[0]) for k in range(1, robot.cables + 1)]
        np.testing.assert_allclose(pulls, -plan.held.tensions[step], rtol=1e-9)
        np.testing.assert_allclose(data.qfrc_actuator[hinges], data.qfrc_bias[hinges], rtol=0, atol=1e-9)


def test_a_robot_without_springs_stays_as_it_is_set(tmp_path):
    export(ROBOTS["tapered 1"], tmp_path / "model.xml")
    model = Mujoco((tmp_path / "model.xml").read_bytes())
    model.data.qpos[3] = 0.2
    mj.mj_step(model.model, model.data, 200)
    assert model.data.qpos[3] == pytest.approx(0.2, abs=1e-12)
    assert model.model.nu == 0


def test_an_arm_of_more_sections_than_mujoco_reads_is_refused(tmp_path):
    def arm(count):
        return robot_of(
            [section(count=count, pitch=0.03, half_lengths=(0.005, 0.005), cable_azimuths_deg=(0, 120, 240))]
        )

    written = export(arm(490), tmp_path / "long.xml")
    model = Mujoco((tmp_path / "long.xml").read_bytes()).model
    assert (model.nv, model.ntendon) == (981, 0)
    assert written.remarks[0].startswith("the cables are left out, as MuJoCo takes minutes to read their 723,240 holes")
    with pytest.raises(InputError, match=r"an arm of 490 sections at most; this one has 491\. Export it as a URDF"):
        export(arm(491), tmp_path / "longer.xml")
    assert not (tmp_path / "longer.xml").exists()
    export(arm(491), tmp_path / "longer.urdf")


def test_what_has_no_motion_is_written_only_as_a_model(tmp_path):
    task = hognose.load_task("pipe-tank")
    for suffix, chosen in formats().items():
        for source, what, able in ((task, "task", chosen.of_task), (task.robot, "robot", chosen.of_robot)):
            if able is not None:
                assert export(source, tmp_path / f"{what}{suffix}").plan is None
                continue
            message = rf"{re.escape(source.name)}: is a {what}, but \{suffix} is written of a plan; .* \.xml, \.urdf"
            with pytest.raises(InputError, match=message):
                export(source, tmp_path / f"{what}{suffix}")
    with pytest.raises(InputError, match=r"source: expected a hognose\.Plan, Task or Robot, got str"):
        export("pipe-tank", tmp_path / "model.xml")  # pyright: ignore[reportArgumentType]
