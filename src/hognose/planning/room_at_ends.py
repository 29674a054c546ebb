"""How much room an arm has at both ends of a way, before anything is planned: at the entrance and at the target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.planning.penetration import per_section
from hognose.planning.room_for_tolerances import taken_at_least
from hognose.planning.task import Task
from hognose.planning.tolerance.allowance import Allowance
from hognose.robot.base import outline, straight_joints
from hognose.ties import first_smallest

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ObstructedStart:
    """A straight arm, or what is behind it, that is too close to something while the tip is at the entrance.

    Attributes
    ----------
    begin : (3,) m
        Where what is behind the first joint begins.
    room, needed : m
        The clearance that there is, below 0 where it touches, and the one that there should be.
    obstacle
        Its name.
    place : m
        On the obstacle.
    """

    begin: Array
    room: float
    needed: float
    obstacle: str
    place: tuple[float, float, float]


def room_at(task: Task, place: Array) -> tuple[float, str]:
    """Distance (m) from a place (3,) m to the nearest surface, and whose it is; minus that distance inside a solid."""
    found = task.scene.witness(place, place)
    inside = int(task.scene.inside(place[None])[0])
    if inside >= 0:
        return -found.distance, task.scene.names[inside]
    return found.distance, str(found.obstacle)


def room_needed(task: Task) -> tuple[float, float]:
    """How far (m) entrance and target must be from what is closest: radius, margin, and what tolerances surely take."""
    taken = taken_at_least(task)[[0, -1]]
    at_entrance, at_target = (float(task.robot.outline.inner_radii[-1] + task.margin + each) for each in taken)
    return at_entrance, at_target


def straight_way(task: Task) -> float:
    """The straight way (m) from the entrance to the target."""
    entrance, target = task.way_points[[0, -1]]
    return float(np.linalg.norm(target - entrance))


def obstructed_start(task: Task) -> ObstructedStart | None:
    """Where the straight arm and the mount behind it have too little room, if they do; of an arm that lies straight."""
    robot, base = task.robot, task.base
    line = straight_joints(base, robot)
    at = base.coordinates(np.zeros(1), line)
    behind = starts, ends, radii = base.behind(at)
    starts, ends = np.concatenate([starts, line[0, :-1]]), np.concatenate([ends, line[0, 1:]])
    room = task.scene.distance(starts, ends).value - np.append(radii, robot.outline.inner_radii)
    needed = np.full(len(ends), task.margin)
    if task.budget is not None:
        allowance = Allowance.of(task.budget, base, np.zeros((1, robot.sections, 2)), at, line)
        of_chords = allowance.at_steps(outline(base, robot, line, at))
        of_arm = per_section(robot.outline.sections, of_chords, np.maximum)[0]
        needed += np.append(task.budget.of_mount(base, *behind), of_arm)
    (worst,) = first_smallest(room - needed)
    if room[worst] >= needed[worst]:
        return None
    found = task.scene.witness(starts[worst], ends[worst])
    return ObstructedStart(starts[0], float(room[worst]), float(needed[worst]), str(found.obstacle), found.on_mesh)
