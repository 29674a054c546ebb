"""One configuration of the arm in its space: what the page draws."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.planning import Plan
from hognose.planning.link_budgets import clearance_left
from hognose.planning.penetration import Contact, contact, nearest
from hognose.robot import Robot
from hognose.robot.base import axes_of
from hognose.robot.holes import link_frames
from hognose.scene import MovingObstacle, Scene
from hognose.steering.steered_path import SteeredPath

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ArmState:
    """The arm at one moment.

    Attributes
    ----------
    joints : (n+1, 3) m
    vertices : (p+1, 3) m
        Ends of the chords of the body.
    outline : (c+1, 3) m
        Ends of the chords of `Robot.outline`.
    frames : (n+1, 3, 3)
        Of the base and of every link; columns are their axes.
    angles : (n, 2) rad
    clearance : (n,) m
        Of each link; at `horizon` a lower bound.
    margin, horizon : m
    moving, time : s
        Obstacles that move, and when on their clock.
    """

    robot: Robot
    scene: Scene
    joints: Array
    vertices: Array
    outline: Array
    frames: Array
    angles: Array
    clearance: Array
    margin: float
    horizon: float
    moving: tuple[MovingObstacle, ...] = ()
    time: float = 0.0

    @classmethod
    def of_plan(cls, plan: Plan, row: int) -> ArmState:
        """The arm at a row of a plan."""
        return cls(
            plan.robot,
            plan.scene,
            plan.body[row],
            plan.centre_line[row],
            plan.outline[row],
            link_frames(plan.angles[row], axes_of(plan.task.base, plan.at[row : row + 1])[0]),
            plan.angles[row],
            plan.clearance[row],
            plan.task.margin,
            plan.horizon,
            plan.task.moving,
            float(plan.clock[row]),
        )

    @classmethod
    def of_steered(cls, steered: SteeredPath) -> ArmState:
        """The arm where it has been steered."""
        line, turned, lines = steered.vertices, steered.R_task_base, steered.robot.outline.lines
        outline = line if lines is None else lines.place((line @ turned)[None], steered.angles[None])[0] @ turned.T
        return cls(
            steered.robot,
            steered.scene,
            steered.joints,
            line,
            outline,
            link_frames(steered.angles, turned),
            steered.angles,
            steered.clearance,
            steered.margin,
            steered.horizon,
        )

    def contact(self, link: int) -> Contact:
        """Where a link and the obstacles, as they stand, come closest."""
        clearance = float(self.clearance[link])
        return contact(self.scene, self.moving, self.robot, self.outline, self.time, link, clearance)


def too_close(plan: Plan, most: int = 400) -> Array:
    """Where (k, 3) m a motion comes closer to obstacles than the margin at its steps; of very many, some."""
    row, link = np.nonzero(clearance_left(plan) < plan.task.margin)
    some = np.unique(np.linspace(0, len(row) - 1, min(most, len(row))).astype(int))
    row, link = row[some], link[some]
    starts, ends = plan.body[row, link], plan.body[row, link + 1]
    inside = plan.clearance[row, link] < -plan.robot.body_radii[link]
    found = nearest(plan.scene, plan.task.moving, starts, ends, plan.clock[row], inside=inside)
    return found.on_mesh[np.isfinite(found.on_mesh).all(axis=1)]
