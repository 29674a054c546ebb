"""What is found of an arm at T steps: how its cables hold it, and where it comes to rest."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.mechanics.tensions import HELD, NOT_HELD

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Held:
    """How cables hold an arm in T poses.

    Attributes
    ----------
    cable_lengths : (T, c) m
        From the hole plane before the first joint to the disk they are fixed to.
    tensions : (T, c) N
        Those closest to the pretension that hold the arm.
    spring_constants : (T, c) N/m
    left : (T, 2n) N m
        Torques that no tensions within the bounds balance: zero, to rounding, where the arm is held.
    status : (T,)
        `HELD`, `NOT_HELD` or `UNDECIDED` of `hognose.mechanics`.
    smallest_stiffness : (T,) N m/rad
        Smallest eigenvalue of the tangent stiffness with the motors held; negative where the arm buckles.
    load_factor : (T,)
        By how much all tensions and the weight would have to grow until it buckles; below 1 where it does.
    """

    cable_lengths: Array
    tensions: Array
    spring_constants: Array
    left: Array
    status: NDArray[np.int64]
    smallest_stiffness: Array
    load_factor: Array

    def __post_init__(self) -> None:
        _lock(self)

    @property
    def stretch(self) -> Array:
        """By how much (T, c) m each cable is longer than without tension."""
        return self.tensions / self.spring_constants

    @property
    def commanded_lengths(self) -> Array:
        """Lengths (T, c) m that the motors must command: the geometric ones without the stretch."""
        return self.cable_lengths - self.stretch

    @property
    def is_held(self) -> NDArray[np.bool_]:
        """Where (T,) tensions within the bounds balance the weight."""
        return self.status == HELD

    @property
    def cannot_be_held(self) -> NDArray[np.bool_]:
        """Where (T,) it is proven that no tensions within the bounds do."""
        return self.status == NOT_HELD

    @staticmethod
    def joined(parts: Sequence[Held]) -> Held:
        """One after the other."""
        names = [field.name for field in dataclasses.fields(Held)]
        return Held(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


@dataclass(frozen=True, eq=False)
class Settled:
    """Where an arm comes to rest at T steps.

    Attributes
    ----------
    angles : (T, n, 2) rad
    tensions : (T, c) N
        Zero in cables that are slack.
    status : (T,)
        `STABLE`, `AT_LIMIT` or `UNSETTLED` of `hognose.mechanics`.
    tip_shift : (T, 3) m
        From the planned tip to the reached one, in the arm's own axes.
    is_stable : (T,)
        Where it rests on its cables alone. Elsewhere it leans on a joint limit, or no rest was found: then the arm has
        buckled or slumped, and where it ends depends on the way there.
    """

    angles: Array
    tensions: Array
    status: NDArray[np.int64]
    tip_shift: Array
    is_stable: NDArray[np.bool_]

    def __post_init__(self) -> None:
        _lock(self)


def _lock(found: Held | Settled) -> None:
    for field in dataclasses.fields(found):
        getattr(found, field.name).flags.writeable = False
