"""The lengths that a search works with, all in proportion to the arm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hognose.planning.task import Task
from hognose.robot import Robot

#: Where the base follows, a way is searched that is longer than the straight one by this part of the arm.
ROUNDABOUT = 0.5
#: Of sections that bend more sharply than so many radians on the reach, passages are searched that do not: with all
#: that they can, moves turn so far that there are too many headings.
MOST_TURNS = 10.0
#: Where the base follows, no way is searched that is longer than so many arms.
MOST_ARMS = 10.0


@dataclass(frozen=True)
class Lengths:
    """What the steps of a search are measured by, so that small and large, stiff and supple arms are searched alike.

    Attributes
    ----------
    half : m
        Half the width that the body needs with its margin, where it is thinnest in front.
    body : m
        The same in the middle between the thickest and the thinnest of sections that are no links; else `half`.
    turn : m
        Radius of the sharpest bend about one axis: the circle through the joints, or of sections that bend themselves.
    reach : m
        The longest way that is searched: what the arm reaches on its base.
    """

    half: float
    turn: float
    reach: float
    body: float

    @classmethod
    def of(cls, robot: Robot, margin: float, reach: float) -> Lengths:
        """The lengths for an arm that keeps a margin (m). Thicker links behind the last need not come so far."""
        half = float(robot.body_radii[-1]) + margin
        if robot.straight_links:
            turn = float(robot.link_lengths.max() / (2.0 * np.sin(robot.bend_limits.min() / 2)))
            return cls(half, turn, reach, half)
        turn = max(float((robot.link_lengths / robot.bend_limits.min(axis=1)).max()), reach / MOST_TURNS)
        # Thin noses get into narrow places, but most of the way is as wide as what follows.
        return cls(half, turn, reach, 0.5 * float(robot.body_radii.max() + robot.body_radii.min()) + margin)

    @classmethod
    def of_task(cls, task: Task) -> Lengths:
        """The lengths for a task's arm on its base.

        `half` is one for all links, with the largest clearance that any of them wants: where tolerances take more of
        the last links, the grid is searched as if they took as much of the first. Only plans are judged link by link.
        """
        return cls.of(task.robot, task.clearance_wanted, longest_way(task))

    @property
    def cell(self) -> float:
        """Distance (m) of neighbouring nodes of the clearance grid, unless that makes too many."""
        return self.body / 3.0

    @property
    def wide(self) -> float:
        """Distance (m) of a curve from obstacles from which on more is no better."""
        return 2.0 * self.body

    @property
    def far(self) -> float:
        """Distances (m) to obstacles beyond this are not looked for on the grid."""
        return self.wide + self.cell

    @property
    def move(self) -> float:
        """Length (m) of an arc of a passage: a part of the sharpest bend, neither too many on the way nor too few."""
        return float(np.clip(0.245 * self.turn, self.reach / 48, self.reach / 16))

    @property
    def spans(self) -> tuple[int, ...]:
        """Numbers of spans that the splines along the whole reach have: a sharpest radius each, then shorter ones."""
        least = float(np.clip(self.reach / self.turn, 5.0, 12.0))
        return tuple(round(part * least) for part in (1.0, 1.5, 2.0))


def longest_way(task: Task) -> float:
    """How long (m) a way from the entrance to the target is that is searched.

    An arm whose base follows along the path reaches on and on; longer ways round than these are not looked for.
    """
    if task.base.follows:
        return way_length(task) + ROUNDABOUT * task.robot.length
    return task.base.reach(task.robot)


def too_far_to_search(task: Task) -> bool:
    """Whether the target is so far that the grid would be too coarse; only where the base follows without end."""
    return task.base.follows and way_length(task) > MOST_ARMS * task.robot.length


def way_length(task: Task) -> float:
    """Length (m) of the straight lines between the places to be passed."""
    return task.way_length
