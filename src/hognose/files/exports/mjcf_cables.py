"""Cables in a MuJoCo model: their holes as sites, themselves as spatial tendons, and as springs that pull."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.files.exports.xml import Element, element
from hognose.planning.columns import LABELS
from hognose.planning.plan import Plan
from hognose.robot import Robot

Array = NDArray[np.float64]

#: MuJoCo takes 1 s to read 10,000 holes, and 40 s for 40,000; cables of more are left out.
MOST_HOLES = 20_000
#: [assumed] What a cable resists with as it is stretched, N s/m.
DAMPING = 30.0


def shown(robot: Robot) -> bool:
    """Whether the model has the cables: not if they have too many holes."""
    return _holes(robot) <= MOST_HOLES


def pull(robot: Robot) -> bool:
    """Whether the cables of the model are springs."""
    return shown(robot) and robot.spec.cables is not None


def holes(body: Element, robot: Robot, link: int) -> None:
    """Sites for all cables in the disks of a link (from 1), or of the mount (0)."""
    for plane, height in _planes(robot, link).items():
        for cable, name in enumerate(LABELS["cable"](robot)):
            if robot.cable_sections[cable] < link - 1:
                continue
            radius, azimuth = robot.cable_circles[cable, link], robot.cable_azimuths[cable]
            place = (radius * np.cos(azimuth), radius * np.sin(azimuth), height)
            element(body, "site", name=_site(name, link, plane), pos=place)


def tendons(root: Element, robot: Robot) -> None:
    """A spatial tendon for every cable."""
    inside = element(root, "tendon")
    for cable, name in enumerate(LABELS["cable"](robot)):
        tendon = element(inside, "spatial", name=f"cable_{name}", class_="cable")
        for link in range(int(robot.cable_sections[cable]) + 2):
            for plane in _planes(robot, link):
                element(tendon, "site", site=_site(name, link, plane))


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


def paid_out(plan: Plan) -> Array:
    """How far (T, c) m the cables are paid out at each step, so that they hold the arm with the plan's tensions."""
    robot = plan.robot
    tensions = _pretension(robot) if plan.held is None else plan.held.tensions
    return plan.cable_lengths - tensions / _stiffness(robot) - _slack_lengths(robot)


def remarks(robot: Robot) -> list[str]:
    """What a person should know of the cables, in sentences."""
    if not shown(robot):
        return [
            f"the cables are left out, as MuJoCo takes minutes to read their {_holes(robot):,} holes; gravity is off, "
            "so that the arm stays as it is set"
        ]
    if robot.spec.cables is None:
        return [
            "the robot file has no [cables], so the cables here show their lengths but do not pull; gravity is off, "
            "so that the arm stays as it is set"
        ]
    return [
        "the cables pull as springs from the robot's [cables]; an actuator's control is how far (m) its cable is paid "
        "out from that of the straight, pretensioned arm"
    ]


def _holes(robot: Robot) -> int:
    return int((2 * robot.cable_sections + 3).sum())


def _planes(robot: Robot, link: int) -> dict[str, float]:
    """Heights (m) of the hole planes, a and b, in the frame of a link (from 1), or of the mount (0)."""
    if link == 0:
        return {"b": -float(robot.joint_before[0])}
    i = link - 1
    return {"a": float(robot.joint_after[i]), "b": float(robot.pitches[i] - robot.disk_before_end[i])}


def _slack_lengths(robot: Robot) -> Array:
    """Lengths (c,) m without tension of the cables of the straight, pretensioned arm."""
    return robot.straight_cable_lengths - _pretension(robot) / _stiffness(robot)


def _pretension(robot: Robot) -> Array:
    """Of every cable (c,) N."""
    given = robot.spec.cables
    assert given is not None, "only called where there are springs"
    return given.for_cables("pretension_N", robot.cable_sections)


def _site(cable: str, link: int, plane: str) -> str:
    return f"cable_{cable}_link_{link:02d}_{plane}"


def _stiffness(robot: Robot) -> Array:
    """Of every cable (c,) N/m, over its length in the straight arm and behind the base."""
    given = robot.spec.cables
    assert given is not None, "only called where there are springs"
    lengths = robot.straight_cable_lengths + given.free_length
    return given.for_cables("axial_stiffness_N", robot.cable_sections) / lengths
