"""`python -m benchmarks.cables_of_sections`: the certificates of arms of mixed sections against dense simulations.

Random arms of links, hinges, stacks and arcs, with cables that change their circles, past random obstacles in steps of
3.5 to 60 mm. Joint angles are interpolated, and cables at whole counts.
"""

from __future__ import annotations

import contextlib
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.rows import aside, heading, row
from hognose.planning.certificate import UndeterminedError, cables_motion, certify, certify_cables, interpolated_motion
from hognose.planning.penetration import section_clearance
from hognose.robot import Robot, RobotSpec
from hognose.robot.base import Slider, centre_line, joints_on
from hognose.scene import Box, Scene, Sphere

Array = NDArray[np.float64]

ARMS, DENSE = 200, 60
#: What a certificate may lose (mm) against the dense simulation, in the median.
LOSS = 0.4
#: Clearances beyond this (m) do not count.
HORIZON = 0.08
KINDS = ("link", "hinges", "joints", "arc", "arc with disks")


class Case(NamedTuple):
    """What is certified, and what is seen densely, m; None where nothing is proven."""

    joints: float
    joints_seen: float
    cables: float | None
    cables_seen: float


def random_arm(random: np.random.Generator) -> Robot:
    """An arm of two to seven sections of random kinds, whose cables run on other circles in most that they pass."""
    groups = []
    for k in range(int(random.integers(2, 8))):
        kind, pitch, joints = str(random.choice(KINDS)), random.uniform(0.07, 0.15), int(random.integers(2, 7))
        arc = kind.startswith("arc")
        half = (0.2 / joints if kind == "joints" else 0.1) * pitch
        group: dict[str, Any] = {
            "kind": "arc" if arc else kind,
            "pitch": pitch,
            "half_lengths": None if arc else (0.0, half),
            "body_diameter": 0.04,
            "bend_limit_deg": 60.0,
            "link_mass": 0.1,
            "cable_radius": random.uniform(0.01, 0.018),
            "passing_cable_radius": random.uniform(0.01, 0.018) if random.random() < 0.7 else None,
            "cable_azimuths_deg": (10.0 * k, 120.0 + 10.0 * k, 240.0 + 10.0 * k),
            "transmission": {"screw_lead": 0.004, "gear_ratio": 5.0, "counts_per_turn": 2000},
        }
        if kind == "arc with disks":
            group["disks"] = int(random.integers(6, 13))  # fewer let cables leave the body
        group |= {"joints": {"joints": joints}, "hinges": {"axis_offset": 0.3 * pitch}}.get(kind, {})
        groups.append(group)
    limits: dict[str, Any] = {"joint_speed_deg_s": 10.0, "joint_acceleration_deg_s2": 100.0, "cable_speed": 0.05}
    limits["cable_travel"] = (-0.5, 0.5)
    feed = {"min": 0.0, "max": 1.0, "speed": 0.05}
    whole = {"name": "random", "feed": feed, "limits": limits, "section": tuple(groups)}
    return Robot.from_spec(RobotSpec.model_validate(whole))


def obstacles_beside(random: np.random.Generator, joints: Array) -> Scene:
    """Balls and thin boxes beside the way of an arm, most of them clear of it."""
    items: list[Sphere | Box] = []
    for k in range(4):
        way = random.normal(size=3)
        beside = joints[random.integers(len(joints)), random.integers(1, joints.shape[1])]
        place = tuple(beside + random.uniform(0.06, 0.16) * way / np.linalg.norm(way))
        if k % 2:
            turn = tuple(random.uniform(-180, 180, 3))
            items.append(Box(center=place, size=(0.06, 0.06, random.uniform(1e-4, 0.01)), rotation_deg=turn))
        else:
            items.append(Sphere(center=place, diameter=random.uniform(0.002, 0.04)))
    return Scene.from_obstacles(items, tolerance=1e-3)


def dense(values: Array) -> Array:
    """Values (T, ...) with `DENSE` linear sub-steps in each interval."""
    at = np.linspace(0, len(values) - 1, (len(values) - 1) * DENSE + 1)
    low = np.minimum(at.astype(int), len(values) - 2)
    share = (at - low).reshape(-1, *[1] * (values.ndim - 1))
    return values[low] + share * (values[low + 1] - values[low])


def random_case(seed: int) -> Case:
    """One arm on its way past obstacles."""
    random = np.random.default_rng(seed)
    robot, step, count = random_arm(random), random.uniform(0.0035, 0.06), int(random.integers(2, 8))
    at, shape = np.arange(count, dtype=np.float64)[:, None] * float(step), (1, robot.sections, 2)
    waves = np.sin(random.uniform(0, 6, shape) + random.uniform(2, 12) * at[:, :, None])
    planned = 0.7 * random.uniform(0, 1, shape) * waves
    lengths = robot.lengths_of_counts(robot.motor_counts(robot.cable_lengths(planned)))
    angles, base = robot.angles_from_cables(lengths, planned), Slider(np.zeros(3), 1.0, 0.0, 0.0)
    scene = obstacles_beside(random, joints_on(base, robot, angles, at))

    def seen(angles: Array, at: Array) -> tuple[Array, Array]:
        line = centre_line(base, robot, joints_on(base, robot, angles, at), at)
        return line, section_clearance(scene, robot, line, HORIZON)

    line, clear = seen(angles, at)
    joints = certify(interpolated_motion(robot, base, at, angles), robot, scene, line, clear, HORIZON)
    cables = None
    with contextlib.suppress(UndeterminedError):
        moving = cables_motion(robot, base, at, angles, lengths)
        cables = certify_cables(moving, robot, scene, line, clear, HORIZON)
    between = dense(angles), dense(at)
    pulled = robot.angles_from_cables(dense(lengths), between[0])
    lowest = [float(seen(each, between[1])[1].min()) for each in (between[0], pulled)]
    return Case(joints.clearance, lowest[0], None if cables is None else cables.clearance, lowest[1])


def main() -> None:
    """Print all of it."""
    found = [random_case(seed) for seed in range(ARMS)]
    heading(f"certificates of {ARMS} random arms of mixed sections, steps of 3.5 to 60 mm, and dense simulations")
    for name, pairs in (
        ("joint angles", [(each.joints, each.joints_seen) for each in found]),
        ("cables", [(each.cables, each.cables_seen) for each in found]),
    ):
        proven = [(proof, seen) for proof, seen in pairs if proof is not None]
        clear = 1e3 * np.array([seen - proof for proof, seen in proven if 0 < seen < HORIZON])
        row(f"{name}: certified above the dense simulation", optimistic(proven), 0, "")
        row(f"{name}: certified below it by, median", float(np.median(clear)), LOSS, "mm")
        aside(f"{name}: certified below it by, 95 %", float(np.quantile(clear, 0.95)), "mm")
        aside(f"{name}: certified below it by, largest", float(clear.max()), "mm")
        aside(f"{name}: of so many that are clear and not far away", len(clear), "")
        row(f"{name}: clear, and nothing is proven", sum(p is None and seen > 0 for p, seen in pairs), 0, "")


def optimistic(pairs: list[tuple[float, float]]) -> int:
    """How many are certified with more clearance than is seen."""
    return sum(proof > max(seen, 0.0) + 1e-9 for proof, seen in pairs)


if __name__ == "__main__":
    main()
