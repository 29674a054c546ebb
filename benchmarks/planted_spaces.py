"""Spaces with a known way through: obstacles wrapped round the body of a random motion that the arm can make.

Every space is solvable with its planted clearance, and the proof is at hand: a plan of the motion it was made from,
certified. The search for routes is measured on them; it sees the obstacles, the entrance and the target.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from benchmarks.wrapped_obstacles import WRAPPED, Swept, entrance
from hognose.errors import HognoseError, InputError
from hognose.following import follower
from hognose.following.exact import Exact
from hognose.path import Path
from hognose.planning.plan import Plan
from hognose.planning.planner import plan_along
from hognose.planning.task import Task, TaskSpec
from hognose.robot import Robot
from hognose.robot.base import FORWARD, Slider
from hognose.route.fit.motion import Motion, insertion, leading_chords

Array = NDArray[np.float64]
Family = Literal["boards", "pillars", "pipes", "plates", "rubble", "duct"]
FAMILIES: tuple[Family, ...] = ("boards", "pillars", "pipes", "plates", "rubble", "duct")

#: The arm (m) round whose motions obstacles of the sizes below are wrapped; for others they are in proportion.
ARM = 1.092
#: What is kept besides the planted clearance (m): the certificate is tight to a quarter of a millimetre.
SPARE = 3e-4
#: What the joints of that arm can turn in all (rad). Planted motions of arms that can less bend less.
TURNS = 6.0
#: Paths that bend by so many times as much as sections can about one axis are not tried.
SHARP = 2.0
#: Of sections that are no links, about so many places of chords stand for the body of a motion.
MOST_CHORDS = 15_000
#: Feed of a step (m) and its time (s).
STEP, PERIOD = 0.0035, 0.15


@dataclass(frozen=True, eq=False)
class Space:
    """Obstacles, and a motion that keeps clear of them by the planted clearance.

    Attributes
    ----------
    planted : m
    way_points : (m, 3) m
        Those of the planted motion.
    task
        The search for a way: entrance and target alone.
    """

    family: Family
    seed: int
    planted: float
    way_points: Array
    task: Task

    def proof(self) -> Plan:
        """The planted motion, planned and certified with the planted clearance.

        Raises
        ------
        InfeasibleError
            The space is not what it claims to be.
        """
        spec = self.task.spec.model_copy(update={"margin": self.planted})
        return plan_along(Task(spec, self.task.robot), way_points=self.way_points)


def space(
    robot: Robot, family: Family, seed: int, planted: float = 0.010, margin: float = 0.005, method: str = "exact"
) -> Space:
    """A space of a family with a known way through.

    Parameters
    ----------
    robot
    family
        A name in `FAMILIES`.
    seed
        The same one gives the same space.
    planted : m
        Clearance of the known motion.
    margin : m
        Clearance that the task asks for.
    method
        How the arm follows, in the known motion and in the task.

    Raises
    ------
    InputError
        An unknown family, or a robot for which no random motion is found.
    """
    if family not in FAMILIES:
        raise InputError(f"family {family!r} is unknown. Families: {', '.join(FAMILIES)}")
    random = np.random.default_rng([seed, FAMILIES.index(family)])
    way_points, swept = _random_motion(robot, random, method)
    gap = planted + SPARE * max(swept.size, 0.3)
    solids = entrance(swept, gap, random) + WRAPPED[family](swept, gap, random)
    spec = TaskSpec.model_validate(
        {
            "name": f"{family} {seed}",
            "robot": robot.name,
            "margin": margin,
            "path": {"target": tuple(way_points[-1].tolist())},
            "motion": {"step": STEP * swept.size, "period_s": PERIOD, "method": method},
            "obstacle": [solid.model_dump() for solid in solids],
        }
    )
    return Space(family, seed, planted, way_points, Task(spec, robot))


def _random_motion(robot: Robot, random: np.random.Generator, method: str) -> tuple[Array, Swept]:
    """Way-points of a motion that uses a good part of what the joints can bend, and what it sweeps."""
    supple = round(robot.sections * float(robot.bend_limits.min()) / TURNS, 6)
    for _ in range(2000):
        count = int(random.integers(4, 7))
        length = robot.length * random.uniform(0.82, 0.97)
        z = np.linspace(0.0, length, count + 1)
        turn = random.normal(scale=0.35 * min(supple, 1.0), size=(count + 1, 2))
        turn[0] = 0.0
        offset = np.cumsum(np.cumsum(turn, axis=0) * 0.6, axis=0) * (length / count)
        way_points = np.concatenate([offset, z[:, None]], axis=1)
        way_points -= way_points[0]
        path = Path.through(way_points, 3, FORWARD).with_run(robot.length)
        if path.sharpest[0] * float((robot.link_lengths / robot.bend_limits.max(axis=1)).max()) > SHARP:
            continue
        try:
            motion = insertion(path, robot, Slider.before(np.zeros(3), robot), method)
        except HognoseError:
            continue
        if motion is not None and _moderate(motion, robot, supple):
            return way_points, _swept(path, motion, robot, method)
    raise InputError(f"robot {robot.name!r}: no random motion was found that its joints can make")


def _moderate(motion: Motion, robot: Robot, supple: float) -> bool:
    """Whether a motion is within the limits and bends enough to be worth a search; supple arms need not use all."""
    bend = float((np.abs(motion.angles) / robot.bend_limits).max())
    rate = np.abs(np.diff(motion.angles, axis=0)).max() / (motion.feeds[1] - motion.feeds[0])
    speed = rate * STEP * _size(robot) / PERIOD / np.radians(robot.spec.limits.joint_speed_deg_s)
    reach = motion.feeds[-1] / robot.reach
    return bool(0.5 / max(supple, 1.0) <= bend <= 0.85 and speed <= 0.9 and reach <= 0.985)


def _swept(path: Path, motion: Motion, robot: Robot, method: str) -> Swept:
    """The chords of the body that lead, 2 mm of feed apart, or as much for the arm's size, and the straight arm.

    Of many chords the feeds are farther apart: each takes nearly the places of the next one.
    """
    size = _size(robot)
    feeds = np.linspace(0.0, motion.feeds[-1] * (1 - 1e-12), int(motion.feeds[-1] / (0.002 * size)) + 2)
    if robot.straight_links:
        line = Exact(path, robot.link_lengths).run(feeds)
    else:
        longer, rest = path.with_end(robot.length), (method, 0.0005, robot.bend_bounds, robot.model, np.eye(3))
        line = robot.model.vertices(follower(longer, robot.link_lengths, *rest).run(feeds))
    leading = leading_chords(robot)
    every = 1 if robot.straight_links else len(leading) * len(feeds) // MOST_CHORDS + 1
    places = [line[i % every :: every, i : i + 2] for i in leading]
    starts, ends = np.concatenate([*places, np.stack([line[0, :-1], line[0, 1:]], axis=1)]).swapaxes(0, 1)
    radii = np.concatenate([np.repeat(robot.chord_radii[leading], [len(few) for few in places]), robot.chord_radii])
    return Swept(np.ascontiguousarray(starts), np.ascontiguousarray(ends), radii, path, robot.length, size)


def _size(robot: Robot) -> float:
    return round(robot.length / ARM, 6)
