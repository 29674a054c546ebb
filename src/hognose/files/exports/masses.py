"""Masses and moments of inertia of the links, as models for other programs want them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.robot import Robot

Array = NDArray[np.float64]

#: Nobody says what a mount weighs (kg); it moves as its drive wants anyway.
MOUNT_MASS = 1.0
#: The mount counts as a cylinder as long as this (m) at least.
_SHORTEST_MOUNT = 0.01


def link_inertias(robot: Robot) -> Array:
    """Moments (n, 3) kg m² about the centres of mass and the axes of the links: solid cylinders, or boxes if flat."""
    width, height = robot.outline.sides.T
    squares = np.stack([height**2 + robot.pitches**2, width**2 + robot.pitches**2, width**2 + height**2], axis=-1)
    boxes = robot.link_masses[:, None] * squares / 12.0
    return np.where(width[:, None] > 0.0, boxes, cylinders(robot.link_masses, robot.body_radii, robot.pitches))


def mount_inertia(radius: float, length: float) -> Array:
    """Moments (3,) kg m² of the mount, a solid cylinder of `MOUNT_MASS`."""
    return cylinders(np.array(MOUNT_MASS), np.array(radius), np.array(max(length, _SHORTEST_MOUNT)))


def cylinders(masses: Array, radii: Array, lengths: Array) -> Array:
    """Moments (..., 3) kg m² of solid cylinders along z."""
    across, along = masses * (3.0 * radii**2 + lengths**2) / 12.0, masses * radii**2 / 2.0
    return np.stack([across, across, along], axis=-1)
