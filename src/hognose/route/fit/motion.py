"""What an insertion along a path does to the arm, coarsely and fast: clearance of links, bends and speeds of joints.

All joints pass along the same path, so the last link alone, over the whole insertion, takes every place that any link
of its length takes beyond the entrance. One chord a feed step therefore measures the clearance of all of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.following import follower
from hognose.following.exact import Exact
from hognose.following.on_base import run_on, section_base
from hognose.following.sections import SectionFollower
from hognose.path import Path
from hognose.robot import Robot
from hognose.robot.base import Base, angles_on, centre_line, mounted, nose_on
from hognose.robot.own_body import OwnBody, bends_of
from hognose.robot.sections import MixedSections
from hognose.ties import first_smallest

Array = NDArray[np.float64]

#: Feed steps for a link's length.
STEPS_A_LINK = 8
#: A step is no longer than if the arm had so many links. The feed at which the tip is at the path's end is found to
#: this part of the arm, in so many trials.
FEWEST_LINKS, _AT_END, _MOST_TRIALS = 12, 1e-6, 12
#: At so many places of chords, about, the clearance of sections that are no links is looked at.
MOST_LOOKED_AT = 1_200
#: Whether links touch each other is looked at in every so many-th of them.
LOOKED_AT = 4


@dataclass(frozen=True, eq=False)
class Motion:
    """An insertion at T coarse feed steps, for an arm of n sections.

    Attributes
    ----------
    path
        With the slider's run in front.
    feeds : (T,) m
    joints : (T, n+1, 3) m
    parameters : (T, n+1)
        The path's parameter at the joints.
    at : (T, k)
        Coordinates of the base.
    angles : (T, n, 2) rad
    line : (T, p+1, 3) m
        Ends of the chords of the body: the joints, where sections are links.
    feet : (T, p+1)
        The path's parameter beside them.
    """

    path: Path
    feeds: Array
    joints: Array
    parameters: Array
    at: Array
    angles: Array
    line: Array
    feet: Array


def insertion(path: Path, robot: Robot, base: Base, method: str = "exact") -> Motion | None:
    """The insertion along a path until the tip is at its end; None where the joints cannot follow it steadily.

    Parameters
    ----------
    path
    robot, base
        Along whose direction the path begins.
    method
        How sections that are no links follow. Links are taken to follow exactly.

    Raises
    ------
    InfeasibleError
        Sections that cannot follow the path.
    """
    if isinstance(robot.model, MixedSections):
        return _of_sections(path, robot, robot.model, base, method)
    lengths = robot.link_lengths
    exact = Exact(path, lengths)
    if not exact.tracks:
        return None
    feed = last_feed(path, robot)
    if not 0.0 < feed <= path.length - lengths.max():
        return None
    count = int(np.ceil(feed / lengths.min() * STEPS_A_LINK)) + 1
    feeds = np.linspace(0.0, feed * (1 - 1e-12), count)
    joints, arcs = exact.run_with_arcs(feeds)
    at = base.coordinates(feeds, joints)
    angles = angles_on(base, robot, joints, at)
    parameters = path.parameter(np.minimum(arcs, path.length))
    return Motion(path, feeds, joints, parameters, at, angles, joints, parameters)


def _of_sections(path: Path, robot: Robot, model: MixedSections, base: Base, method: str) -> Motion | None:
    """As `insertion`, of sections of other kinds: they follow as their method does, and the body leaves the path."""
    lengths, rest = robot.link_lengths, (0.01 * robot.length, robot.bend_bounds, model, *section_base(base))
    made = follower(path.with_end(robot.length), lengths, method, *rest)
    assert isinstance(made, SectionFollower)
    feed, before, slope = path.length - robot.length, (0.0, 0.0), 1.0
    for trial in range(_MOST_TRIALS):
        if feed <= 0.0:
            return None
        off = made.tip_arc(feed) - path.length
        if trial and feed != before[0]:  # the secant, kept near one: the tip goes about as far as the base
            slope = min(max((off - before[1]) / (feed - before[0]), 0.5), 2.0)
        before, feed = (feed, off), feed - off / slope
        if abs(off) < _AT_END * robot.length:
            break
    if not 0.0 < feed <= path.length:
        return None
    step = min(float(lengths.min()), robot.length / FEWEST_LINKS) / STEPS_A_LINK
    feeds = np.linspace(0.0, feed, int(np.ceil(feed / step)) + 1)
    joints, at = run_on(base, made, feeds)
    # Beside the path the body is as far along it as it is long, but for little.
    arcs = np.append(0.0, np.cumsum(model.arcs(lengths)))
    feet = path.parameter(np.minimum(feeds[:, None] + arcs, path.length))
    angles = angles_on(base, robot, joints, at)
    line = centre_line(base, robot, joints, at, angles)
    return Motion(path, feeds, joints, feet[:, np.append(0, np.cumsum(model.chords))], at, angles, line, feet)


def nose_of(robot: Robot, base: Base, motion: Motion) -> Array:
    """Where the nose points at the end: a unit vector (3,) in the task's frame."""
    if not robot.straight_links:
        return nose_on(base, robot, motion.angles[-1:], motion.at[-1:])[0]
    last = motion.joints[-1, -1] - motion.joints[-1, -2]
    return last / np.linalg.norm(last)


def touching(robot: Robot, base: Base, motion: Motion) -> tuple[int, int, int] | None:
    """A feed step at which the body touches itself and the two links (0-based) that do; None if there is none.

    The first of both may be `MOUNT`. For nearly every motion the bends show it without distances.
    """
    own = OwnBody.chain(robot.link_lengths, robot.body_radii, base.mount)
    if own.cleared_by_bends(bends_of(motion.angles)):
        return None
    rows = np.arange(len(motion.feeds))[::-LOOKED_AT]
    clearance, pair = own.closest(mounted(base, motion.joints[rows], motion.at[rows]))
    (worst,) = first_smallest(clearance)
    return None if clearance.min() > 0.0 else (int(rows[worst]), *own.names(int(pair[worst])))


def last_feed(path: Path, robot: Robot) -> float:
    """The feed (m) at which the tip is on the end of the path: chords are shorter than their arcs."""
    backwards = Exact(path.reversed(), robot.link_lengths[::-1])
    _, arcs = backwards.run_with_arcs(np.zeros(1))
    return float(path.length - arcs[0, -1])


def leading_links(robot: Robot) -> list[int]:
    """The last link of each length and radius: it takes every place that any other one like it takes."""
    kinds = list(zip(robot.link_lengths.tolist(), robot.body_radii.tolist(), strict=True))
    return [i for i, kind in enumerate(kinds) if kind not in kinds[i + 1 :]]


def leading_chords(robot: Robot) -> NDArray[np.int64]:
    """The chords that are looked at: those of the leading links; of few sections, whose bodies differ, all."""
    if robot.straight_links:
        return np.array(leading_links(robot))
    if robot.sections < FEWEST_LINKS:
        return np.arange(len(robot.chord_sections))
    return np.flatnonzero(np.isin(robot.chord_sections, leading_links(robot)))


def looked_at(robot: Robot, steps: int) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
    """Chords and steps, chord by chord, at which the clearance of an insertion of so many steps is looked at first.

    Of many chords it is every so many-th step, which is returned, too: each takes nearly the places that the next one
    took before.
    """
    chords = leading_chords(robot)
    chord, step = np.repeat(chords, steps), np.tile(np.arange(steps), len(chords))
    every = 1 if robot.straight_links else len(chord) // MOST_LOOKED_AT + 1
    chosen = ((step + chord) % every == 0) | (step == steps - 1)
    return chord[chosen], step[chosen], every


def frames(angles: Array, axes: Array) -> Array:
    """Frames (T, n+1, 3, 3) before each joint and behind the last one: columns are their axes in the task's frame.

    Axes (T, 3, 3) are those of the base.
    """
    steps, sections = angles.shape[:2]
    out = np.empty((steps, sections + 1, 3, 3))
    out[:, 0] = axes
    ca, sa = np.cos(angles[..., 0]), np.sin(angles[..., 0])
    cb, sb = np.cos(angles[..., 1]), np.sin(angles[..., 1])
    zero = np.zeros_like(ca)
    turn = np.stack([ca, sa * sb, sa * cb, zero, cb, -sb, -sa, ca * sb, ca * cb], axis=-1)
    turn = turn.reshape(steps, sections, 3, 3)
    for i in range(sections):
        out[:, i + 1] = out[:, i] @ turn[:, i]
    return out
