"""Two hinges at a distance from each other and the rigid link behind them: α about y, then β about x."""

from __future__ import annotations

import numpy as np

from hognose.robot.section_cable import CableLaw
from hognose.robot.sections.kind import Array, Geometry, Piece


class Hinges:
    """Section i is R_y(α_i), a shift by the axis offset o, R_x(β_i), and the rest of the pitch; all shifts along +z.

    Cables run straight from the hole plane h₁ before the first hinge to the one h₂ behind the second.
    """

    name = "hinges"
    takes = frozenset({"axis_offset", "bending_stiffness_N_m2"})

    def fault(self, section: Geometry) -> str:
        """See `SectionKind.fault`."""
        if section.axis_offset is None:
            return 'two hinges need axis_offset, the distance of their axes; for axes that cross take kind "link"'
        if section.axis_offset + section.before + section.after >= section.pitch:
            return (
                f"the section is too short for its hinges: axis_offset and half_lengths add up to "
                f"{1e3 * (section.axis_offset + section.before + section.after):g} mm, which leaves nothing of the "
                f"pitch of {1e3 * section.pitch:g} mm for the link"
            )
        return ""

    def pieces(self, section: Geometry) -> tuple[Piece, ...]:
        """See `SectionKind.pieces`."""
        offset = section.axis_offset or 0.0
        return Piece(1.0, 0.0, offset), Piece(0.0, 1.0, section.pitch - offset)

    def linear(self, section: Geometry) -> bool:
        """See `SectionKind.linear`."""
        return False

    def cables(self, section: Geometry, angles: Array, radius: Array, cosine: Array, sine: Array) -> Array:
        """See `SectionKind.cables`."""
        ca, sa = np.cos(angles[:, :1]), np.sin(angles[:, :1])
        cb, sb = np.cos(angles[:, 1:]), np.sin(angles[:, 1:])
        x, y, offset = radius * cosine, radius * sine, section.axis_offset or 0.0
        across, along = y * cb - section.after * sb, y * sb + section.after * cb + offset
        dx, dy = ca * x + sa * along - x, across - y
        dz = -sa * x + ca * along + section.before
        return np.sqrt(dx * dx + dy * dy + dz * dz) - offset

    def cable_law(self, section: Geometry) -> CableLaw:
        """See `SectionKind.cable_law`."""
        return CableLaw(section.before, section.after, section.axis_offset or 0.0)


HINGES = Hinges()
