"""What becomes of a move of the nose."""

from __future__ import annotations

from dataclasses import dataclass

from hognose.arguments import real
from hognose.steering.limits import Held
from hognose.units import LARGEST_LENGTH


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
