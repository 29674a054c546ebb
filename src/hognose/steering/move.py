"""What becomes of a move of the nose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hognose.arguments import real
from hognose.steering.grown_curve import on_grid
from hognose.steering.limits import Held
from hognose.steering.way import ArmWay, PlacedArm
from hognose.units import LARGEST_LENGTH

#: Feeds, speeds and cables hold a move this close (m) to their limits.
_CLOSE = 1e-6


@dataclass(frozen=True)
class Move:
    """What became of a move.

    Attributes
    ----------
    advanced : m
        How far the nose went along its path; negative when it retreated.
    turn : (2,) rad/m
        The turn that was taken, no more than the joints can bend.
    held_by
        Why the nose went less far than asked, or None.
    limited_by
        Why the turn is less than asked, or None.
    """

    advanced: float
    turn: tuple[float, float]
    held_by: Held | None
    limited_by: Held | None


def given_length(value: float, name: str) -> float:
    """A length (m) that was given as an argument of this name; an InputError if it is none."""
    expected = f"a length of 0 m or more, at most {LARGEST_LENGTH:,.0f} m"
    return real(name, value, expected, lambda given: 0 <= given <= LARGEST_LENGTH)


def shortened(
    way: ArmWay, good: PlacedArm, arm: PlacedArm, broken: Callable[[PlacedArm], Held | None]
) -> tuple[PlacedArm, Held | None]:
    """The arm, or the one closest to it from a good one on that breaks nothing, and what is broken beyond that."""
    held = broken(arm)
    if held is None:
        return arm, None
    while abs(arm.depth - good.depth) > _CLOSE:
        middle = way.arm(float(on_grid(0.5 * (good.depth + arm.depth))))
        why = broken(middle)
        good, arm = (middle, arm) if why is None else (good, middle)
        if why is not None and why.reason != held.reason:
            held = why
    return good, held
