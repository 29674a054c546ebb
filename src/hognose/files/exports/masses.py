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


def link_inertia(robot: Robot, section: int, mass: float, length: float) -> Array:
    """Moments (3,) kg m² of a part of a section (0-based) about its middle: a cylinder, or a box if it is flat."""
    width, height = robot.outline.sides[section].tolist()
    if width > 0.0:
        return mass * np.array([height**2 + length**2, width**2 + length**2, width**2 + height**2]) / 12.0
    return cylinders(np.array(mass), np.array(robot.body_radii[section]), np.array(length))


def mount_inertia(radius: float, length: float) -> Array:
    """Moments (3,) kg m² of the mount, a solid cylinder of `MOUNT_MASS`."""
    return cylinders(np.array(MOUNT_MASS), np.array(radius), np.array(max(length, _SHORTEST_MOUNT)))


def cylinders(masses: Array, radii: Array, lengths: Array) -> Array:
    """Moments (..., 3) kg m² of solid cylinders along z."""
    across, along = masses * (3.0 * radii**2 + lengths**2) / 12.0, masses * radii**2 / 2.0
    return np.stack([across, across, along], axis=-1)
