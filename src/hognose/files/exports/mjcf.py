"""Arm and space as a MuJoCo model (MJCF): bodies, joints, cables as spatial tendons, obstacles as meshes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hognose.errors import InputError
from hognose.files.exports import mjcf_cables, mjcf_lengths, mjcf_looks
from hognose.files.exports.format import Content, Export
from hognose.files.exports.jointed_arm import JointedArm
from hognose.files.exports.masses import MOUNT_MASS, mount_inertia
from hognose.files.exports.mounting import Mounting
from hognose.files.exports.obstacle_meshes import ObstacleMesh, obstacle_meshes, remarks_on_obstacles
from hognose.files.exports.rigid_parts import Joint, Part
from hognose.files.exports.subject import Subject
from hognose.files.exports.xml import Element, comment, document, element, integers, numbers

#: MuJoCo's reader refuses elements nested deeper than 500.
MOST_PARTS = 490
#: A mesh of fewer vertices is refused by MuJoCo; the first one is repeated.
_FEWEST_VERTICES = 4
#: [assumed] What joints of such arms resist with (N m s/rad), and the inertia (kg m²) that their drives add.
_DAMPING, _ARMATURE = 0.05, 1e-4
#: Mass times length² (kg m²) of the paper's links, whose joints have these.
_INERTIA = 0.062 * 0.091**2
#: How fast (s), and with how much of the critical damping, joints come back that follow another one.
_COUPLED = (0.004, 1.0)
#: [assumed] How stiffly (N/m) and with how much damping (N s/m) a drive holds the slider, or in N m/rad the drum.
DRIVE, DRIVE_DAMPING = 2e5, 2e3

_ABOUT = (
    "Made by Hognose. SI units: m, rad, s, kg, N. The frame of the world is that of the task.",
    "Joints are zero when the straight arm is at feed 0. In section i, alpha_i turns about y and then beta_i about x: "
    "the order of the two joints of a body matters. Names of joints and tendons are those of the plan file's columns. "
    "Every cable is a spatial tendon from the hole plane before the first joint to the disk it is fixed to: its length "
    "is the column's.",
    "MuJoCo takes the convex hull of a mesh for contact, which closes every hole. So all geoms are only to look at: "
    'contype and conaffinity are 0. To change that, set them in the default classes "arm" and "obstacle". '
    "Hognose's own contact is with the triangles.",
    f"Assumed: links are solid cylinders for their moments of inertia; damping and armature of joints; a mount of "
    f"{MOUNT_MASS:g} kg; the field of view of the tip camera. MuJoCo 3.3 or later.",
)


def bare(subject: Subject, arm: JointedArm) -> Element:
    """The model of the arm on its base alone, for whoever has cables, drives and contact of their own.

    Raises
    ------
    InputError
        As `mjcf`.
    """
    _refuse_too_many(arm)
    root, _ = _begun(subject, [])
    _defaults(root)
    mjcf_looks.materials(element(root, "asset"))
    _arm(element(root, "worldbody"), arm, Mounting.of(subject.base, subject.robot), False)
    return root


def mjcf(subject: Subject) -> tuple[Element, list[str]]:
    """The model, and remarks on what is not in it, in sentences.

    Raises
    ------
    InputError
        An arm of more sections than MuJoCo reads.
    """
    robot, arm = subject.robot, JointedArm.of(subject.robot)
    _refuse_too_many(arm)
    meshes, mounting = obstacle_meshes(subject), Mounting.of(subject.base, robot)
    remarks = [*remarks_on_obstacles(subject), *mjcf_cables.remarks(arm), *arm.remarks]
    root, option = _begun(subject, [*_ABOUT, *(f"Note: {words}." for words in remarks)])
    if not mjcf_cables.pull(arm):
        element(option, "flag", gravity="disable")
    elif robot.extends:
        option.set("tolerance", numbers(mjcf_lengths.TOLERANCE))
    mjcf_looks.views(root, subject, meshes)
    _defaults(root)
    _assets(root, meshes)
    world = element(root, "worldbody")
    mjcf_looks.lights_and_camera(world, subject, meshes)
    for mesh in meshes:
        element(world, "geom", name=mesh.name, class_="obstacle", mesh=mesh.name, pos=mesh.centre)
    _arm(world, arm, mounting, mjcf_cables.shown(arm))
    if mjcf_cables.shown(arm):
        tendons = mjcf_cables.tendons(root, arm)
        if mjcf_cables.pull(arm):
            mjcf_lengths.tendons(tendons, arm)
    _follow(root, arm)
    _drives(root, arm, mounting)
    _steps(root, subject, arm, mounting)
    return root, remarks


def _begun(subject: Subject, about: Sequence[str]) -> tuple[Element, Element]:
    """A model with a comment and what holds for all of it; also the element of its options."""
    root = element(None, "mujoco", model=subject.name)
    if about:
        comment(root, about)
    element(root, "compiler", angle="radian", boundinertia=1e-14)
    return root, element(root, "option", gravity=subject.gravity, timestep=0.002, integrator="implicitfast")


def _refuse_too_many(arm: JointedArm) -> None:
    links = len(arm.parts) - 2
    if links > MOST_PARTS:
        what = "sections" if links == arm.robot.sections else "links in its sections"
        raise InputError(
            f"{arm.robot.name}: MuJoCo reads elements nested 500 deep, so an arm of {MOST_PARTS} {what} at most; this "
            f"one has {links}. Export it as a URDF"
        )


def _content(subject: Subject) -> Content:
    root, remarks = mjcf(subject)
    return Content(document(root), remarks=tuple(remarks))


EXPORT = Export(
    ".xml",
    "arm and space as a MuJoCo model (MJCF), a keyframe for each step",
    lambda plan: _content(Subject.of_plan(plan)),
    lambda task: _content(Subject.of_task(task)),
    lambda robot: _content(Subject(robot)),
)


def _defaults(root: Element) -> None:
    default = element(root, "default")
    arm = element(default, "default", class_="arm")
    element(arm, "joint", damping=_DAMPING, armature=_ARMATURE)
    element(arm, "geom", type="capsule", contype="0", conaffinity="0", mass="0", material="arm")
    element(arm, "site", size=0.001, group="3")
    obstacle = element(default, "default", class_="obstacle")
    element(obstacle, "geom", type="mesh", contype="0", conaffinity="0", mass="0", material="obstacle")
    cable = element(default, "default", class_="cable")
    element(cable, "tendon", width=0.0006, rgba=(0.25, 0.27, 0.3, 1.0))


def _assets(root: Element, meshes: list[ObstacleMesh]) -> None:
    asset = element(root, "asset")
    mjcf_looks.materials(asset)
    for mesh in meshes:
        lacking = max(0, _FEWEST_VERTICES - len(mesh.vertices))
        vertices = np.concatenate([mesh.vertices, np.repeat(mesh.vertices[:1], lacking, axis=0)])
        element(asset, "mesh", name=mesh.name, inertia="shell", vertex=vertices, face=integers(mesh.faces))


def _arm(world: Element, arm: JointedArm, mounting: Mounting, cables: bool) -> None:
    robot, (mount, *links, end) = arm.robot, arm.parts
    axes = np.concatenate([mounting.R_task_base[:, 0], mounting.R_task_base[:, 1]])
    mocap = "true" if mounting.kind == "pose" else None
    body = element(world, "body", name="mount", pos=mounting.start, xyaxes=axes, mocap=mocap, childclass="arm")
    _mount(body, mounting, float(robot.body_radii[0]))
    _looks(body, arm, mount)
    if cables:
        mjcf_cables.holes(body, arm, mount)
    for part in links:
        body = element(body, "body", name=f"link_{part.label}", pos=(0.0, 0.0, part.shift))
        element(body, "inertial", pos=(0.0, 0.0, part.centre), mass=part.mass, diaginertia=part.inertia)
        for joint in part.joints:
            if joint.slides:
                mjcf_lengths.slide(body, arm, joint)
            else:
                _hinge(body, arm, joint)
        _looks(body, arm, part)
        if cables:
            mjcf_cables.holes(body, arm, part)
    tip = element(body, "body", name="tip", pos=(0.0, 0.0, end.shift))
    if robot.tool_mass:
        element(tip, "inertial", pos="0 0 0", mass=robot.tool_mass, diaginertia="0 0 0")
    element(tip, "site", name="tip")
    mjcf_looks.tip(tip)


def _hinge(body: Element, arm: JointedArm, joint: Joint) -> None:
    small = joint.share != 1.0
    scale = _scale(arm, joint.section) / joint.share if small else 1.0
    element(body, "joint", name=joint.name, axis="1 0 0" if joint.axis else "0 1 0", range=arm.bounds(joint),
            stiffness=arm.spring(joint) or None, damping=_DAMPING * scale if small else None,
            armature=_ARMATURE * scale if small else None)  # fmt: skip


def _scale(arm: JointedArm, section: int) -> float:
    """By how much a section's joints have less damping and armature than the paper's: as its own inertia is less."""
    inertia = arm.robot.link_masses[section] * arm.robot.pitches[section] ** 2
    return min(1.0, float(inertia) / _INERTIA)


def _looks(body: Element, arm: JointedArm, part: Part) -> None:
    for low, high, section in part.drawn:
        material, (width, height) = "arm" if section % 2 else "arm_2", arm.robot.outline.sides[section].tolist()
        if width > 0.0:
            element(body, "geom", type="box", pos=(0.0, 0.0, 0.5 * (low + high)),
                    size=(width / 2, height / 2, 0.5 * (high - low)), material=material)  # fmt: skip
        else:
            element(body, "geom", fromto=(0.0, 0.0, low, 0.0, 0.0, high), size=arm.robot.body_radii[section],
                    material=material)  # fmt: skip


def _follow(root: Element, arm: JointedArm) -> None:
    """Joints that follow the first one of their section."""
    if not arm.following:
        return
    inside = element(root, "equality")
    for joint, first, factor in arm.following:
        element(inside, "joint", name=joint.name, joint1=joint.name, joint2=first.name,
                polycoef=(0.0, factor, 0.0, 0.0, 0.0), solref=_COUPLED)  # fmt: skip


def _mount(body: Element, mounting: Mounting, radius: float) -> None:
    """The joint of the mount, its mass and what it looks like."""
    length = mounting.length_behind or mounting.radius
    element(body, "inertial", pos="0 0 0", mass=MOUNT_MASS, diaginertia=mount_inertia(radius, length))
    travel = (mounting.low, mounting.high)
    if mounting.kind == "slide":
        element(body, "joint", name=mounting.joint, type="slide", axis="0 0 1", range=travel)
    elif mounting.kind == "turn":
        centre = np.array([mounting.radius, 0.0, 0.0])
        element(body, "joint", name=mounting.joint, axis="0 1 0", pos=centre, range=travel)
        half, thick = np.array([0.0, radius, 0.0]), max(mounting.radius - radius, radius)
        ends = np.concatenate([centre - half, centre + half])
        element(body, "geom", type="cylinder", fromto=ends, size=thick, material="mount")
    if mounting.length_behind > 0:
        ends = (0.0, 0.0, -mounting.length_behind, 0.0, 0.0, 0.0)
        element(body, "geom", fromto=ends, size=mounting.radius_behind, material="mount")


def _drives(root: Element, arm: JointedArm, mounting: Mounting) -> None:
    """Actuators, where the robot file says what cables are as springs."""
    if not mjcf_cables.pull(arm):
        return
    actuators = element(root, "actuator")
    if mounting.kind != "pose":
        lever = mounting.radius or 1.0
        element(actuators, "position", name=mounting.joint, joint=mounting.joint, kp=DRIVE * lever**2,
                kv=DRIVE_DAMPING * lever**2, ctrlrange=(mounting.low, mounting.high))  # fmt: skip
    mjcf_cables.springs(actuators, arm.robot)
    mjcf_lengths.drives(actuators, arm.robot)


def _steps(root: Element, subject: Subject, arm: JointedArm, mounting: Mounting) -> None:
    """A keyframe for each step of the plan."""
    plan = subject.plan
    if plan is None:
        return
    keys = element(root, "keyframe")
    first = mounting.values(plan.at)
    poses = np.concatenate([first, arm.values(plan.angles, plan.section_lengths)], axis=1)
    carried = plan.at if mounting.kind == "pose" else None
    driven = None
    if mjcf_cables.pull(arm):
        driven = np.concatenate([first, mjcf_cables.paid_out(plan, arm), mjcf_lengths.longer(plan)], axis=1)
    for step, time in enumerate(plan.time):
        element(
            keys,
            "key",
            name=f"step_{step}",
            time=time,
            qpos=poses[step],
            mpos=None if carried is None else carried[step, :3],
            mquat=None if carried is None else carried[step, 3:],
            ctrl=None if driven is None else driven[step],
        )
