"""The usual way, to compare with: OMPL's RRTConnect in the arm's joint space, feed and all angles."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from ompl import base as ompl_base
from ompl import geometric as ompl_geometric
from ompl import util as ompl_util

from benchmarks.by_coal import chain
from hognose.planning.penetration import clearance_of
from hognose.planning.task import Task

Array = NDArray[np.float64]
base: Any = ompl_base  # their types know neither subclasses nor indices
geometric: Any = ompl_geometric
util: Any = ompl_util

#: Largest distance (m) that any joint moves between two checks.
FINE = 5e-3
#: How close (m) to the target the tip of a goal must be.
AT_TARGET = 1e-3
#: Part of the time that may go into finding goals, once there is one; and how many are enough.
GOAL_TIME, ENOUGH_GOALS = 0.25, 10
#: Random starts whose inverse kinematics are solved together, and rounds of least squares.
BATCH, ROUNDS = 64, 60
#: Damping (m) of the least squares: small beside the arm's length, so that the tip goes where it is asked to.
DAMPING = 0.05
#: Longest motion that is added to a tree; feed in m and angles in rad count alike.
RANGE = 0.1


@dataclass(frozen=True)
class Attempt:
    """What came of it.

    Attributes
    ----------
    path : (m, 1 + 2n) or None
        Feed and angles of the way that was found.
    seconds : to the way, or till it was given up
    reached : configurations with the tip at the target
    goals : those of them that keep clear
    states : states of both trees
    ended : "path", "no goal" (no configuration at the target keeps clear) or "no path"
    """

    path: Array | None
    seconds: float
    reached: int
    goals: int
    states: int
    ended: str


class Arm:
    """A task's arm in its space: states q of feed (m) and angles (rad), and whether they keep the margin."""

    def __init__(self, task: Task) -> None:
        robot = task.robot
        self.task, self.robot, self.scene = task, robot, task.scene
        limits = robot.bend_limits.ravel()
        self.low = np.append(robot.spec.feed.min, -limits)
        self.high = np.append(robot.spec.feed.max, limits)

    def body(self, q: Array) -> Array:
        """Joints and tip (T, n+1, 3) m of states (T, 1 + 2n)."""
        return self.robot.joint_positions(q[:, 1:].reshape(len(q), -1, 2), q[:, 0]) + self.task.start

    def clear(self, body: Array) -> bool:
        """Whether all links keep the margin in all configurations, those behind the entrance too."""
        margin = self.task.margin
        found = self.scene.clearance(body[:, :-1], body[:, 1:], self.robot.body_radii, margin, threads=1)
        return bool(found.value.min() >= margin)

    def outside(self, body: Array) -> bool:
        """Whether one configuration keeps the margin and no link is inside a solid: a goal has no way that shows it."""
        margin = self.task.margin
        return bool(clearance_of(self.scene, body, self.robot.body_radii, margin).min() >= margin)

    def clear_between(self, first: Array, last: Array) -> bool:
        """Whether the motion straight from state to state is clear, looked at finely."""
        ends = self.body(np.stack([first, last]))
        if not self.clear(ends[1:]):
            return False
        pieces = max(1, int(np.ceil(np.linalg.norm(ends[1] - ends[0], axis=1).max() / FINE)))
        while True:
            body = self.body(first + np.linspace(0.0, 1.0, pieces + 1)[:, None] * (last - first))
            coarsest = float(np.linalg.norm(np.diff(body, axis=0), axis=2).max())
            if coarsest <= FINE * (1 + 1e-9):
                return self.clear(body)
            pieces = max(pieces + 1, int(np.ceil(pieces * coarsest / FINE)))


def configurations_at_target(arm: Arm, random: np.random.Generator) -> Array:
    """States (k, 1 + 2n) with the tip at the target: damped least squares from a batch of random starts."""
    target = arm.task.way_points[-1] - arm.task.start
    # Some starts are nearly straight, some bent anyhow: a straight arm goes through holes, a bent one round pillars.
    bent = random.uniform(0.0, 1.0, (BATCH, 1))
    q = np.concatenate(
        [np.zeros((BATCH, 1)), bent * random.uniform(arm.low[1:], arm.high[1:], (BATCH, len(arm.low) - 1))], axis=1
    )
    q[:, 0] = random.uniform(0.5 * arm.high[0], arm.high[0], BATCH)
    for _ in range(ROUNDS):
        miss, jacobian = _miss(arm, q, target)
        if np.linalg.norm(miss, axis=1).max() < 0.1 * AT_TARGET:
            break
        square = jacobian @ jacobian.transpose(0, 2, 1) + DAMPING**2 * np.eye(3)
        q += (jacobian.transpose(0, 2, 1) @ np.linalg.solve(square, miss[:, :, None]))[:, :, 0]
        q = np.clip(q, arm.low, arm.high)
    miss, _ = _miss(arm, q, target)
    return q[np.linalg.norm(miss, axis=1) <= AT_TARGET]


def _miss(arm: Arm, q: Array, target: Array) -> tuple[Array, Array]:
    """From the tips to the target (T, 3), and the tips' Jacobians (T, 3, 1 + 2n)."""
    joints, frames = chain(q[:, 1:].reshape(len(q), -1, 2), q[:, 0], arm.robot.link_lengths)
    levers = joints[:, -1:] - joints[:, :-1]
    # α turns about the y axis before it, β about the x axis behind it, which is its own.
    turned = np.stack([np.cross(frames[:, :-1, :, 1], levers), np.cross(frames[:, 1:, :, 0], levers)], axis=2)
    slid = np.tile([0.0, 0.0, 1.0], (len(q), 1, 1))
    jacobian = np.concatenate([slid, turned.reshape(len(q), -1, 3)], axis=1).transpose(0, 2, 1)
    return target - joints[:, -1], jacobian


def goals_within(arm: Arm, random: np.random.Generator, seconds: float) -> tuple[list[Array], int]:
    """Clear states with the tip at the target, and how many at the target there were, clear or not.

    Until there is one all the time goes into it, then only a part.
    """
    began, goals, reached = time.perf_counter(), [], 0
    while len(goals) < ENOUGH_GOALS:
        spent = time.perf_counter() - began
        if spent > (GOAL_TIME if goals else 1.0) * seconds:
            break
        for q in configurations_at_target(arm, random):
            reached += 1
            body = arm.body(q[None])
            if arm.clear(body) and arm.outside(body):
                goals.append(q)
    return goals, reached


def attempt(task: Task, seconds: float, seed: int) -> Attempt:
    """Look for a way from the straight arm at feed 0 to any configuration with the tip at the target."""
    util.setLogLevel(util.LogLevel.LOG_NONE)
    util.RNG.setSeed(seed + 1)  # zero is refused
    arm = Arm(task)
    began = time.perf_counter()
    goals, reached = goals_within(arm, np.random.default_rng(seed), seconds)
    if not goals:
        return Attempt(None, time.perf_counter() - began, reached, 0, 0, "no goal")
    path, states = _connected(arm, goals, seconds - (time.perf_counter() - began))
    ended = "no path" if path is None else "path"
    return Attempt(path, time.perf_counter() - began, reached, len(goals), states, ended)


def _connected(arm: Arm, goals: list[Array], seconds: float) -> tuple[Array | None, int]:
    """A path (m, 1 + 2n) from the straight arm to one of the goals, and how many states RRTConnect's trees have."""
    space = base.RealVectorStateSpace(len(arm.low))
    bounds = base.RealVectorBounds(len(arm.low))
    for i, (low, high) in enumerate(zip(arm.low.tolist(), arm.high.tolist(), strict=True)):
        bounds.setLow(i, low)
        bounds.setHigh(i, high)
    space.setBounds(bounds)
    information = base.SpaceInformation(space)

    def values(state: Any) -> Array:
        return np.array([state[i] for i in range(len(arm.low))])  # list(state) crashes

    def state_of(q: Array) -> Any:
        state = space.allocState()
        for i, value in enumerate(q.tolist()):
            state[i] = value
        return state

    class Motions(base.MotionValidator):
        """Checks a whole motion at once, which is several times faster than state by state."""

        def checkMotion(self, first: Any, last: Any) -> bool:
            return arm.clear_between(values(first), values(last))

    information.setStateValidityChecker(lambda state: arm.clear(arm.body(values(state)[None])))
    motions = Motions(information)
    information.setMotionValidator(motions)
    information.setup()
    problem = base.ProblemDefinition(information)
    problem.addStartState(state_of(np.zeros(len(arm.low))))
    targets = base.GoalStates(information)
    for q in goals:
        targets.addState(state_of(q))
    problem.setGoal(targets)
    planner = geometric.RRTConnect(information)
    planner.setRange(RANGE)
    planner.setProblemDefinition(problem)
    planner.setup()
    planner.solve(base.timedPlannerTerminationCondition(max(seconds, 0.0)))
    trees = base.PlannerData(information)
    planner.getPlannerData(trees)
    if not problem.hasExactSolution():
        return None, trees.numVertices()
    found = problem.getSolutionPath()
    states = [values(found.getState(k)) for k in range(found.getStateCount())]
    return np.array(states), trees.numVertices()
