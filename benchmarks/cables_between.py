"""Between set-points drives interpolate cables, not angles: how much that matters, and what of it is certified.

`python -m benchmarks.cables_between` prints, for both cases of the paper, how far the body leaves linear angles, the
bound of that, what rounding to counts does, and both certified clearances; then the same for 200 random arms with steps
of 3.5 to 90 mm among random obstacles, where the certificate is held against a dense simulation.
"""

from __future__ import annotations

import contextlib

import numpy as np
from numpy.typing import NDArray

import hognose
from benchmarks.rows import aside, heading, row
from benchmarks.timing import best_times
from hognose.planning.certificate import UndeterminedError, cables_motion, certify_cables
from hognose.planning.certificate.cable_motion import deviations
from hognose.planning.checks import Shared
from hognose.robot import Robot, RobotSpec
from hognose.robot.base import Slider
from hognose.scene import Box, Scene, Sphere

Array = NDArray[np.float64]

CASES = ("obstacle-array", "pipe-tank")
ARMS, DENSE = 200, 100
#: What interpolated cables may cost (mm) in comparison with interpolated angles.
LOST = 0.01
#: Clearances beyond this (m) do not count.
HORIZON = 0.05


def case(name: str) -> None:
    """Rows of one case of the paper."""
    task = hognose.load_task(name)
    plan = hognose.plan(task)
    shared = Shared(plan, plan.clearance)
    angles, lengths = shared.counted_angles, shared.counted_lengths
    off = deviations(plan.robot, angles[:-1], angles[1:], lengths[:-1], lengths[1:])
    bound = np.cumsum(np.cumsum(off, axis=1) * plan.robot.link_lengths, axis=1).max()
    joints, cables = shared.interpolated, shared.cables_interpolated
    assert cables is not None
    aside(f"{name}: cables leave linear angles by", 1e3 * beside(plan.robot, plan.feed, angles, lengths), "mm")
    aside(f"{name}: bound of that", 1e3 * bound, "mm")
    aside(f"{name}: rounding to counts moves the body by", 1e3 * shared.rounding.max(), "mm")
    aside(f"{name}: certified, joint angles interpolated", 1e3 * joints.clearance, "mm")
    aside(f"{name}: certified, cables interpolated", 1e3 * cables.clearance, "mm")
    row(f"{name}: lost by cables", 1e3 * (joints.clearance - cables.clearance), LOST, "mm")
    alone = best_times({"cables": lambda: Shared(plan, plan.clearance).cables_interpolated}, 20)["cables"]
    aside(f"{name}: the certificate of cables alone", 1e3 * alone, "ms")


def dense(values: Array) -> Array:
    """Values (T, ...) with `DENSE` linear sub-steps in each interval."""
    at = np.linspace(0, len(values) - 1, (len(values) - 1) * DENSE + 1)
    low = np.minimum(at.astype(int), len(values) - 2)
    share = (at - low).reshape(-1, *[1] * (values.ndim - 1))
    return values[low] + share * (values[low + 1] - values[low])


def beside(robot: Robot, feeds: Array, angles: Array, lengths: Array) -> float:
    """How far (m) joints leave linear angles between the steps, seen densely."""
    near, at = dense(angles), dense(feeds)
    found = robot.angles_from_cables(dense(lengths), near)
    return float(np.linalg.norm(robot.joint_positions(found, at) - robot.joint_positions(near, at), axis=2).max())


def random_arm(random: np.random.Generator) -> Robot:
    """An arm of one to eight sections, with cables all round."""
    sections, groups = int(random.integers(1, 9)), []
    for k in range(sections):
        pitch = random.uniform(0.06, 0.15)
        groups.append(
            {
                "pitch": pitch,
                "half_lengths": [0.12 * pitch, 0.12 * pitch],
                "body_diameter": 0.04,
                "bend_limit_deg": 45.0,
                "link_mass": 0.1,
                "cable_radius": 0.012,
                "cable_azimuths_deg": [10.0 * k, 120.0 + 10.0 * k, 240.0 + 10.0 * k],
                "transmission": {"screw_lead": 0.004, "gear_ratio": 5.0, "counts_per_turn": 2000},
            }
        )
    limits = {"joint_speed_deg_s": 10.0, "joint_acceleration_deg_s2": 100.0, "cable_speed": 0.05}
    return Robot.from_spec(
        RobotSpec.model_validate(
            {
                "name": "random",
                "feed": {"min": 0.0, "max": 1.0, "speed": 0.05},
                "limits": {**limits, "cable_travel": [-0.2, 0.2]},
                "section": groups,
            }
        )
    )


def random_scene(random: np.random.Generator) -> Scene:
    """Balls and thin boxes."""
    items: list[Sphere | Box] = []
    for k in range(4):
        place = tuple(random.uniform(-0.3, 0.5, 3))
        turn = tuple(random.uniform(-180, 180, 3))
        if k % 2:
            items.append(Box(center=place, size=(0.2, 0.2, random.uniform(1e-4, 0.01)), rotation_deg=turn))
        else:
            items.append(Sphere(center=place, diameter=random.uniform(0.002, 0.05)))
    return Scene.from_obstacles(items, tolerance=1e-3)


def random_case(seed: int) -> tuple[float, float | None, float]:
    """How far joints leave linear angles, what is certified (None if nothing), and what is seen densely, m."""
    random = np.random.default_rng(seed)
    robot, step, count = random_arm(random), random.uniform(0.0035, 0.09), int(random.integers(2, 8))
    feeds, shape = np.arange(count, dtype=np.float64) * float(step), (1, robot.sections, 2)
    waves = np.sin(random.uniform(0, 6, shape) + random.uniform(2, 12) * feeds[:, None, None])
    angles = 0.55 * random.uniform(0, 1, shape) * waves
    lengths = robot.lengths_of_counts(robot.motor_counts(robot.cable_lengths(angles)))
    angles, scene = robot.angles_from_cables(lengths, angles), random_scene(random)
    base, body = Slider(np.zeros(3), 1.0, 0.0, 0.0), robot.joint_positions(angles, feeds)

    def clearance(joints: Array) -> Array:
        return scene.clearance(joints[:, :-1], joints[:, 1:], robot.body_radii, HORIZON).value

    proof = None
    with contextlib.suppress(UndeterminedError):
        moving = cables_motion(robot, base, feeds[:, None], angles, lengths)
        proof = certify_cables(moving, robot, scene, body, clearance(body), HORIZON)
    moved = robot.joint_positions(robot.angles_from_cables(dense(lengths), dense(angles)), dense(feeds))
    seen = min(HORIZON, float(clearance(moved).min()))
    return beside(robot, feeds, angles, lengths), None if proof is None else proof.clearance, seen


def main() -> None:
    """Print all of it."""
    heading("cables that are interpolated between set-points 3.5 mm apart")
    for name in CASES:
        case(name)
    heading(f"the same of {ARMS} random arms, steps of 3.5 to 90 mm, and a dense simulation")
    found = [random_case(seed) for seed in range(ARMS)]
    off = 1e3 * np.array([each[0] for each in found])
    proven = [(proof, seen) for _, proof, seen in found if proof is not None]
    aside("linear angles are left by, median", float(np.median(off)), "mm")
    aside("linear angles are left by, largest", float(off.max()), "mm")
    row("certified above the dense simulation", sum(proof > max(seen, 0.0) + 1e-12 for proof, seen in proven), 0, "")
    aside("certified below it by, largest", 1e3 * max(seen - proof for proof, seen in proven if seen > 0), "mm")
    aside("clear in the dense simulation", sum(seen > 0 for _, _, seen in found), "")
    row("of these, nothing is proven", sum(proof is None and seen > 0 for _, proof, seen in found), 0, "")


if __name__ == "__main__":
    main()
