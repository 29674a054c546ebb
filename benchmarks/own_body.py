"""`python -m benchmarks.own_body`: how long it takes to certify that a body does not touch itself, and what is missed.

Times are the processor's, on one core, and of both motions between the set-points: angles interpolated, and joints that
glide. What sampled motions show to touch and the certificate does not is a miss.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

import hognose
from benchmarks.planted_arms import arm
from benchmarks.rows import aside, heading, row
from benchmarks.timing import best_times, use_one_core
from hognose.planning.certificate import OwnClearance, certify_own_body, gliding_motion, interpolated_motion
from hognose.robot import Robot
from hognose.robot.base import Base, Slider, angles_on, joints_on
from hognose.robot.own_body import OwnBody, bends_of

Array = NDArray[np.float64]

CASES = ("obstacle-array", "pipe-tank")
#: Links, and the longest time (ms) that both certificates of an insertion of about 310 steps may take.
LIMITS = {12: 1.0, 60: 60.0}
STEPS = 312
#: Times between two steps that are looked at for misses.
BETWEEN = 32


def main(rounds: int = 20, motions: int = 100) -> None:
    """Print all of it."""
    print(use_one_core())
    heading("certificates of the body against itself, both motions, one core")
    for name in CASES:
        plan = hognose.plan(hognose.load_task(name))
        curve, joints = plan.follower.curve, plan.exact_joints
        timed(name, plan.robot, plan.task.base, curve, plan.feed, joints, LIMITS[12], rounds)
    for kind, radius, rise in (("coil, turns 2 diameters apart", 0.2, 0.08), ("coil, turns 1.2 apart", 0.2, 0.048)):
        robot, path = long_arm(), helix(radius, rise)
        feeds = np.linspace(0.0, robot.length, STEPS + 1)
        joints = hognose.follow(path, robot.link_lengths, feeds)
        base = Slider.before(np.zeros(3), robot)
        timed(f"60 links, {kind}", robot, base, path, feeds, joints, LIMITS[60], rounds)
    heading("motions that touch and are certified all the same")
    for kind in ("coil", "loop", "any"):
        touching, missed = misses(kind, motions)
        aside(f"{kind}: motions that touch, of {motions}", touching, "")
        row(f"{kind}: missed", missed, 0, "")


def long_arm() -> Robot:
    """60 links of 50 mm, 40 mm thick."""
    return arm(60, 50.0, 30.0, 40.0)


def helix(radius: float, rise: float) -> hognose.Path:
    """A straight run of 3 m, and turns that rise by so much each."""
    around = np.linspace(0.0, 3.1 / radius, 200)
    x, y, z = radius * (1 - np.cos(around)), rise / (2 * math.pi) * around, radius * np.sin(around)
    return hognose.Path.through(np.column_stack([x, y, z]), 3, (0.0, 0.0, 1.0)).with_run(3.0)


def timed(
    what: str, robot: Robot, base: Base, curve: hognose.Path, feeds: Array, joints: Array, limit: float, rounds: int
) -> None:
    """A row of the time (ms) of both certificates, and what they prove."""
    at = base.coordinates(feeds, joints)
    angles = angles_on(base, robot, joints, at)
    body = joints_on(base, robot, angles, at)
    linear, on_path = interpolated_motion(robot, base, at, angles), gliding_motion(curve, robot, feeds)
    assert on_path is not None
    calls: dict[str, Callable[[], OwnClearance]] = {
        "interpolated": lambda: certify_own_body(linear, robot, body, bends_of(angles)),
        "along the path": lambda: certify_own_body(on_path, robot, joints),
        "without bends": lambda: certify_own_body(linear, robot, body),
    }
    times = best_times({**calls}, rounds, time.process_time)
    row(f"{what}: both, {len(feeds) - 1} steps", 1e3 * (times["interpolated"] + times["along the path"]), limit, "ms")
    for name, seconds in times.items():
        aside(f"{what}: {name}", 1e3 * seconds, "ms")
    for name in ("interpolated", "along the path"):
        found = calls[name]()
        where = f"links {found.links[0] + 1} and {found.links[1] + 1}, step {found.step}"
        aside(f"  {name}: {where if found.step is not None else 'nowhere closer'}", 1e3 * found.clearance, "mm")
        aside(f"  {name}: configurations added", found.halvings, "")


def misses(kind: str, count: int) -> tuple[int, int]:
    """How many of random motions touch at sampled times, and how many of those are certified."""
    touching = missed = 0
    for seed in range(count):
        random = np.random.default_rng(seed)
        sections = int(random.integers(6, 25))
        robot = arm(sections, 90.0, 60.0, float(random.uniform(20.0, 70.0)))
        angles = shape(kind, sections, random) + np.cumsum(random.normal(0.0, 0.05, (6, sections, 2)), axis=0)
        at, base = np.zeros((6, 1)), Slider.before(np.zeros(3), robot)
        bodies = joints_on(base, robot, angles, at)
        found = certify_own_body(interpolated_motion(robot, base, at, angles), robot, bodies, bends_of(angles))
        share = np.linspace(0.0, 1.0, BETWEEN + 1)[:, None, None, None]
        between = (angles[:-1] + share * (angles[1:] - angles[:-1])).reshape(-1, sections, 2)
        dense = OwnBody.of(robot).closest(robot.joint_positions(between))[0].min()
        touching += dense <= 0
        missed += found.clearance > max(dense, 0.0)
    return touching, missed


def shape(kind: str, sections: int, random: np.random.Generator) -> Array:
    """Angles (n, 2) rad of an arm that lies close to itself, or may."""
    if kind == "coil":
        return np.tile([random.uniform(0.3, 0.9), random.uniform(-0.15, 0.15)], (sections, 1))
    if kind == "loop":
        turn = random.uniform(0.8, 1.3) * 2 * math.pi / sections
        return np.column_stack([np.full(sections, turn), random.normal(0.0, 0.05, sections)])
    return random.normal(0.0, 0.5, (sections, 2))


if __name__ == "__main__":
    main()
