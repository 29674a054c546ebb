"""A stack of equal universal joints that the same cables move: each takes an equal share of the section's angles."""

from __future__ import annotations

import math

import numpy as np

from hognose.robot.joint_cable import lengths_through
from hognose.robot.section_cable import CableLaw
from hognose.robot.sections.kind import Array, Geometry, Piece


def told_apart(joints: int) -> float:
    """Up to which bend (rad), √(α² + β²), where the ends of so many joints are says both angles of the section.

    Beyond it the two joints or more, which do not stay in one plane, can lead to the same place otherwise [measured:
    of two it is so from 140° on, of three from 170°, of five from 220°].
    """
    return math.radians(min(70.0 + 30.0 * joints, 210.0))


class Joints:
    """Section i is k times the joint R_y(α_i/k) R_x(β_i/k) and a link of the pitch over k.

    The cables hold friction and stiffness of the joints alike, so all bend equally [assumed]. Where α and β are both
    bent the section does not stay in one plane: at 60° each and k = 6 its end is twisted by 2.6°.
    """

    name = "joints"
    takes = frozenset({"joints", "bending_stiffness_N_m2"})

    def fault(self, section: Geometry) -> str:
        """See `SectionKind.fault`."""
        if section.joints is None:
            return "a section of several joints needs `joints`, their number"
        link = section.pitch / section.joints
        if section.before + section.after >= link:
            return (
                f"the section is too short for its {section.joints} joints: each has {1e3 * link:g} mm of the pitch of "
                f"{1e3 * section.pitch:g} mm, and half_lengths add up to {1e3 * (section.before + section.after):g} "
                "mm. Take fewer joints, a longer pitch or shorter half_lengths"
            )
        bend, most = math.hypot(*section.bend_limits), told_apart(section.joints)
        if bend > most:
            return (
                f"at its limits in both axes the section bends by {math.degrees(bend):.3g}° in all; beyond "
                f"{math.degrees(most):.3g}° the places of its ends leave its angles open. Lower bend_limit_deg, or "
                "take more joints or two sections"
            )
        return ""

    def pieces(self, section: Geometry) -> tuple[Piece, ...]:
        """See `SectionKind.pieces`."""
        count = section.joints or 1
        return (Piece(1.0 / count, 1.0 / count, section.pitch / count),) * count

    def cables(
        self, section: Geometry, angles: Array, radius: Array, cosine: Array, sine: Array, entering: Array
    ) -> Array:
        """See `SectionKind.cables`."""
        count = section.joints or 1
        around = (angles / count, section.before, section.after, radius, cosine, sine)
        one = lengths_through(*around, radius)
        first = one if np.array_equal(entering, radius) else lengths_through(*around, entering)
        return count * one - (count - 1) * (section.before + section.after) + (first - one)

    def cable_law(self, section: Geometry) -> CableLaw:
        """See `SectionKind.cable_law`."""
        return CableLaw(section.before, section.after, joints=section.joints or 1)


JOINTS = Joints()
