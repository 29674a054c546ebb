"""What the drive of an emulated motor knows of where the motor is: an encoder that counts, or one that is absolute."""

from __future__ import annotations

from dataclasses import dataclass

from hognose.drive.emulator.axis import Axis
from hognose.drive.emulator.objects import ACTUAL_POSITION, HOME_POSITION, MOVE_DISTANCE, Objects
from hognose.drive.network_spec import Kind

#: So long (s) an emulated motor takes for the distance that it moves after homing.
_MOVES = 0.1


@dataclass
class Encoder:
    """Counts are those of the motor less an origin, which is lost with the supply unless the encoder is absolute.

    Attributes
    ----------
    is_absolute
    is_referenced
        Whether the drive says that its position is referenced to its home position.
    origin : counts
        Of the motor, where the drive says 0.
    is_attained, has_failed
        What became of the last homing.
    """

    is_absolute: bool = False
    is_referenced: bool = True
    origin: float = 0.0
    is_attained: bool = False
    has_failed: bool = False

    def says(self, position: float) -> int:
        """What the drive says of a position (counts of the motor)."""
        return round(position - self.origin)

    def lose_supply(self, position: float) -> None:
        """Start anew where the motor is (counts): an encoder that counts begins at 0."""
        self.is_referenced = self.is_attained = self.has_failed = False
        if not self.is_absolute:
            self.origin = float(position)

    def home(self, axis: Axis, objects: Objects, kind: Kind) -> None:
        """Do what the homing method says; the only one that these drives know is the one that needs no switch."""
        method, distance = objects[0x6098, 0].value, objects[MOVE_DISTANCE[kind], 0].value
        position = objects[HOME_POSITION[kind], 0].value
        assert isinstance(distance, int), "a number"
        assert isinstance(position, int), "a number"
        self.is_attained = method == ACTUAL_POSITION[kind]
        self.has_failed = not self.is_attained
        if self.has_failed:
            return
        if distance:
            axis.target(round(axis.demanded) + distance, _MOVES)
        self.origin, self.is_referenced = axis.actual + distance - position, True

    def bits(self, homes: bool) -> int:
        """Bits of the statusword: 15 in all modes, 12 and 13 while the drive is in homing mode."""
        found = 0x8000 if self.is_referenced else 0
        if homes:
            found |= (0x1000 if self.is_attained else 0) | (0x2000 if self.has_failed else 0)
        return found
