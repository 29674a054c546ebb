"""Arm and space as a URDF: links, joints with limits, inertias, obstacles as meshes in OBJ files beside it."""

from __future__ import annotations

import hashlib
import re

import numpy as np

from hognose.files.exports import urdf_parts as parts
from hognose.files.exports.colours import COLOURS
from hognose.files.exports.format import Content, Export
from hognose.files.exports.jointed_arm import JointedArm
from hognose.files.exports.masses import MOUNT_MASS
from hognose.files.exports.mounting import Mounting
from hognose.files.exports.obstacle_meshes import ObstacleMesh, obstacle_meshes, remarks_on_obstacles
from hognose.files.exports.rigid_parts import Part
from hognose.files.exports.subject import Subject
from hognose.files.exports.urdf_base import add_base
from hognose.files.exports.xml import Element, comment, document, element

#: The folder of the meshes.
FOLDER = "meshes"
#: Share of a link's mass that is in the cross of its universal joint: simulators take no body without any.
CROSS = 1e-6

_ABOUT = (
    "Made by Hognose. SI units: m, rad, s, kg. The link task is the frame of the task, with all obstacles.",
    "All joints are zero when the straight arm is at feed 0. In section i, alpha_i turns about y and then beta_i about "
    "x, with a cross between them; names of joints are those of the plan file's columns.",
    "Obstacles are meshes, and holes in them are holes. Programs that make convex hulls of them for contact, such as "
    "PyBullet, close these holes.",
    f"Assumed: links are solid cylinders for their moments of inertia; {CROSS:g} of a link's mass is in its cross; "
    f"{MOUNT_MASS:g} kg for each part that moves the arm; efforts of {parts.EFFORT:g} N and N m.",
)
_LEFT_OUT = "a URDF has no cables and no motion: lengths and angles step by step are in the plan's columns (CSV)"
_MIMIC = (
    "joints that follow another one are `mimic` joints, which PyBullet does not know: set them there to the same value"
)
_SLIDES = "slides are as fast as cables may be, as nobody says how fast lengths change"
_CARRIED = (
    "the carrier is six joints from where it is at feed 0: base_x, base_y and base_z along the axes of the task, then "
    "base_alpha, base_beta and base_roll about y, x and z of the arm"
)


def urdf(subject: Subject) -> Content:
    """The file, its meshes, and remarks on what is not in it."""
    arm, mounting = JointedArm.of(subject.robot), Mounting.of(subject.base, subject.robot)
    meshes = obstacle_meshes(subject)
    remarks = [*remarks_on_obstacles(subject), _LEFT_OUT, *([_CARRIED] if mounting.kind == "pose" else [])]
    remarks += [*arm.remarks, *([_MIMIC] if arm.following else []), *([_SLIDES] if subject.robot.extends else [])]
    root = element(None, "robot", name=subject.name)
    comment(root, [*_ABOUT, *(f"Note: {words}." for words in remarks)])
    for name, colour in COLOURS.items():
        element(element(root, "material", name=name), "color", rgba=colour)
    files = _obstacles(element(root, "link", name="task"), meshes)
    _looks(add_base(root, subject, mounting), arm, arm.parts[0])
    _arm(root, arm)
    return Content(document(root), files, tuple(remarks))


EXPORT = Export(
    ".urdf",
    "arm and space as a URDF, obstacles in OBJ files beside it",
    lambda plan: urdf(Subject.of_plan(plan)),
    lambda task: urdf(Subject.of_task(task)),
    lambda robot: urdf(Subject(robot)),
)


def _obstacles(link: Element, meshes: list[ObstacleMesh]) -> dict[str, bytes]:
    """The obstacles of the root link; returns their files."""
    files = {}
    for mesh in meshes:
        content = _obj(mesh)
        # Named by its content, so that files that share the folder never change what another one names.
        called = re.sub(r"[^A-Za-z0-9]+", "_", mesh.name).strip("_")[:40] or "obstacle"
        name = f"{FOLDER}/{called}-{hashlib.sha256(content).hexdigest()[:12]}.obj"
        files[name] = content
        for tag in ("visual", "collision"):
            part = element(link, tag, name=mesh.name)
            element(part, "origin", xyz=mesh.centre, rpy=parts.NONE)
            element(element(part, "geometry"), "mesh", filename=name)
            if tag == "visual":
                element(part, "material", name="obstacle")
    return files


def _obj(mesh: ObstacleMesh) -> bytes:
    rows = [f"v {x!r} {y!r} {z!r}" for x, y, z in (mesh.vertices + 0.0).tolist()]
    rows += [f"f {a} {b} {c}" for a, b, c in (mesh.faces + 1).tolist()]
    return "\n".join(["# Made by Hognose; m", *rows, ""]).encode()


def _arm(root: Element, arm: JointedArm) -> None:
    robot, links, end = arm.robot, arm.parts[1:-1], arm.parts[-1]
    speed = float(np.radians(robot.spec.limits.joint_speed_deg_s))
    leaders = {joint.name: (first.name, factor) for joint, first, factor in arm.following}
    parent = "mount"
    for part in links:
        assert part.inertia is not None, "only the mount and the tip have none"
        child, shift, small = f"link_{part.label}", (0.0, 0.0, part.shift), CROSS * part.mass
        within = [f"cross_{part.label}"] if len(part.joints) > 1 else []
        if len(part.joints) > 2:
            within.insert(0, f"slide_{part.label}")
        for joint, inner in zip(part.joints, [*within, child], strict=True):
            limit = (*arm.bounds(joint), joint.share * (robot.spec.limits.cable_speed if joint.slides else speed))
            slides, turns = (parts.Z, None) if joint.slides else (None, parts.X if joint.axis else parts.Y)
            parts.joint(root, joint.name, parent, inner, shift, turns=turns, slides=slides, limit=limit,
                        leader=leaders.get(joint.name))  # fmt: skip
            if inner != child:
                parts.link(root, inner, small, CROSS * part.inertia)
            parent, shift = inner, parts.NONE
        mass = (1 - CROSS * len(within)) * part.mass if within else part.mass
        link = parts.link(root, child, mass, part.inertia, part.centre)
        _looks(link, arm, part)
    parts.joint(root, "tip", parent, "tip", (0.0, 0.0, end.shift))
    if robot.tool_mass:
        parts.link(root, "tip", robot.tool_mass, parts.NONE)
    else:
        element(root, "link", name="tip")


def _looks(link: Element, arm: JointedArm, part: Part) -> None:
    for low, high, section in part.drawn:
        radius, material = float(arm.robot.body_radii[section]), "arm" if section % 2 else "arm_2"
        width, height = arm.robot.outline.sides[section].tolist()
        if width > 0.0:
            parts.box(link, (width, height, high - low), (0.0, 0.0, low + (high - low) / 2), material)
            continue
        parts.cylinder(link, radius, high - low, (0.0, 0.0, low + (high - low) / 2), material)
        for height in (low, high):
            parts.ball(link, radius, height, material)
