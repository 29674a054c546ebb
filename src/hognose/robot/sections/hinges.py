"""Two hinges at a distance from each other and the rigid link behind them: α about y, then β about x."""

from __future__ import annotations

from hognose.robot.joint_cable import lengths_through
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

    def cables(
        self, section: Geometry, angles: Array, radius: Array, cosine: Array, sine: Array, entering: Array
    ) -> Array:
        """See `SectionKind.cables`."""
        offset = section.axis_offset or 0.0
        joint = (angles, section.before, section.after, radius, cosine, sine, entering)
        return lengths_through(*joint, offset) - offset

    def cable_law(self, section: Geometry) -> CableLaw:
        """See `SectionKind.cable_law`."""
        return CableLaw(section.before, section.after, section.axis_offset or 0.0)


HINGES = Hinges()
