"""Arms with cables as springs, and slow second opinions on their mechanics."""

import numpy as np
from robot_oracles import frames, robot_of, section, tapered_robot

from hognose.mechanics import Mechanics
from hognose.robot import Robot, RobotSpec

SPRINGS = {
    "axial_stiffness_N": 100e3,
    "free_length": 0.3,
    "pretension_N": 40.0,
    "tension_min_N": 10.0,
    "tension_max_N": 195.0,
}
DOWN = np.array([0.0, -9.80665, 0.0])


def paper_arm(sections=12, **changes):
    """The arm of the paper, with other springs where they are given."""
    parts = [section(count=sections, cable_azimuth_step_deg=-10.0)]
    tool = {key: changes.pop(key) for key in ("tool_mass", "tool_length") if key in changes}
    feed = {"min": 0.0, "max": 0.091 * sections + 0.01, "speed": 0.05}
    return Mechanics.of(robot_of(parts, cables={**SPRINGS, **changes}, feed=feed, **tool))


def random_arm(seed, sections=6, passing=False, **changes):
    """An arm whose sections differ in everything, with a load on the tip and other stiffnesses by section.

    Cables run on other circles where they pass, if `passing`.
    """
    rng = np.random.default_rng(seed)
    data = tapered_robot(seed, sections, passing).spec.model_dump(by_alias=True)
    for part in data["section"]:
        part["link_mass"] = rng.uniform(0.02, 0.2)
        part["centre_of_mass"] = rng.uniform(0.0, part["pitch"])
    stiff = tuple(rng.uniform(50e3, 150e3, sections))
    data |= {"cables": {**SPRINGS, "axial_stiffness_N": stiff, **changes}, "tool_mass": rng.uniform(0, 0.2)}
    return Mechanics.of(Robot.from_spec(RobotSpec.model_validate(data)))


def poses(mechanics, rng, count, share=1.0):
    """Angles (count, n, 2) up to a share of the limits."""
    limits = mechanics.robot.bend_limits
    return rng.uniform(-share, share, (count, *limits.shape)) * limits


def slopes(function, angles, h=1e-5):
    """Derivatives (T, ..., 2n) of a function of angles (T, n, 2), by central differences of the fourth order."""
    columns = []
    for i in range(angles.shape[1]):
        for axis in (0, 1):
            shift = np.zeros(angles.shape[1:])
            shift[i, axis] = h
            near = function(angles + shift) - function(angles - shift)
            far = function(angles + 2 * shift) - function(angles - 2 * shift)
            columns.append((8 * near - far) / (12 * h))
    return np.stack(columns, axis=-1)


def energy_of_weight(mechanics, angles, gravity):
    """U = -sum of m g·p (J) in one pose (n, 2), link by link."""
    places, turns = frames(mechanics.robot, angles)
    total = -mechanics.tool_mass * gravity @ places[-1]
    for (_, mass, centre), place, turn in zip(mechanics.links, places[:-1], turns, strict=True):
        total -= mass * gravity @ (place + centre * turn[:, 2])
    return total


def length_derivatives(robot, angles):
    """Jacobian (c, n, 2) and Hessian (c, n, 2, 2) of the cable lengths in one pose, by vectors between the holes."""
    alpha, beta = angles[:, 0], angles[:, 1]
    ca, sa, cb, sb, zero = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta), np.zeros(len(angles))
    R = np.array([[ca, sa * sb, sa * cb], [zero, cb, -sb], [-sa, ca * sb, ca * cb]])
    Ra = np.array([[-sa, ca * sb, ca * cb], [zero, zero, zero], [-ca, -sa * sb, -sa * cb]])
    Rb = np.array([[zero, sa * cb, -sa * sb], [zero, -sb, -cb], [zero, ca * cb, -ca * sb]])
    Raa = np.array([[-ca, -sa * sb, -sa * cb], [zero, zero, zero], [sa, -ca * sb, -ca * cb]])
    Rbb = np.array([[zero, -sa * sb, -sa * cb], [zero, -cb, sb], [zero, -ca * sb, -ca * cb]])
    Rab = np.array([[zero, ca * cb, -ca * sb], [zero, zero, zero], [zero, -sa * cb, sa * sb]])
    off = robot.cable_radii * np.array([np.cos(robot.cable_azimuths), np.sin(robot.cable_azimuths)])  # (2, c)
    count, joints = robot.cables, robot.sections
    behind = np.concatenate([np.repeat(off[:, None], joints, 1), np.repeat(robot.joint_after[None, :, None], count, 2)])
    start = np.concatenate(
        [np.repeat(off[:, None], joints, 1), -np.repeat(robot.joint_before[None, :, None], count, 2)]
    )
    d = np.einsum("xyj,yjc->xjc", R, behind) - start
    da, db, daa, dbb, dab = (np.einsum("xyj,yjc->xjc", each, behind) for each in (Ra, Rb, Raa, Rbb, Rab))
    length = np.linalg.norm(d, axis=0)

    def first(u):
        return (d * u).sum(axis=0) / length

    def second(u, v, w):
        return ((u * v).sum(axis=0) + (d * w).sum(axis=0) - first(u) * first(v)) / length

    J = np.stack([first(da), first(db)], axis=-1)  # (n, c, 2)
    rows = [[second(da, da, daa), second(da, db, dab)], [second(da, db, dab), second(db, db, dbb)]]
    H = np.moveaxis(np.array(rows), (0, 1), (2, 3))
    passes = (np.arange(joints)[:, None] <= robot.cable_sections)[..., None]
    return np.swapaxes(J * passes, 0, 1), np.swapaxes(H * passes[..., None], 0, 1)
