"""The mechanics of arms held against MuJoCo: derivatives, buckling, and poses at rest; part of `benchmarks.mechanics`.

Arms are random: every section has lengths, masses, circles of cables and stiffnesses of its own, and the slider points
anywhere. Derivatives are compared with those of MuJoCo's tendons; whether an arm buckles, with what the twin does.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

import hognose
from benchmarks.rows import aside, heading, row
from hognose.files.exports.mjcf import mjcf
from hognose.files.exports.subject import Subject
from hognose.files.exports.xml import document
from hognose.mechanics import Mechanics
from hognose.planning import Task, TaskSpec
from hognose.robot import Robot, RobotSpec
from hognose.robot.base import joints_on
from hognose.sim import Twin
from hognose.sim.mujoco_import import mujoco

Array = NDArray[np.float64]

#: Random arms whose derivatives are compared, and those that may buckle.
ARMS, BUCKLING = 20, 120
#: The largest differences from MuJoCo: m, m/rad, N m; and of tips at rest, mm.
SAME, REST = 1e-12, 0.1
#: By what part pretensions are below or above the critical one; closer to it an arm takes minutes to leave its pose.
BESIDE = (0.02, 0.6)
#: The least tension (N), and the largest as a part of the smallest EA.
LEAST, MOST_STRETCH = 2.0, 0.049
#: How far (rad) an arm is put off its pose, how long (s) it is left alone, and how far off (rad) it has buckled then.
OFF, LEFT_ALONE, GONE = 1e-5, 1.0, 1e-3
#: Every how many steps of both cases, and for how long (s), the twin comes to rest.
EVERY, RESTS = 60, 4.0


def main() -> None:
    """Print all of it."""
    heading(f"against MuJoCo, {ARMS} random arms in random poses")
    derivatives()
    heading(f"buckling of {BUCKLING} random arms and pretensions, predicted and on the twin")
    buckling()
    heading("poses at rest without compensation, statics and the twin")
    for name in ("obstacle-array", "pipe-tank"):
        rest(name)


def random_robot(rng: np.random.Generator, sections: int, pretension: float = 40.0) -> Robot:
    """An arm whose sections differ in everything."""
    stiff = tuple(rng.uniform(30e3, 150e3, sections).tolist())
    spec = hognose.load_robot("sjtu-25dof").spec.model_dump(by_alias=True)
    first = spec["section"][0]
    spec["section"] = [
        first
        | {
            "count": 1,
            "pitch": pitch,
            "half_lengths": tuple((pitch * rng.uniform(0.1, 0.2, 2)).tolist()),
            "cable_radius": first["cable_radius"] * (1.0 - 0.04 * k) * rng.uniform(0.9, 1.0),
            "link_mass": rng.uniform(0.02, 0.2),
            "centre_of_mass": rng.uniform(0.2, 0.8) * pitch,
        }
        for k, pitch in enumerate(rng.uniform(0.06, 0.12, sections).tolist())
    ]
    spec |= {"tool_mass": rng.uniform(0.0, 0.2), "name": "random"}
    springs = {
        "axial_stiffness_N": stiff,
        "pretension_N": pretension,
        "tension_min_N": LEAST,
        "tension_max_N": MOST_STRETCH * min(stiff),
    }
    spec["cables"] = {"free_length": rng.uniform(0.1, 0.5), **springs}
    return Robot.from_spec(RobotSpec.model_validate(spec))


def task_of(robot: Robot, rng: np.random.Generator) -> Task:
    """An empty space with the arm pointing anywhere."""
    ahead = rng.normal(size=3)
    ahead /= np.linalg.norm(ahead)
    spec = {
        "name": "empty",
        "robot": robot.name,
        "base": {"direction": ahead.tolist()},
        "path": {"way_points": [[0.0, 0.0, 0.0], (0.2 * ahead).tolist()]},
    }
    return Task(TaskSpec.model_validate(spec), robot)


def derivatives() -> None:
    """Lengths, Jacobian and torque of the weight beside those of MuJoCo's tendons and dynamics."""
    worst: dict[str, float] = dict.fromkeys(("lengths", "jacobian", "weight"), 0.0)
    mj = mujoco()
    for seed in range(ARMS):
        rng = np.random.default_rng(seed)
        robot = random_robot(rng, 6)
        task, mechanics = task_of(robot, rng), Mechanics.of(robot)
        model = mj.MjModel.from_xml_string(document(mjcf(Subject.of_task(task))[0]).decode())
        data = mj.MjData(model)
        angles = rng.uniform(-1, 1, (robot.sections, 2)) * robot.bend_limits[:, :1]
        data.qpos[:] = [0.0, *angles.ravel()]
        mj.mj_forward(model, data)
        J, flat, columns = np.zeros((robot.cables, model.nv)), data.ten_J.ravel(), model.ten_J_colind.ravel()
        for k, (start, count) in enumerate(zip(model.ten_J_rowadr, model.ten_J_rownnz, strict=True)):
            J[k, columns[start : start + count]] = flat[start : start + count]
        weight = mechanics.gravity_torque(angles[None], task.gravity(np.zeros((1, 1)))[0])[0]
        for what, ours, theirs in (
            ("lengths", robot.cable_lengths(angles), data.ten_length),
            ("jacobian", mechanics.cable_jacobian(angles[None])[0], J[:, 1:]),
            ("weight", weight, data.qfrc_bias[1:]),
        ):
            worst[what] = max(worst[what], float(np.abs(ours - theirs).max()))
    row("cable lengths, from tendons", worst["lengths"], SAME, "m")
    row("Jacobian of the cable lengths, from tendons", worst["jacobian"], SAME, "m/rad")
    row("torque of the weight, from the bias forces", worst["weight"], SAME, "N m")


def buckling() -> None:
    """Whether the sign of the smallest eigenvalue says what the twin does."""
    tried = filter(None, map(buckles, itertools.count()))
    found = list(itertools.islice(tried, BUCKLING))
    aside("buckle on the twin", sum(does for _, does in found), "")
    row("sign of the smallest eigenvalue and the twin disagree", sum(said != does for said, does in found), 0, "")


def buckles(seed: int) -> tuple[bool, bool] | None:
    """Whether an arm is predicted to buckle, and whether it does on the twin when it is put off its pose a little.

    None where no tensions hold the pose.
    """
    rng = np.random.default_rng(1000 + seed)
    sections = int(rng.integers(3, 10))
    robot = random_robot(rng, sections)
    angles = 0.5 * rng.uniform(-1, 1, (sections, 2)) * robot.bend_limits[:, :1]
    task = task_of(robot, rng)
    gravity = task.gravity(np.zeros((1, 1)))[0]
    mechanics = Mechanics.of(robot)
    factor = rng.choice([-1, 1]) * rng.uniform(*BESIDE) + 1.0
    pretension = factor * critical_pretension(mechanics, angles, gravity)
    pulled = with_pretension(robot, min(pretension, 0.6 * mechanics.tension_max))
    mechanics = Mechanics.of(pulled)
    held = mechanics.hold(angles[None], gravity)
    if not held.is_held.all():
        return None
    elastic, geometric = mechanics.stiffness(angles[None], held.tensions, gravity)
    values, vectors = np.linalg.eigh(elastic[0] + geometric[0])
    twin = Twin(Task(task.spec, pulled))
    twin.put(np.zeros(1), angles + OFF * vectors[:, 0].reshape(-1, 2))
    for _ in range(round(LEFT_ALONE / twin.time_step)):
        twin.step(held.commanded_lengths[0], np.zeros(robot.cables), np.zeros(1), np.zeros(1))
        if np.abs(twin.angles - angles).max() > GONE:
            return bool(values[0] < 0), True
    return bool(values[0] < 0), False


def critical_pretension(mechanics: Mechanics, angles: Array, gravity: Array) -> float:
    """The uniform pretension (N) beyond which a pose buckles, by bisection."""
    low, high = 0.0, 0.5 * mechanics.tension_max
    for _ in range(30):
        middle = 0.5 * (low + high)
        pulled = replace(mechanics, pretension=np.full(mechanics.robot.cables, middle))
        stable = pulled.hold(angles[None], gravity).smallest_stiffness[0] > 0
        low, high = (middle, high) if stable else (low, middle)
    return low


def with_pretension(robot: Robot, pretension: float) -> Robot:
    """The same arm, pulled otherwise."""
    assert robot.spec.cables is not None
    cables = robot.spec.cables.model_copy(update={"pretension_N": pretension})
    return Robot.from_spec(robot.spec.model_copy(update={"cables": cables}))


def rest(name: str) -> None:
    """How far tips are apart where arms come to rest that are pulled without regard to their weight."""
    plan = hognose.plan(hognose.load_task(name))
    task, robot, mechanics = plan.task, plan.robot, Mechanics.of(plan.robot)
    apart, hangs, steps = 0.0, 0.0, range(0, len(plan.time), EVERY)
    for step in steps:
        angles, at = plan.angles[step], plan.at[step]
        found = mechanics.uncompensated(angles[None], task.gravity(at[None]))
        if not found.is_stable.all():
            continue
        twin = Twin(task)
        twin._body.model.dof_damping[1:] = 0.5  # with its own damping the arm still swings after five seconds
        lengths = robot.cable_lengths(angles)
        commanded = lengths - mechanics.pretension / mechanics.spring_constants(lengths)
        twin.put(at, angles)
        for _ in range(round(RESTS / twin.time_step)):
            twin.step(commanded, np.zeros(robot.cables), at, np.zeros(1))
        reached = joints_on(task.base, robot, found.angles, at[None])[0, -1]
        apart = max(apart, 1e3 * float(np.linalg.norm(twin.joints[-1] - reached)))
        hangs = max(hangs, 1e3 * float(np.linalg.norm(found.tip_shift)))
    row(f"{name}: tips at rest apart, {len(steps)} poses", apart, REST, "mm")
    aside(f"{name}: they hang by up to", hangs, "mm")


if __name__ == "__main__":
    main()
