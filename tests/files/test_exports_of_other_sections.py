"""What is exported of arms whose sections are no rigid links: loaded in other programs, it is where Hognose has it."""

import re

import numpy as np
import pytest
from model_makers import SPRINGS, Mujoco, Urdf, mj
from robot_oracles import random_angles, robot_of, section
from section_makers import dense_line, mixed_robot, of_kind
from test_extending_plans import metabot

import hognose
from hognose.errors import InputError
from hognose.files import load_robot
from hognose.files.exports import export
from hognose.files.exports.arc_joints import chain_points, counts_of, errors_of
from hognose.files.exports.jointed_arm import WITHIN, JointedArm
from hognose.planning import Task, TaskSpec
from hognose.robot.base import joints_on

ARMS = {
    "three arcs": metabot(with_cables=True, length_range=None),
    "zju-24cable": load_robot("zju-24cable"),
    "on-wing-taper": load_robot("on-wing-taper"),
    "mixed": mixed_robot(3, tool_length=0.03, tool_mass=0.05),
}


@pytest.fixture(params=list(ARMS), scope="module")
def robot(request):
    return ARMS[request.param]


@pytest.fixture(scope="module")
def models(robot, tmp_path_factory):
    folder = tmp_path_factory.mktemp("models")
    export(robot, folder / "model.xml")
    export(robot, folder / "model.urdf")
    return Mujoco((folder / "model.xml").read_bytes()), Urdf(folder / "model.urdf")


def joints_of_mujoco(model, angles, feed):
    """Set every joint by what its name says: alpha_03_07 is the seventh of the third section about y."""
    names = [model.model.joint(j).name for j in range(model.model.njnt)]
    count = {name[:8].rstrip("_"): 0 for name in names}
    for name in names:
        count[name[:8].rstrip("_")] += 1
    for name in names:
        if name == "feed":
            value = feed
        else:
            axis, number = name.split("_")[:2]
            value = angles[int(number) - 1, int(axis == "beta")] / count[f"{axis}_{number}"]
        model.data.qpos[model.model.joint(name).qposadr[0]] = value
    mj.mj_forward(model.model, model.data)


def body_of_mujoco(model):
    """Ends (m, 2, 3) of the capsules of the arm, in their order, and the tip."""
    model, data = model.model, model.data
    found = []
    for g in range(model.ngeom):
        if model.geom_type[g] == mj.mjtGeom.mjGEOM_CAPSULE and model.geom_matid[g] != model.mat("mount").id:
            half = model.geom_size[g, 1] * data.geom_xmat[g].reshape(3, 3)[:, 2]
            # Its axis is from the second end to the first.
            found.append([data.geom_xpos[g] + half, data.geom_xpos[g] - half])
    return np.array(found), data.body("tip").xpos


def off_the_line(points, line):
    """How far (m) points are from a polyline (q, 3)."""
    begin, along = line[:-1], np.diff(line, axis=0)
    size = np.einsum("qi,qi->q", along, along)
    keep = size > 0
    begin, along, size = begin[keep], along[keep], size[keep]
    share = np.clip(np.einsum("pqi,qi->pq", points[:, None] - begin, along) / size, 0.0, 1.0)
    return np.linalg.norm(points[:, None] - begin - share[..., None] * along, axis=-1).min(axis=1)


def test_body_tip_and_cables_are_where_hognose_has_them(robot, models):
    arm, rng = JointedArm.of(robot), np.random.default_rng(5)
    exact = 1e-12
    model, urdf = models
    leading = {joint.name: joint for joint in arm.leading.values()}
    assert sorted(urdf.model.actuated_joint_names) == sorted(["feed", *leading])
    for share in (0.0, 0.7, 1.0):
        corner = share * np.sign(rng.normal(size=(robot.sections, 2))) * robot.bend_limits
        angles = random_angles(robot, rng) if share == 0.7 else corner
        joints_of_mujoco(model, angles, 0.02)
        ends, tip = body_of_mujoco(model)
        line = dense_line(robot, angles, 60)[0] + [0.0, 0.0, 0.02]
        tool = robot.joint_positions(angles, 0.02)[-1]
        assert np.linalg.norm(tip - tool) <= arm.off + exact
        assert off_the_line(ends.reshape(-1, 3), line).max() <= arm.off + 1e-5 * robot.length
        assert off_the_line(line[::20], np.concatenate([ends[:1, 0], ends[:, 1]])).max() <= arm.off + exact
        off = np.abs(model.data.ten_length - robot.cable_lengths(angles)).max()
        assert off <= arm.cables_off + exact
        values = {name: float(joint.share * angles[joint.section, joint.axis]) for name, joint in leading.items()}
        urdf.model.update_cfg({"feed": 0.02, **values})
        at = urdf.model.get_transform("tip", "task")
        np.testing.assert_allclose(at[:3, 3], tip, rtol=0, atol=1e-11)
        np.testing.assert_allclose(at[:3, :3], model.data.body("tip").xmat.reshape(3, 3), rtol=0, atol=1e-11)


def test_how_far_arcs_are_off_is_small_and_said(robot, tmp_path):
    arm = JointedArm.of(robot)
    arcs = sum(count > 1 for count in arm.counts)
    assert arm.off <= WITHIN * robot.length
    assert (arm.off > 0) == (arm.cables_off > 0) == (arcs > 0)
    for name in ("model.xml", "model.urdf"):
        said = " ".join(export(robot, tmp_path / name).remarks)
        assert (f"no point of the arm's line is off by more than {1e3 * arm.off:.2g} mm" in said) == (arcs > 0)
        written = re.sub(r"\s+", " ", (tmp_path / name).read_text())
        assert (f"is off by more than {1e3 * arm.off:.2g} mm" in written) == (arcs > 0)


def test_sections_weigh_what_the_robot_file_says(robot, models):
    model, urdf = models[0].model, models[1].model
    model_mass = model.body_subtreemass[model.body("mount").id] - model.body("mount").mass[0]
    assert model_mass == pytest.approx(robot.link_masses.sum() + robot.tool_mass, rel=1e-5)
    weighed = {name: link.inertial for name, link in urdf.link_map.items() if name != "mount"}
    links = [inertial.mass for inertial in weighed.values() if inertial]
    assert sum(links) == pytest.approx(model_mass, rel=1e-9)
    joints_of_mujoco(models[0], np.zeros((robot.sections, 2)), 0.0)
    inner = [b for b in range(model.nbody) if model.body(b).name.startswith(("link_", "tip"))]
    centre = model.body_mass[inner] @ models[0].data.xipos[inner, 2] / model_mass
    begins = np.append(0.0, np.cumsum(robot.pitches[:-1]))
    moment = robot.link_masses @ (begins + robot.centres_of_mass) + robot.tool_mass * robot.length
    assert centre == pytest.approx(moment / model_mass, rel=1e-5)


def test_joints_of_a_section_follow_the_first_within_their_limits(robot, models):
    model, urdf = models[0].model, models[1].model
    arm = JointedArm.of(robot)
    assert model.neq == sum(joint.mimic is not None for joint in urdf.joint_map.values()) == len(arm.following)
    for joint in arm.joints:
        most = float(robot.bend_limits[joint.section, joint.axis]) * joint.share
        assert model.joint(joint.name).range.tolist() == pytest.approx([-most, most])
        assert urdf.joint_map[joint.name].limit.upper == pytest.approx(most)
    total = {}
    for joint in arm.joints:
        total[joint.section, joint.axis] = total.get((joint.section, joint.axis), 0.0) + joint.share
    assert len(total) == 2 * robot.sections
    np.testing.assert_allclose(list(total.values()), 1.0, rtol=1e-12)


def test_every_step_of_a_plan_is_a_keyframe(tmp_path):
    plan = hognose.plan(hognose.load_task("baffled-tank"))
    export(plan, tmp_path / "model.xml")
    model, arm = Mujoco((tmp_path / "model.xml").read_bytes()), JointedArm.of(plan.robot)
    wanted, cables = (
        joints_on(plan.task.base, plan.robot, plan.angles, plan.at, plan.section_lengths),
        plan.robot.cables,
    )
    assert model.model.nkey == len(plan.time)
    for step in range(0, len(plan.time), 25):
        mj.mj_resetDataKeyframe(model.model, model.data, step)
        mj.mj_forward(model.model, model.data)
        assert np.linalg.norm(model.data.body("tip").xpos - wanted[step, -1]) <= arm.off
        assert np.abs(model.data.ten_length[:cables] - plan.cable_lengths[step]).max() <= arm.cables_off
        assert np.abs(model.data.efc_pos[: model.model.neq]).max() < 1e-12
    mj.mj_resetDataKeyframe(model.model, model.data, len(plan.time) - 1)
    mj.mj_step(model.model, model.data, 100)  # cables, rods and joints that follow hold it there
    assert np.linalg.norm(model.data.body("tip").xpos - wanted[-1, -1]) <= arm.off + 0.1e-3


def test_springs_of_joints_and_cables_hold_a_bent_arc(tmp_path):
    """A keyframe holds the pose: torques of cables, weight and backbone add up to none for a section's angles."""
    part = of_kind("arc", cable_radius=0.019, disks=6, bending_stiffness_N_m2=0.8, count=2)
    robot = robot_of([part, of_kind("joints", bending_stiffness_N_m2=0.5)], cables=SPRINGS)
    spec = {
        "name": "bent",
        "robot": robot.name,
        "path": {"way_points": [(0, 0, 0), (0, 0, 0.05), (0.01, 0.0, 0.15), (0.05, 0.02, 0.25)]},
        "motion": {"method": "aim", "step": 0.01, "period_s": 0.6},
    }
    plan = hognose.plan(Task(TaskSpec.model_validate(spec), robot))
    assert plan.held is not None
    assert plan.held.is_held.all()
    export(plan, tmp_path / "model.xml")
    model, arm = Mujoco((tmp_path / "model.xml").read_bytes()), JointedArm.of(robot)
    data = model.data
    for step in range(0, len(plan.time), 6):
        mj.mj_resetDataKeyframe(model.model, data, step)
        mj.mj_forward(model.model, data)
        left = arm.shares.T @ (data.qfrc_actuator + data.qfrc_passive - data.qfrc_bias)[1:]
        largest = np.abs(arm.shares.T @ data.qfrc_passive[1:]).max() + np.abs(arm.shares.T @ data.qfrc_bias[1:]).max()
        assert np.abs(left).max() < 5e-3 * max(largest, 0.05)


def test_where_cables_are_led_all_along_they_step_to_another_circle_at_no_length(tmp_path):
    kinds = {"link": 0.012, "arc": None, "joints": 0.01}
    parts = [of_kind(kind, passing_cable_radius=radius) for kind, radius in kinds.items()]
    robot = robot_of([*parts, of_kind("arc"), of_kind("arc", passing_cable_radius=0.012), of_kind("arc")])
    export(robot, tmp_path / "model.xml")
    model, arm, rng = Mujoco((tmp_path / "model.xml").read_bytes()), JointedArm.of(robot), np.random.default_rng(3)
    assert arm.cables_off < 0.4e-3
    for share in (0.0, 0.5, 1.0):
        angles = random_angles(robot, rng, share=share)
        joints_of_mujoco(model, angles, 0.01)
        assert np.abs(model.data.ten_length - robot.cable_lengths(angles)).max() <= arm.cables_off


def test_more_joints_are_closer_by_the_square_of_their_number():
    coarse, fine = (errors_of(0.1, (0.7, 0.5), count) for count in (8, 16))
    assert coarse[0] / fine[0] == pytest.approx(4.0, rel=0.1)
    assert coarse[1] / fine[1] > 3.5
    straight = chain_points(np.zeros(1), np.zeros(1), 0.1, 8)[0][0]
    np.testing.assert_allclose(straight, np.outer(np.arange(17) / 16, [0, 0, 0.1]), atol=1e-15)
    assert [counts_of(None)[0], counts_of(10)[1], counts_of(3)[0], counts_of(100)[0]] == [4, 20, 6, 100]


def test_an_arm_of_more_parts_than_mujoco_reads_is_refused(tmp_path):
    robot = robot_of([section(kind="joints", joints=50, pitch=1.1, count=10, half_lengths=(0.005, 0.005))])
    with pytest.raises(InputError, match=r"an arm of 490 links in its sections at most; this one has 500\."):
        export(robot, tmp_path / "long.xml")
    assert not (tmp_path / "long.xml").exists()
