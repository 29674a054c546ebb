"""What an insertion along a path does to the arm, coarsely and fast: clearance of links, bends and speeds of joints.

All joints pass along the same path, so the last link alone, over the whole insertion, takes every place that any link
of its length takes beyond the entrance. One chord a feed step therefore measures the clearance of all of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.following.exact import Exact
from hognose.path import Path
from hognose.robot import Robot
from hognose.robot.base import Base, angles_on, mounted
from hognose.robot.own_body import OwnBody, bends_of
from hognose.ties import first_smallest

Array = NDArray[np.float64]

#: Feed steps for a link's length.
STEPS_A_LINK = 8
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
    """

    path: Path
    feeds: Array
    joints: Array
    parameters: Array
    at: Array
    angles: Array


def insertion(path: Path, robot: Robot, base: Base) -> Motion | None:
    """The insertion along a path until the tip is at its end; None where the joints cannot follow it steadily.

    Parameters
    ----------
    path
    robot, base
        Along whose direction the path begins.
    """
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
    return Motion(path, feeds, joints, path.parameter(np.minimum(arcs, path.length)), at, angles)


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
