"""Cables in a MuJoCo model: their holes as sites, themselves as spatial tendons, and as springs that pull."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.files.exports.jointed_arm import JointedArm
from hognose.files.exports.rigid_parts import Part
from hognose.files.exports.xml import Element, element
from hognose.planning.columns import LABELS
from hognose.planning.plan import Plan
from hognose.robot import Robot
from hognose.robot.backbone import bending_springs

Array = NDArray[np.float64]

#: MuJoCo takes 1 s to read 10,000 holes, and 40 s for 40,000; cables of more are left out.
MOST_HOLES = 20_000
#: [assumed] What a cable resists with as it is stretched, N s/m.
DAMPING = 30.0
#: The letter of holes in which cables go on behind a step to another circle.
_STEP = "c"
#: Drives of lengths give way to all cables that pass a section at their greatest tensions by this share of its pitch.
GIVES = 1e-4


def shown(arm: JointedArm) -> bool:
    """Whether the model has the cables: not if they have too many holes."""
    return _holes(arm) <= MOST_HOLES


def pull(arm: JointedArm) -> bool:
    """Whether the cables of the model are springs."""
    return shown(arm) and arm.robot.spec.cables is not None


def holes(body: Element, arm: JointedArm, part: Part) -> None:
    """Sites for all cables in the disks of a part of the arm."""
    robot, steps = arm.robot, arm.steps_of(part)
    for plane, height in part.planes:
        for cable, name in enumerate(LABELS["cable"](robot)):
            if robot.cable_sections[cable] >= part.section:
                _hole(body, robot, cable, part.section + 1, _site(name, part, plane), height)
    for cable, name in enumerate(LABELS["cable"](robot)):
        if steps[cable]:
            _hole(body, robot, cable, part.section + 2, _site(name, part, _STEP), part.planes[-1][1])


def _hole(body: Element, robot: Robot, cable: int, circle: int, name: str, height: float) -> None:
    radius, azimuth = robot.cable_circles[cable, circle], robot.cable_azimuths[cable]
    element(body, "site", name=name, pos=(radius * np.cos(azimuth), radius * np.sin(azimuth), height))


def tendons(root: Element, arm: JointedArm) -> Element:
    """A spatial tendon for every cable; returns the element that they are in."""
    inside, robot = element(root, "tendon"), arm.robot
    for cable, name in enumerate(LABELS["cable"](robot)):
        tendon = element(inside, "spatial", name=f"cable_{name}", class_="cable")
        for part in arm.parts:
            if part.section <= robot.cable_sections[cable]:
                for plane, _ in part.planes:
                    element(tendon, "site", site=_site(name, part, plane))
            if arm.steps_of(part)[cable]:  # behind a pulley it goes on at another place
                element(tendon, "pulley", divisor="1")
                element(tendon, "site", site=_site(name, part, _STEP))
    return inside


def springs(actuators: Element, robot: Robot) -> None:
    """An actuator for every cable, whose control is how far (m) it is paid out from the pretensioned straight arm."""
    given = robot.spec.cables
    assert given is not None, "only called where there are springs"
    stiffness, slack = _stiffness(robot), _slack_lengths(robot)
    for cable, name in enumerate(LABELS["cable"](robot)):
        k = float(stiffness[cable])
        element(
            actuators,
            "general",
            name=f"cable_{name}",
            tendon=f"cable_{name}",
            ctrlrange=robot.spec.limits.cable_travel,
            forcerange=(-given.tension_max_N, 0.0),
            gainprm=k,
            biastype="affine",
            biasprm=(k * slack[cable], -k, -DAMPING),
        )


def paid_out(plan: Plan, arm: JointedArm) -> Array:
    """How far (T, c) m the cables are paid out at each step, so that they hold the arm with the plan's tensions."""
    robot = plan.robot
    tensions = _pretension(robot) if plan.held is None else plan.held.tensions
    # Where arcs are chains, those of the model are what is to be stretched: a spring feels hundredths of a millimetre.
    lengths = arm.cable_lengths(plan.angles, plan.section_lengths) if arm.cables_off else plan.cable_lengths
    return lengths - tensions / _stiffness(robot) - _slack_lengths(robot)


def remarks(arm: JointedArm) -> list[str]:
    """What a person should know of the cables, in sentences."""
    robot = arm.robot
    stays = "so that the arm stays as it is set" if not bending_springs(robot).any() else "but its rods spring back"
    if not shown(arm):
        return [
            f"the cables are left out, as MuJoCo takes minutes to read their {_holes(arm):,} holes; gravity is off, "
            + stays
        ]
    if robot.spec.cables is None:
        return [
            "the robot file has no [cables], so the cables here show their lengths but do not pull; gravity is off, "
            + stays
        ]
    told = [
        "the cables pull as springs from the robot's [cables]; an actuator's control is how far (m) its cable is paid "
        "out from that of the straight, pretensioned arm"
    ]
    if robot.extends:
        told.append(
            "a drive holds the length of each section that extends against its cables, and its control is how much "
            "longer (m) the section is to be than at rest; it gives way to all cables at their greatest tensions by "
            f"{GIVES:.2%} of the pitch"
        )
    return told


def _holes(arm: JointedArm) -> int:
    passing = [np.count_nonzero(arm.robot.cable_sections >= part.section) * len(part.planes) for part in arm.parts]
    return int(sum(passing))


def _slack_lengths(robot: Robot) -> Array:
    """Lengths (c,) m without tension of the cables of the straight, pretensioned arm."""
    return robot.straight_cable_lengths - _pretension(robot) / _stiffness(robot)


def _pretension(robot: Robot) -> Array:
    """Of every cable (c,) N."""
    given = robot.spec.cables
    assert given is not None, "only called where there are springs"
    return given.for_cables("pretension_N", robot.cable_sections)


def _site(cable: str, part: Part, plane: str) -> str:
    return f"cable_{cable}_link_{part.label}_{plane}"


def _stiffness(robot: Robot) -> Array:
    """Of every cable (c,) N/m, over its length in the straight arm and behind the base."""
    given = robot.spec.cables
    assert given is not None, "only called where there are springs"
    lengths = robot.straight_cable_lengths + given.free_length
    return given.for_cables("axial_stiffness_N", robot.cable_sections) / lengths
