"""What one kind of section is: the protocol of the files beside this one, and what they are told and say."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from hognose.robot.section_cable import CableLaw

Array = NDArray[np.float64]


class Piece(NamedTuple):
    """A part of a section that bends by fixed shares of the section's two angles.

    A straight piece begins with a universal joint R_y(a) R_x(b), a and b being its shares of α and β, and goes straight
    along +z behind it. A curved piece bends along its whole length with constant curvature and without twist: its end
    is turned by exp(a e_y + b e_x).
    """

    alpha: float
    beta: float
    length: float
    curved: bool = False


@dataclass(frozen=True)
class Geometry:
    """What a robot file says of one section; lengths in m, angles in rad.

    Attributes
    ----------
    pitch
        From where the section begins to where the next one does, without the tool.
    before, after
        h₁ and h₂ of each of its joints.
    body_radius
    bend_limits
        Largest |α| and |β| of the whole section.
    joints, axis_offset, disks
        Keys that only some kinds take; None if not given.
    length_range
        Shortest and longest a section gets that can change its length, whose pitch is that at rest; else None.
    """

    pitch: float
    before: float
    after: float
    body_radius: float
    bend_limits: tuple[float, float]
    joints: int | None = None
    axis_offset: float | None = None
    disks: int | None = None
    length_range: tuple[float, float] | None = None

    @property
    def lengths(self) -> tuple[float, float]:
        """How short and how long (m) it gets: its pitch, unless it can change its length."""
        return self.length_range or (self.pitch, self.pitch)


class SectionKind(Protocol):
    """One kind of section. All that is known of an arm with such sections follows from this.

    Its configuration is a pair of angles (α, β); both zero is straight along +z. It begins with its first joint at the
    end of the section before.
    """

    @property
    def name(self) -> str:
        """What `kind` says in a robot file."""
        ...

    @property
    def takes(self) -> frozenset[str]:
        """Keys of a robot file, of those that only some kinds have, that this kind must or may have."""
        ...

    def fault(self, section: Geometry) -> str:
        """What is wrong with a section and what to do about it, for a message; empty if nothing is."""
        ...

    def pieces(self, section: Geometry) -> tuple[Piece, ...]:
        """The section's body from its beginning to its end."""
        ...

    def cables(
        self, section: Geometry, angles: Array, radius: Array, cosine: Array, sine: Array, entering: Array
    ) -> Array:
        """Lengths (T, c) m of cables through the section at angles (T, 2) rad, less what is straight of every posture.

        At zero angles that is h₁ + h₂ for each cable that comes on the section's own circle: from the hole plane h₁
        before the first joint to that h₂ behind the last one, with the ways between the joints left out.

        Parameters
        ----------
        section
        angles : (T, 2) rad
        radius, cosine, sine : (c,)
            Circle (m) and azimuth of the cables' holes.
        entering : (c,)
            The circle (m) on which they come from the section before, or from the mount.
        """
        ...

    def cable_law(self, section: Geometry) -> CableLaw:
        """The law of its cables, whose derivatives mechanics take: that of `cables`."""
        ...
