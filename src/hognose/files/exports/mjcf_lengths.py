"""Lengths of sections that extend in a MuJoCo model: their slides, and drives that hold them against the cables.

Cables press on all slides of a section alike, with up to some hundred newtons. A drive at the first slide alone would
have to hold that times twice their number, and the equality constraints, which are springs in MuJoCo, would give way by
more than the section is long. So a fixed tendon is the sum of a section's slides, what it is longer than at rest, and
its drive presses back on all of them alike; only weights are left to the constraints.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hognose.files.exports.jointed_arm import JointedArm
from hognose.files.exports.mjcf_cables import GIVES
from hognose.files.exports.rigid_parts import Joint
from hognose.files.exports.xml import Element, element
from hognose.planning.columns import LABELS
from hognose.planning.plan import Plan
from hognose.robot import Robot

Array = NDArray[np.float64]

#: [assumed] How long (s) a drive takes to where it is to be, with critical damping. That is some steps of MuJoCo, which
#: does not integrate springs implicitly: what a drive moves is as heavy as this takes, far more than what slides carry,
#: so that slides that are pressed alike move alike, and constraints have nothing to hold them together against.
_TIME = 0.01
#: Of MuJoCo's solver, whose measure is the mean inertia: with that of drives, 1e-8 would be too little for hinges.
TOLERANCE = 1e-16
#: [assumed] The inertia that slides have without drives, in masses of the arm, and how long (s) it goes on.
_ARMATURE, _SLOWED = 10.0, 0.1


def slide(body: Element, arm: JointedArm, joint: Joint) -> None:
    """A slide of an arc that extends."""
    robot = arm.robot
    if robot.spec.cables is None:
        armature = _ARMATURE * float(robot.link_masses.sum() + robot.tool_mass)
        damping = armature / _SLOWED
    else:
        armature, damping = _TIME**2 * _stiffness(robot, joint.section), 0.0
    element(body, "joint", name=joint.name, type="slide", axis="0 0 1", range=arm.bounds(joint),
            damping=damping / joint.share, armature=armature / joint.share)  # fmt: skip


def tendons(inside: Element, arm: JointedArm) -> None:
    """A fixed tendon for each section that extends: how much longer it is than at rest."""
    for section, name in _named(arm.robot):
        tendon = element(inside, "fixed", name=name)
        for joint in arm.slides(section):
            element(tendon, "joint", joint=joint.name, coef="1")


def drives(actuators: Element, robot: Robot) -> None:
    """An actuator for each section that extends, whose control is how much longer (m) it is to be than at rest."""
    for section, name in _named(robot):
        stiffness = _stiffness(robot, section)
        element(actuators, "position", name=name, tendon=name, kp=stiffness, kv=2 * _TIME * stiffness,
                ctrlrange=robot.length_bounds[section] - robot.link_lengths[section])  # fmt: skip


def longer(plan: Plan) -> Array:
    """How much longer (T, e) m the sections that extend are than at rest, at each step of a plan."""
    extending = plan.robot.extending
    return plan.section_lengths[:, extending] - plan.robot.link_lengths[extending]


def _named(robot: Robot) -> Iterator[tuple[int, str]]:
    """Sections (0-based) that extend, and what their lengths are called."""
    labels = LABELS["extending section"](robot)
    for section, label in zip(np.flatnonzero(robot.extending).tolist(), labels, strict=True):
        yield section, f"length_{label}"


def _stiffness(robot: Robot, section: int) -> float:
    """Of a section's drive, N/m."""
    given = robot.spec.cables
    assert given is not None, "only called where there are springs"
    pressing = given.tension_max_N * np.count_nonzero(robot.cable_sections >= section)
    return float(pressing / (GIVES * robot.link_lengths[section]))
