"""`python -m benchmarks.profile`: how long the fastest motions take, how close to the limits, and to be worked out."""

from __future__ import annotations

import math

import numpy as np

import hognose
from benchmarks.rows import aside, heading, row
from benchmarks.timing import best_times, use_one_core
from hognose.planning import Plan, Task
from hognose.planning.profile import Fastest
from hognose.planning.profile.between import overruns

CASES = ("obstacle-array", "pipe-tank")
PERIODS = (0.15, 0.02)
#: The longest a motion may take (s), the largest part of a limit, and the longest time (ms) to make a profile.
DURATION, PART, WORK = 24.0, 1.001, 5.0


def main(rounds: int = 40) -> None:
    """Print all of it."""
    for name in CASES:
        aside(f"{name}, constant feed", float(hognose.plan(hognose.load_task(name)).time[-1]), "s")
        for period in PERIODS:
            plan = hognose.plan(fastest(hognose.load_task(name), period))
            heading(f"fastest profile of {name}, {1e3 * period:g} ms a period, {use_one_core()}")
            row("from rest to rest", float(plan.time[-1]), DURATION, "s")
            for what, part in parts(plan).items():
                row(f"{what}, part of its limit, with cubics in between", part, PART, "")
            length = float(plan.feed[-1])

            def make(plan: Plan = plan, length: float = length) -> object:
                return Fastest(plan.task, plan.follower, length).set_points(len(plan.time))

            row("profile and set-points", 1e3 * best_times({"make": make}, rounds)["make"], WORK, "ms")


def fastest(task: Task, period: float) -> Task:
    """The task with the fastest profile, at another control period (s)."""
    motion = task.spec.motion.model_copy(update={"profile": "fastest", "period_s": period})
    return Task(task.spec.model_copy(update={"motion": motion}), task.robot)


def parts(plan: Plan) -> dict[str, float]:
    """The largest parts of the limits that a plan uses."""
    robot, period = plan.robot, plan.task.spec.motion.period_s
    said, axis = robot.spec.limits, robot.spec.feed
    speed, acceleration = math.radians(said.joint_speed_deg_s), math.radians(said.joint_acceleration_deg_s2)
    slider = overruns(plan.feed[:, None], period, axis.speed, axis.acceleration_limit)
    joints = overruns(plan.angles.reshape(len(plan.time), -1), period, speed, acceleration)
    cables = overruns(plan.cable_lengths, period, said.cable_speed, said.cable_acceleration or math.inf)
    changes = np.diff(np.pad(np.diff(np.pad(np.diff(plan.feed), 1), 1), 1)) / period**3
    allowed = 2 * axis.acceleration_limit / plan.task.spec.motion.jerk_time
    return {
        "feed speed": slider[0],
        "feed acceleration": slider[1],
        "feed jerk": float(np.abs(changes).max()) / allowed,
        "joint speed": joints[0],
        "joint acceleration": joints[1],
        "cable speed": cables[0],
    }


if __name__ == "__main__":
    main()
