"""`python -m benchmarks.profile`: how long the fastest motions take, how close to the limits, and to be worked out."""

from __future__ import annotations

import math

import numpy as np

import hognose
from benchmarks.rows import aside, heading, row
from benchmarks.timing import best_times, use_one_core
from hognose.planning import Plan, Task
from hognose.planning.base_limits import BaseLimits
from hognose.planning.profile import Fastest
from hognose.planning.profile.between import overruns, overruns_in_space
from hognose.robot.base import turns

CASES = ("obstacle-array", "pipe-tank")
#: On a base that carries the arm, for which no time is asked.
CARRIED = "carrier"
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

    for period in PERIODS:
        plan = hognose.plan(fastest(hognose.load_task(CARRIED), period))
        heading(f"fastest profile of {CARRIED}, {1e3 * period:g} ms a period")
        aside("from rest to rest", float(plan.time[-1]), "s")
        for what, part in parts(plan).items():
            row(f"{what}, part of its limit, with cubics in between", part, PART, "")


def fastest(task: Task, period: float) -> Task:
    """The task with the fastest profile, at another control period (s)."""
    motion = task.spec.motion.model_copy(update={"profile": "fastest", "period_s": period})
    return Task(task.spec.model_copy(update={"motion": motion}), task.robot)


def parts(plan: Plan) -> dict[str, float]:
    """The largest parts of the limits that a plan uses."""
    robot, period = plan.robot, plan.task.spec.motion.period_s
    said, base = robot.spec.limits, BaseLimits.of(plan.task)
    speed, acceleration = math.radians(said.joint_speed_deg_s), math.radians(said.joint_acceleration_deg_s2)
    feed = overruns(plan.feed[:, None], period, base.speed, base.acceleration)
    joints = overruns(plan.angles.reshape(len(plan.time), -1), period, speed, acceleration)
    cables = overruns(plan.cable_lengths, period, said.cable_speed, said.cable_acceleration or math.inf)
    changes = np.diff(np.pad(np.diff(np.pad(np.diff(plan.feed), 1), 1), 1)) / period**3
    allowed = 2 * base.acceleration / plan.task.spec.motion.smoothing_time
    carried: dict[str, float] = {}
    if plan.base_pose is not None:
        turned = np.cumsum(np.pad(turns(plan.task.base, plan.at), ((1, 0), (0, 0))), axis=0)
        for what, values, limits in (
            ("carrier", plan.at[:, :3], (base.speed, base.acceleration)),
            ("carrier turn", turned, (base.turn_speed, base.turn_acceleration)),
        ):
            found = overruns_in_space(values, period, *limits)
            of = {f"{what} speed": found[0], f"{what} acceleration": found[1]}
            carried |= {name: part for name, part in of.items() if part > 0}  # none where there is no limit
    return carried | {
        "feed speed": feed[0],
        "feed acceleration": feed[1],
        "feed jerk": float(np.abs(changes).max()) / allowed,
        "joint speed": joints[0],
        "joint acceleration": joints[1],
        "cable speed": cables[0],
    }


if __name__ == "__main__":
    main()
