"""What shape the body of a section has: round, or flat; what of a robot file contradicts it."""

from __future__ import annotations

import math
from dataclasses import dataclass

#: What `body` says in a robot file.
SHAPES = ("round", "flat")
#: A flat body that is so many times as wide as it is high, or more, is a slip.
MOST_FLAT = 20.0


@dataclass(frozen=True)
class BodyShape:
    """The cross-section of a body about its centre line, the same all along a section; lengths in m.

    Attributes
    ----------
    sides
        Width along x and height along y of the section's frame, of a flat body; None of a round one.
    radius
        Of the round body, or of the smallest round one that contains the flat one.
    """

    sides: tuple[float, float] | None
    radius: float

    @classmethod
    def of(cls, body: str, diameter: float | None, width: float | None, height: float | None) -> BodyShape:
        """The shape of what a robot file says; a ValueError says in words what is wrong with it."""
        if body not in SHAPES:
            raise ValueError(f"body {body!r} is unknown; there are {', '.join(SHAPES)}")
        if body == "round":
            if diameter is None:
                raise ValueError('body_diameter is missing, as the body is round; body = "flat" has body_width instead')
            if width is not None or height is not None:
                key = "body_width" if width is not None else "body_height"
                raise ValueError(f'{key} is for a body that is flat: give body = "flat", too, or body_diameter alone')
            return cls(None, diameter / 2)
        if diameter is not None:
            raise ValueError("body_diameter is for a round body; a flat one has body_width and body_height instead")
        if width is None or height is None:
            missing = "body_width" if width is None else "body_height"
            raise ValueError(
                f"{missing} is missing: a flat body has body_width along x and body_height along y of its section"
            )
        if max(width, height) >= MOST_FLAT * min(width, height):
            raise ValueError(
                f"a flat body of {1e3 * width:g} by {1e3 * height:g} mm is "
                f"{max(width, height) / min(width, height):.3g} times as wide as it is high, expected less than "
                f"{MOST_FLAT:g}: are body_width and body_height right?"
            )
        return cls((width, height), math.hypot(width, height) / 2)

    @property
    def inner_radius(self) -> float:
        """Of the largest round body (m) within it."""
        return self.radius if self.sides is None else min(self.sides) / 2

    @property
    def words(self) -> str:
        """In a sentence: `45 mm diameter`, `25 by 50 mm`."""
        if self.sides is None:
            return f"{2e3 * self.radius:g} mm diameter"
        return f"{1e3 * self.sides[0]:g} by {1e3 * self.sides[1]:g} mm"

    def holds_cable(self, radius: float, azimuth_deg: float) -> bool:
        """Whether a cable on a circle of a radius (m) about the centre line is within the body."""
        if self.sides is None:
            return radius < self.radius
        along = math.radians(azimuth_deg)
        x, y = abs(radius * math.cos(along)), abs(radius * math.sin(along))
        return x < self.sides[0] / 2 and y < self.sides[1] / 2
