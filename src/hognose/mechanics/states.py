"""What is found of an arm at T steps: how its cables hold it, and where it comes to rest."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from hognose.cached import cached_array
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
    load_factor : (T,)
        By how much all tensions and the weight would have to grow until it buckles; below 1 where it does.
    softest
        What works out `smallest_stiffness`, which takes longer than all the rest.
    """

    cable_lengths: Array
    tensions: Array
    spring_constants: Array
    left: Array
    status: NDArray[np.int64]
    load_factor: Array
    softest: Callable[[], Array]

    def __post_init__(self) -> None:
        _lock(self)

    @cached_array
    def smallest_stiffness(self) -> Array:
        """Smallest eigenvalue (T,) N m/rad of the tangent stiffness, motors held; negative where the arm buckles."""
        return self.softest()

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
        names = [field.name for field in dataclasses.fields(Held) if field.name != "softest"]
        columns = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
        return Held(**columns, softest=partial(_softest, parts))


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


def _softest(parts: Sequence[Held]) -> Array:
    return np.concatenate([part.smallest_stiffness for part in parts])


def _lock(found: Held | Settled) -> None:
    for field in dataclasses.fields(found):
        value = getattr(found, field.name)
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
