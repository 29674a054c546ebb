"""What an arm stands on as thin lines: the drum and its nozzle, the carrier's workspace, the mount."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from hognose.planning.motion import Motion
from hognose.planning.task import Task
from hognose.robot.base import Mount, axes_of
from hognose.robot.drum import Drum

Array = NDArray[np.float64]

#: Pieces of a drum's circle and of a ring round the mount, and lines along the mount.
_CIRCLE, _RING, _ALONG = 96, 24, 4
#: An edge of a box: two of its corners, of eight, that differ along one axis.
_CORNERS = np.array(list(product((0, 1), repeat=3)))
_EDGES = np.array([(a, b) for a, b in product(range(8), repeat=2) if a < b and (_CORNERS[a] != _CORNERS[b]).sum() == 1])


def standing_lines(task: Task) -> Array:
    """Pieces (k, 2, 3) m of a drum's circle and nozzle; none of another base."""
    base = task.base
    if not isinstance(base, Drum):
        return np.empty((0, 2, 3))
    nozzle = np.stack([base.entrance - base.nozzle * base.direction, base.entrance])
    middle = nozzle[0] + base.radius * base.R_task_nozzle[:, 0]
    circle = _circle(middle, base.radius * base.R_task_nozzle[:, ::2], _CIRCLE)
    return np.concatenate([circle, nozzle[None]])


def workspace_lines(task: Task) -> Array:
    """Edges (12, 2, 3) m of the box in which a carrier takes the first joint; none where there is no box."""
    box = task.spec.base.workspace
    if box is None:
        return np.empty((0, 2, 3))
    corners = np.array([box.low, box.high])[_CORNERS, np.arange(3)]
    return corners[_EDGES]


def mount_lines(mount: Mount | None, first: Array, axes: Array) -> Array:
    """Pieces (k, 2, 3) m round the mount behind the first joint (3,) m of an arm with these axes (3, 3)."""
    if mount is None:
        return np.empty((0, 2, 3))
    front = _circle(first, mount.radius * axes[:, :2], _RING)
    back = front - mount.length * axes[:, 2]
    along = np.stack([front[:: _RING // _ALONG, 0], back[:: _RING // _ALONG, 0]], axis=1)
    return np.concatenate([front, back, along])


def mount_at(motion: Motion, step: int) -> Array:
    """The same pieces of the mount at a step of a motion."""
    base = motion.task.base
    if base.mount is None:
        return mount_lines(None, np.empty(0), np.empty(0))
    (axes,) = axes_of(base, motion.at[step][None])
    return mount_lines(base.mount, motion.joints[step, 0], axes)


def base_points(motion: Motion) -> Array:
    """Places (k, 3) m that a picture of the motion must hold to show the base, but for a carrier's workspace."""
    found = [standing_lines(motion.task), mount_at(motion, 0), mount_at(motion, -1)]
    return np.concatenate(found).reshape(-1, 3)


def _circle(middle: Array, axes: Array, count: int) -> Array:
    """Pieces (count, 2, 3) of the circle about a middle (3,) with these two radii (3, 2)."""
    turn = 2 * np.pi * np.arange(count + 1) / count
    ring = middle + np.stack([np.cos(turn), np.sin(turn)], axis=1) @ axes.T
    return np.stack([ring[:-1], ring[1:]], axis=1)
