"""What becomes of a move of the nose."""

from __future__ import annotations

from dataclasses import dataclass

from hognose.steering.limits import Held


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
