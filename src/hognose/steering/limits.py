"""What a robot lets a steered arm do: how sharp its path may be, how far it goes, and how fast."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InfeasibleError
from hognose.planning.base_limits import BaseLimits
from hognose.robot import Robot
from hognose.robot.base import Base
from hognose.robot.bends import used
from hognose.robot.sections import MixedSections
from hognose.steering.grown_curve import LONGEST_ARC
from hognose.steering.way import PlacedArm
from hognose.wording import mm, point

Array = NDArray[np.float64]

#: Part of the curvature at a bend limit that steering uses; the rest is for a spline through way-points.
USED_CURVATURE = 0.98
#: Arcs that are aimed bend up to 1.14 times as much where the curvature begins as on the circle behind: so much less of
#: it is used of arcs, and of stacks of k joints 1 - 1/k of that. Measured on arms of 3 to 12 sections.
_LESS_OF_ARCS = 0.13


@dataclass(frozen=True)
class Held:
    """What held a move back, or limited its turn.

    Attributes
    ----------
    reason
        "clearance", "own body", "bend limit", "feed range", "workspace", "cable travel", "joint speed", "cable speed",
        "feed speed", "carrier turn speed" or "following".
    sentence
        The same in words: what, where, how much, and the limit.
    value, limit
        In `unit`, as people read them. Of a clearance, what is there now; of the others, what was asked.
    section
        The section (1-based), or None where that has no meaning.
    obstacle
        The name of the obstacle that is too close, or None.
    other_section
        The section (1-based) that `section` would touch; None if it is none, or the mount.
    """

    reason: str
    sentence: str
    value: float
    limit: float
    unit: str
    section: int | None = None
    obstacle: str | None = None
    other_section: int | None = None


class CurvatureLimit:
    """How sharp a path may be, so that every section that comes along it can take it."""

    def __init__(self, robot: Robot, base: Base) -> None:
        bends = np.abs(robot.bend_bounds)
        part: float | Array = USED_CURVATURE
        if isinstance(robot.model, MixedSections):
            bends = bends.max(axis=2)  # the closer side holds where it is met
            part = USED_CURVATURE - _LESS_OF_ARCS * (1.0 - robot.model.curvature_shares)
        else:
            bends = bends.min(axis=2)  # a path turns to any side, and nothing else holds links
        sharpest = part * robot.model.sharpest(robot.link_lengths, bends)
        # What grows at some depth is met by the first section that reaches so far, and by all in front of it.
        self._stiffest = [i + int(np.argmin(sharpest[i:])) for i in range(len(sharpest))]
        self._sharpest = sharpest[self._stiffest]
        # Where the base follows along the path, all sections come along anywhere.
        self._reaches = np.array([np.inf]) if base.follows else LONGEST_ARC * np.cumsum(robot.link_lengths)
        self._bends = np.degrees(bends.min(axis=1))

    def at(self, depth: float) -> tuple[float, int]:
        """Sharpest curvature (1/m) from a depth (m) on, and the section (0-based) that says so."""
        index = min(int(np.searchsorted(self._reaches, depth)), len(self._reaches) - 1)
        return float(self._sharpest[index]), self._stiffest[index]

    def exceeded(self, asked: float, depth: float) -> Held | None:
        """What limits a turn (rad/m) that is asked at a depth (m), if anything."""
        most, section = self.at(depth)
        if asked <= most:
            return None
        words = (
            f"a turn of {asked:.4g} rad/m was asked, {most:.4g} rad/m taken: section {section + 1} bends by at most "
            f"{self._bends[section]:.4g} deg"
        )
        return Held("bend limit", words, asked, most, "rad/m", section + 1)


def cannot_follow(error: InfeasibleError, asked: float, depth: float) -> Held:
    """What holds at a depth (m) where sections do not reach the path on the way to the one that is asked."""
    words = f"the arm cannot follow the nose to {mm(asked)}: {error}; go back, and steer more gently"
    return Held("following", words, 1e3 * asked, 1e3 * depth, "mm")


def out_of_range(robot: Robot, base: Base, arm: PlacedArm) -> Held | None:
    """The end of the feed, of the carrier's workspace, of a bend or of a cable's travel, that an arm is beyond."""
    most = base.feed_limit(robot)
    if arm.feed > most:
        which = "the slider ends there" if robot.spec.feed.max <= robot.length else "the first joint is at the entrance"
        words = f"the feed would be {mm(arm.feed)}, at most {mm(most)}: {which}"
        return Held("feed range", words, 1e3 * arm.feed, 1e3 * most, "mm")
    away = float(np.linalg.norm(base.outside(arm.joints[:1])))
    if away > 0:
        words = f"the first joint would be {mm(away)} outside base.workspace, at {point(arm.joints[0])}"
        return Held("workspace", words, 1e3 * away, 0.0, "mm")
    bent = _bent_too_far(robot, arm.angles)
    if bent is not None:
        return bent
    travel = arm.cables - robot.straight_cable_lengths
    low, high = robot.spec.limits.cable_travel
    cable = int(np.argmax(np.maximum(travel / high, travel / low)))
    limit = high if travel[cable] > 0 else -low
    section = int(robot.cable_sections[cable])
    return _too_much("cable travel", 1e3 * abs(travel[cable]), 1e3 * limit, "mm", section, cable)


def _bent_too_far(robot: Robot, angles: Array) -> Held | None:
    """The limit of a bend, on its side, that angles (n, 2) rad exceed; links, whose path is gentle enough, never do."""
    if robot.straight_links:
        return None
    part = used(angles, robot.bend_bounds)
    section, axis = np.unravel_index(int(np.argmax(part)), part.shape)
    if part[section, axis] <= 1.0:
        return None
    name, value = ("alpha", "beta")[axis], math.degrees(angles[section, axis])
    low, high = np.degrees(robot.bend_bounds[section, axis]).tolist()
    limit = high if value > 0 else low
    words = (
        f"{name} of section {section + 1} would be {value:.4g} deg, limit {limit:.4g} deg: turn to another side, or "
        "go back and steer more gently"
    )
    return Held("bend limit", words, abs(value), abs(limit), "deg", int(section) + 1)


def too_fast(
    robot: Robot, base: Base, of_base: BaseLimits, start: PlacedArm, arm: PlacedArm, period: float
) -> Held | None:
    """The speed limit that going from one place to another in a period (s) breaks first."""
    limits = robot.spec.limits
    bends = np.degrees(np.abs(arm.angles - start.angles).max(axis=1)) / period
    cables = 1e3 * np.abs(arm.cables - start.cables) / period
    feed = 1e3 * abs(arm.feed - start.feed) / period
    section, cable = int(np.argmax(bends)), int(np.argmax(cables))
    owner = int(robot.cable_sections[cable])
    return (
        _too_much("joint speed", bends[section], limits.joint_speed_deg_s, "deg/s", section)
        or _too_much("cable speed", cables[cable], 1e3 * limits.cable_speed, "mm/s", owner, cable)
        or _too_much("feed speed", feed, 1e3 * of_base.judged_speed, "mm/s")
        or _too_much("carrier turn speed", _turned(base, start, arm) / period, np.degrees(of_base.turn_speed), "deg/s")
    )


def _turned(base: Base, start: PlacedArm, arm: PlacedArm) -> float:
    """By how much (deg) the base turns the arm's axes from one place to another."""
    at = base.coordinates(np.array([start.feed, arm.feed]), np.stack([start.joints, arm.joints]))
    return float(np.degrees(np.linalg.norm(base.spin(at[:1], at[1:]))))


def _too_much(
    reason: str, value: float, limit: float, unit: str, section: int | None = None, cable: int | None = None
) -> Held | None:
    """What holds if a value exceeds its limit; section and cable come 0-based."""
    if value <= limit:
        return None
    of_cable = f" of cable {cable + 1}," if cable is not None else ""
    where = of_cable + (f" section {section + 1}" + ("," if of_cable else "") if section is not None else "")
    words = f"the {reason}{where} would be {value:.4g} {unit}, limit {limit:.4g} {unit}"
    return Held(reason, words, float(value), limit, unit, None if section is None else section + 1)
