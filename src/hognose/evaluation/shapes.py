"""Shapes that arms of few sections are drawn in the literature: C, S and screws, seeded, in lengths of the arm.

Published figures of following with continuum arms are averages over such shapes; the shapes themselves are not given.
These are drawn from the words alone, so figures of the two sets stand beside each other and cannot be compared closely.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from hognose.evaluation.curves import Profile, drawn, eased
from hognose.path import Path

Array = NDArray[np.float64]

#: The bent part is so much longer than the arm, so that the tip does not come to its end; its curvature rises from
#: zero, and falls, over such a part of the arm.
_LONGER, _RAMP = 1.15, 0.2


def shape(kind: str, arm: float, rng: np.random.Generator) -> Path:
    """A path with a straight run as long as the arm (m), and a shape behind it.

    Parameters
    ----------
    kind
        In `SHAPES`. C bends by 60 to 150 degrees one way, S by 30 to 90 degrees one way and then the other, a screw by
        90 to 240 degrees while its plane turns by 90 to 270 degrees. A robot shape is one that an arm of three arcs can
        take: each bends by 15 to 60 degrees in some direction.
    arm : m
    rng
    """
    length = _LONGER * arm
    profile = SHAPES[kind](arm, rng)

    def gentle(s: Array) -> Array:
        return profile(s) * eased(s, length, _RAMP * arm)[:, None]

    return drawn(gentle, length, arm, 0.015 * arm)


def _c(arm: float, rng: np.random.Generator) -> Profile:
    bend, azimuth = math.radians(rng.uniform(60.0, 150.0)) / arm, rng.uniform(0.0, 2.0 * math.pi)
    return lambda s: np.full((len(s), 1), bend) * [math.cos(azimuth), math.sin(azimuth)]


def _s(arm: float, rng: np.random.Generator) -> Profile:
    # A half wave of half the arm's length bends by its height times arm/π.
    top, azimuth = math.radians(rng.uniform(30.0, 90.0)) * math.pi / arm, rng.uniform(0.0, 2.0 * math.pi)
    return lambda s: top * np.sin(2.0 * math.pi * s / arm)[:, None] * [math.cos(azimuth), math.sin(azimuth)]


def _screw(arm: float, rng: np.random.Generator) -> Profile:
    bend, twist = np.radians(rng.uniform([90.0, 90.0], [240.0, 270.0])) / arm
    side = rng.choice([-1.0, 1.0])
    return lambda s: bend * np.stack([np.cos(twist * s), side * np.sin(twist * s)], axis=1)


def _robot(arm: float, rng: np.random.Generator) -> Profile:
    bends, azimuths = np.radians(rng.uniform(15.0, 60.0, 3)) / (arm / 3.0), rng.uniform(0.0, 2.0 * math.pi, 3)
    each = bends[:, None] * np.stack([np.cos(azimuths), np.sin(azimuths)], axis=1)
    return lambda s: each[np.minimum((3.0 * s / arm).astype(int), 2)]


#: What draws the curvature of each: (length of the arm in m, random numbers) to a profile.
SHAPES: dict[str, Callable[[float, np.random.Generator], Profile]] = {
    "C": _c,
    "S": _s,
    "screw": _screw,
    "robot": _robot,
}
#: The kinds over which a published figure is an average.
PUBLISHED_KINDS = ("S", "C", "robot")
