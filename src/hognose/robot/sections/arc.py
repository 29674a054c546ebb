"""A section that bends along its whole length with constant curvature: a continuum arm's."""

from __future__ import annotations

import math

import numpy as np

from hognose.robot.section_cable import CableLaw
from hognose.robot.sections.kind import Array, Geometry, Piece


class Arc:
    """Section i is an arc of the pitch's length, bent by θ = √(α² + β²), whose end is turned by exp(α e_y + β e_x).

    Its end is at L (α (1 - cos θ)/θ², -β (1 - cos θ)/θ², sin θ/θ). The backbone keeps its length L, the pitch, unless
    there is a `length_range`: then L is a third coordinate of the section. Cables keep their
    distance from it, so that a cable at radius r and azimuth φ is r (α cos φ - β sin φ) shorter than the arc; where
    `disks` lead it, D of them at equal distances and the last at the end, it runs straight between them, in all
    S = sin(θ/2D)/(θ/2D) times that length [derived: the holes of two disks and their axes' chord are a trapezium].

    From a circle of radius r₀ at its beginning, a cable runs to that of the first disk on a slant, of the length
    √((r₀ - r)² + S² (l - r₀ w)(l - r w)) with l = L/D and w = (α cos φ - β sin φ)/D [derived: the two disks lie on rays
    from the centre of curvature, and the law of cosines]. Without disks the step is the same in all postures, and is
    left out.
    """

    name = "arc"
    takes = frozenset({"disks", "bending_stiffness_N_m2", "length_range"})

    def fault(self, section: Geometry) -> str:
        """See `SectionKind.fault`."""
        if section.before or section.after:
            return "a section that bends along its length has no joint: leave out its half_lengths, or make them [0, 0]"
        bend, (shortest, longest) = math.hypot(*section.bend_limits), section.lengths
        if not shortest <= section.pitch <= longest:
            return (
                f"length_range [{1e3 * shortest:g}, {1e3 * longest:g}] mm does not hold the pitch of "
                f"{1e3 * section.pitch:g} mm, which is the length at rest, where motor counts are 0: expected "
                "[shortest, longest] with the pitch between them"
            )
        if shortest == longest and section.length_range is not None:
            return "length_range leaves the section only one length: leave it out of a section that keeps its length"
        if bend * section.body_radius >= shortest:
            at, longer = ("", "pitch") if section.length_range is None else (", when it is shortest,", "length_range")
            return (
                f"at its limits the section bends by {math.degrees(bend):.3g}° in all,{at} to a radius of "
                f"{1e3 * shortest / bend:.3g} mm, tighter than the body's own {1e3 * section.body_radius:g} mm: "
                f"its inner side would fold. Lower bend_limit_deg, or take a longer {longer}"
            )
        return ""

    def pieces(self, section: Geometry) -> tuple[Piece, ...]:
        """See `SectionKind.pieces`."""
        return (Piece(1.0, 1.0, section.pitch, curved=True),)

    def cables(
        self, section: Geometry, angles: Array, radius: Array, cosine: Array, sine: Array, entering: Array
    ) -> Array:
        """See `SectionKind.cables`."""
        return self.cables_at(section, section.pitch, angles, radius, cosine, sine, entering)

    def cables_at(
        self,
        section: Geometry,
        length: Array | float,
        angles: Array,
        radius: Array,
        cosine: Array,
        sine: Array,
        entering: Array,
    ) -> Array:
        """As `cables`, of a section that has another length (T, 1) m than its pitch, and less that length."""
        bent = angles[:, :1] * cosine - angles[:, 1:] * sine
        beside = length - radius * bent
        if section.disks is not None:
            half = np.hypot(angles[:, :1], angles[:, 1:]) / (2 * section.disks)
            chord = np.sinc(half / math.pi)
            beside = chord * beside
            if not np.array_equal(entering, radius):
                part, bent = length / section.disks, bent / section.disks
                at_first, others = part - entering * bent, part - radius * bent
                slanted = np.sqrt((entering - radius) ** 2 + chord * chord * at_first * others)
                beside += slanted - chord * others
        return beside - length

    def cable_law(self, section: Geometry) -> CableLaw:
        """See `SectionKind.cable_law`."""
        return CableLaw(0.0, 0.0, arc=section.pitch, disks=section.disks or 0)


ARC = Arc()
