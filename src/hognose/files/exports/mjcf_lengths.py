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

#: [assumed] A drive's damping by its stiffness, s: as that of the slider's.
_TIME = 0.01
#: [assumed] The inertia that a section's drive adds, in masses of the arm. As it is far more than what a slide carries,
#: slides that are pressed alike move alike, and constraints have nothing to hold them together against.
_ARMATURE = 10.0
#: [assumed] How long (s) this inertia goes on without a drive.
_SLOWED = 0.1


def slide(body: Element, arm: JointedArm, joint: Joint) -> None:
    """A slide of an arc that extends."""
    armature = _ARMATURE * float(arm.robot.link_masses.sum() + arm.robot.tool_mass) / joint.share
    element(body, "joint", name=joint.name, type="slide", axis="0 0 1", range=arm.bounds(joint),
            damping=armature / _SLOWED, armature=armature)  # fmt: skip


def tendons(inside: Element, arm: JointedArm) -> None:
    """A fixed tendon for each section that extends: how much longer it is than at rest."""
    for section, name in _named(arm.robot):
        tendon = element(inside, "fixed", name=name)
        for joint in arm.slides(section):
            element(tendon, "joint", joint=joint.name, coef="1")


def drives(actuators: Element, robot: Robot) -> None:
    """An actuator for each section that extends, whose control is how much longer (m) it is to be than at rest."""
    given = robot.spec.cables
    assert given is not None, "only called where there are springs"
    for section, name in _named(robot):
        pressing = given.tension_max_N * np.count_nonzero(robot.cable_sections >= section)
        stiffness = pressing / (GIVES * float(robot.link_lengths[section]))
        element(actuators, "position", name=name, tendon=name, kp=stiffness, kv=_TIME * stiffness,
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
