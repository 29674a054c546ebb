"""Tensions between the steps, where motors go linearly from one set-point to the next and the weight does not."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.planning.motion import Motion
from hognose.ties import first_largest, first_smallest

Array = NDArray[np.float64]

#: Where within a step the arm is let come to rest: tensions are least near three quarters as often as in the middle.
_WITHIN = (0.25, 0.5, 0.75)


@dataclass(frozen=True)
class TensionsBetween:
    """The least and the largest tension (N) on the way from a step to the next, with step and cable (0-based).

    Infinitely far from any limit where steps are short, or nothing was looked at.
    """

    least: float = math.inf
    least_at: tuple[int, int] = (0, 0)
    largest: float = -math.inf
    largest_at: tuple[int, int] = (0, 0)


def tensions_between(motion: Motion, taken: Array | float = 0.0) -> TensionsBetween:
    """The tensions within those steps in which a cable may become slack, or be pulled too much.

    What tolerances take (T, c) N at the steps is taken off, or added to the largest.

    In the middle, a cable is commanded by h² |c''| / 8 too much or too little, where c are the commanded lengths of the
    steps. If the pose stayed, its tension would change by k times that; the arm gives way, so it is mostly far less.
    Only where even that could matter, the arm is let come to rest with what is commanded at some places of the step.
    Motions of two steps, whose bend is not known, and steps where the arm buckles are not looked at.
    """
    held, mechanics = motion.held, motion.task.mechanics
    if held is None or mechanics is None or len(motion.time) < 3 or not held.is_held.all():
        return TensionsBetween()
    low, high = np.minimum(*_sides(held.tensions)), np.maximum(*_sides(held.tensions))
    taken = np.maximum(*_sides(np.broadcast_to(taken, held.tensions.shape)))
    off = taken + held.spring_constants[1:] * _beside_a_line(motion.time, held.commanded_lengths)
    rows = np.flatnonzero(((low <= off) | (high + off > mechanics.tension_max)).any(axis=1))
    rows = rows[(held.load_factor[rows] > 1.0) & (held.load_factor[rows + 1] > 1.0)]
    if not rows.size:
        return TensionsBetween()
    places = np.repeat(_WITHIN, len(rows))[:, None]
    rows = np.tile(rows, len(_WITHIN))

    def within(values: Array) -> Array:
        shares = places.reshape(-1, *(1,) * (values.ndim - 1))
        return (1.0 - shares) * values[rows] + shares * values[rows + 1]

    gravity = motion.task.gravity(motion.at)
    tensions = mechanics.settle(*map(within, (motion.postures, held.commanded_lengths, gravity))).tensions
    lowest, highest = tensions - taken[rows], tensions + taken[rows]
    (low_row, low_cable), (high_row, high_cable) = first_smallest(lowest), first_largest(highest)
    return TensionsBetween(
        float(lowest[low_row, low_cable]),
        (int(rows[low_row]), low_cable),
        float(highest[high_row, high_cable]),
        (int(rows[high_row]), high_cable),
    )


def _sides(values: Array) -> tuple[Array, Array]:
    return values[:-1], values[1:]


def _beside_a_line(time: Array, lengths: Array) -> Array:
    """How far (T-1, c) m lengths (T, c) m at the steps are off a straight line in the middle of each, by their bend."""
    steps = np.diff(time)[:, None]
    bend = np.abs(np.diff(np.diff(lengths, axis=0) / steps, axis=0)) / (0.5 * (steps[1:] + steps[:-1]))
    bend = np.pad(bend, ((1, 1), (0, 0)), mode="edge")
    return np.maximum(*_sides(bend)) * steps**2 / 8.0
