"""Arms with cables as springs whose sections are of other kinds than links."""

import numpy as np
from mechanics_makers import SPRINGS
from robot_oracles import robot_of
from section_makers import mixed_robot, of_kind

from hognose.mechanics import Mechanics
from hognose.robot import Robot, RobotSpec

EI = "bending_stiffness_N_m2"


def mixed_arm(seed, sections=5, passing=False, **changes):
    """An arm of random kinds: some masses at one place, some sections that bend back, a load and often a tool.

    Cables run on other circles where they pass, if `passing`.
    """
    rng = np.random.default_rng(seed + 1000)
    data = mixed_robot(seed, sections, passing=passing).spec.model_dump(by_alias=True)
    for number, part in enumerate(data["section"]):
        part["link_mass"] = rng.uniform(0.02, 0.2)
        part["centre_of_mass"] = rng.uniform(0.0, part["pitch"]) if number % 2 else None
        if part["kind"] != "link" and rng.random() < 0.6:
            part[EI] = rng.uniform(0.01, 0.3)
    data |= {"cables": {**SPRINGS, "tension_max_N": 2000.0, **changes}, "tool_mass": rng.uniform(0.0, 0.2)}
    return Mechanics.of(Robot.from_spec(RobotSpec.model_validate(data)))


def arm_of(parts, **changes):
    """An arm of sections, with a load `tool_mass` on it if there is one."""
    rest = {key: changes.pop(key) for key in ("tool_mass", "tool_length") if key in changes}
    return Mechanics.of(robot_of(parts, cables={**SPRINGS, "tension_max_N": 2000.0, **changes}, **rest))


def one_arc(**keys):
    """An arc of 0.2 m without a weight; cable 1 at azimuth 0, the others beside the bend α."""
    own = {"disks": None, "pitch": 0.2, "bend_limit_deg": 80.0, "link_mass": 1e-9, EI: 0.05}
    return of_kind("arc", **{**own, "cable_azimuths_deg": (0.0, 120.0, 240.0), **keys})
