"""`python -m benchmarks.mechanics`: how exact the mechanics of the arm are, and how long they take."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

import hognose
from benchmarks import mechanics_on_mujoco
from benchmarks.rows import aside, heading, row
from benchmarks.timing import best_times, use_one_core
from hognose.mechanics import Mechanics
from hognose.mechanics.tensions import distribute
from hognose.planning import Plan, Task
from hognose.robot import Robot, RobotSpec

Array = NDArray[np.float64]

CASES = ("obstacle-array", "pipe-tank")
DOWN = np.array([0.0, -9.80665, 0.0])
#: Largest errors against finite differences (m, N m, and per rad); µs for the tensions of a step; s for a plan; how
#: many times as long planning may take as without mechanics.
ERROR, QP, PLAN, RATIO = 1e-9, 40.0, 0.15, 2.0


def main(rounds: int = 20) -> None:
    """Print all of it."""
    arm = arm_of(hognose.load_robot("sjtu-25dof"))
    angles = np.random.default_rng(0).uniform(-1, 1, (20, arm.robot.sections, 2)) * arm.robot.bend_limits
    heading("against finite differences, 20 random poses up to the bend limits")
    errors(arm, angles)
    heading(f"time, {use_one_core()}")
    for name in CASES:
        times(name, arm, hognose.plan(hognose.load_task(name)), rounds)
        planning(name, rounds // 2)
    long = arm_of(hognose.load_robot("sjtu-25dof"), 30)
    straight = np.zeros((312, 30, 2))
    spent = best_times({"hold": lambda: long.hold(straight, DOWN)}, 3, time.process_time)["hold"]
    aside("30 sections, 312 steps", spent, "s")
    heading("straight arm: pretension at which it buckles, and sag at the tip without compensation")
    for stiffness in (25e3, 50e3, 100e3):
        buckling(arm, stiffness)
    mechanics_on_mujoco.main()


def arm_of(robot: Robot, sections: int = 12) -> Mechanics:
    """The mechanics of a bundled robot with so many sections."""
    spec = robot.spec.model_dump(by_alias=True)
    spec["section"] = [spec["section"][0] | {"count": sections}]
    return Mechanics.of(Robot.from_spec(RobotSpec.model_validate(spec)))


def errors(arm: Mechanics, angles: Array) -> None:
    """How far derivatives are from differences of what they are derivatives of."""
    n = arm.robot.sections
    J, H = arm.cable_jacobian(angles), arm.cable_hessian(angles)
    whole = np.zeros((*H.shape[:2], n, 2, n, 2))
    for j in range(n):
        whole[:, :, j, :, j, :] = H[:, :, j]
    row("Jacobian of the cable lengths", off(J, arm.robot.cable_lengths, angles), ERROR, "m/rad")
    row("its derivative", off(whole.reshape(*J.shape, 2 * n), arm.cable_jacobian, angles), ERROR, "m/rad²")
    row(
        "torque of the weight",
        off(arm.gravity_torque(angles, DOWN), lambda poses: weight(arm, poses), angles),
        ERROR,
        "N m",
    )
    row(
        "its derivative",
        off(arm.gravity_stiffness(angles, DOWN), lambda poses: arm.gravity_torque(poses, DOWN), angles),
        ERROR,
        "N m/rad",
    )
    held = arm.hold(0.3 * angles, DOWN)
    back = arm.settle(0.3 * angles, held.commanded_lengths, DOWN, 0.3 * angles + 0.01)
    row("pose in which compensated lengths come to rest", np.abs(back.angles - 0.3 * angles).max(), ERROR, "rad")


def weight(arm: Mechanics, angles: Array) -> Array:
    """Potential energy (T,) J of links and tool."""
    joints = arm.robot.joint_positions(angles)
    lengths, masses, centres = arm.links.T
    along = np.diff(joints, axis=1) / lengths[:, None]
    places = joints[:, :-1] + centres[:, None] * along
    return -(places @ DOWN) @ masses - arm.tool_mass * joints[:, -1] @ DOWN


def off(found: Array, function: Callable[[Array], Array], angles: Array, h: float = 1e-3) -> float:
    """The largest difference of derivatives (T, …, 2n) from central differences of the fourth order."""
    worst = 0.0
    for column in range(found.shape[-1]):
        shift = np.zeros(angles.shape[1:])
        shift[divmod(column, 2)] = h
        near = function(angles + shift) - function(angles - shift)
        far = function(angles + 2 * shift) - function(angles - 2 * shift)
        worst = max(worst, float(np.abs((8 * near - far) / (12 * h) - found[..., column]).max()))
    return worst


def times(name: str, arm: Mechanics, plan: Plan, rounds: int) -> None:
    """How long the mechanics of a plan take."""
    angles, steps, robot = plan.angles, len(plan.time), arm.robot
    torques, J = arm.gravity_torque(angles, DOWN), arm.cable_jacobian(angles)
    low, high = np.full(robot.cables, arm.tension_min), np.full(robot.cables, arm.tension_max)
    spent = best_times(
        {
            "hold": lambda: arm.hold(angles, DOWN),
            "tensions": lambda: distribute(J, torques, robot.cable_sections, arm.pretension, low, high),
        },
        rounds,
        time.process_time,
    )
    row(f"{name}: tensions of a step", 1e6 * spent["tensions"] / steps, QP, "µs")
    row(f"{name}: mechanics of {steps} steps", spent["hold"], PLAN, "s")
    begin = time.process_time()
    arm.uncompensated(angles, DOWN)
    aside(f"{name}: statics without compensation, {steps} steps", time.process_time() - begin, "s")


def planning(name: str, rounds: int) -> None:
    """How much longer planning takes with mechanics than without, taken in turn."""
    task = hognose.load_task(name)
    bare = Robot.from_spec(task.robot.spec.model_copy(update={"cables": None}))
    spent = best_times(
        {
            "with": lambda: hognose.plan(Task(task.spec, task.robot)),
            "without": lambda: hognose.plan(Task(task.spec, bare)),
        },
        rounds,
        time.process_time,
    )
    row(f"{name}: planning, with mechanics / without", spent["with"] / spent["without"], RATIO, "x")


def buckling(arm: Mechanics, stiffness: float) -> None:
    """The critical pretension and the sag of a straight arm."""
    soft = replace(arm, axial_stiffness=np.full(arm.robot.cables, stiffness), tension_min=0.0)
    straight = np.zeros((1, arm.robot.sections, 2))
    factor = soft.hold(straight, np.zeros(3)).load_factor[0]
    aside(f"EA {1e-3 * stiffness:g} kN: critical pretension", float(factor * arm.pretension[0]), "N")
    for pretension in (0.0, 10.0, 0.75 * float(factor * arm.pretension[0])):
        pulled = replace(soft, pretension=np.full(arm.robot.cables, pretension))
        sag = 1e3 * np.linalg.norm(pulled.uncompensated(straight, DOWN).tip_shift)
        aside(f"EA {1e-3 * stiffness:g} kN, pretension {pretension:.3g} N: sag", float(sag), "mm")


if __name__ == "__main__":
    main()
