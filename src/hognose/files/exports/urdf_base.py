"""What moves the arm in a URDF: a slider, a drum, or the six axes of a carrier."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.files.exports import urdf_parts as parts
from hognose.files.exports.masses import MOUNT_MASS, mount_inertia
from hognose.files.exports.mounting import Mounting
from hognose.files.exports.subject import Subject
from hognose.files.exports.urdf_parts import X, Y, Z
from hognose.files.exports.xml import Element

Array = NDArray[np.float64]

#: How far (m) a carrier goes that has no workspace.
_ANYWHERE = 100.0


def add_base(root: Element, subject: Subject, mounting: Mounting) -> Element:
    """Add all from the link task to the link mount, in which the first joint is; returns the latter."""
    radius = float(subject.robot.body_radii[0])
    moments = mount_inertia(radius, mounting.length_behind or mounting.radius)
    travel = (mounting.low, mounting.high, mounting.speed)
    if mounting.kind == "slide":
        here = (mounting.start, mounting.R_task_base)
        parts.joint(root, mounting.joint, "task", "mount", *here, slides=Z, limit=travel)
    elif mounting.kind == "turn":
        centre = mounting.start + mounting.radius * mounting.R_task_base[:, 0]
        parts.joint(root, mounting.joint, "task", "drum", centre, mounting.R_task_base, turns=Y, limit=travel)
        drum = parts.link(root, "drum", MOUNT_MASS, moments[[0, 2, 1]])
        parts.cylinder(drum, max(mounting.radius - radius, radius), 2 * radius, parts.NONE, "mount", along_y=True)
        parts.joint(root, "drum_mount", "drum", "mount", (-mounting.radius, 0.0, 0.0))
    else:
        _carrier(root, subject, mounting, moments)
    mount = parts.link(root, "mount", MOUNT_MASS, moments)
    if mounting.length_behind > 0:
        middle = (0.0, 0.0, -mounting.length_behind / 2)
        parts.cylinder(mount, mounting.radius_behind, mounting.length_behind, middle, "mount")
    return mount


def _carrier(root: Element, subject: Subject, mounting: Mounting, moments: Array) -> None:
    """Three axes of the task, and three of the arm, that are zero where the carrier is at feed 0."""
    limits = _limits(subject, mounting)
    axes = [("x", X, True), ("y", Y, True), ("z", Z, True), ("alpha", Y, False), ("beta", X, False), ("roll", Z, False)]
    parent = "task"
    for (name, axis, slides), limit in zip(axes, limits, strict=True):
        child = "mount" if name == "roll" else f"carrier_{name}"
        shift = mounting.start if name == "x" else parts.NONE
        turned = mounting.R_task_base if name == "alpha" else None
        turns, slides_along = (None, axis) if slides else (axis, None)
        parts.joint(root, f"base_{name}", parent, child, shift, turned, turns=turns, slides=slides_along, limit=limit)
        if name != "roll":
            parts.link(root, child, MOUNT_MASS, moments)
        parent = child


def _limits(subject: Subject, mounting: Mounting) -> list[parts.Limit]:
    """Of the six axes."""
    given, robot = None if subject.task is None else subject.task.spec.base, subject.robot.spec
    box = None if given is None else given.workspace
    low = np.full(3, -_ANYWHERE) if box is None else np.array(box.low) - mounting.start
    high = np.full(3, _ANYWHERE) if box is None else np.array(box.high) - mounting.start
    speed = robot.feed.speed if given is None or given.speed is None else given.speed
    turning = None if given is None else given.turn_speed_deg_s
    turning = float(np.radians(robot.limits.joint_speed_deg_s if turning is None else turning))
    sliding: list[parts.Limit] = [(float(a), float(b), speed) for a, b in zip(low, high, strict=True)]
    return [*sliding, *((-most, most, turning) for most in (np.pi, np.pi / 2, np.pi))]
