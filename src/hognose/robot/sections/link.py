"""A universal joint and the rigid link behind it: paper eqs. 13–16 and table 1."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from hognose.kernels import kernel
from hognose.robot.joint_cable import lengths_through
from hognose.robot.kinematics import angles_of, positions_of, turned
from hognose.robot.section_cable import CableLaw
from hognose.robot.sections.kind import Geometry, Piece
from hognose.robot.sections.model import Array


@kernel()
def _bulges(low: NDArray, high: NDArray, lengths: NDArray, spins: NDArray, swings: NDArray, out: NDArray) -> None:
    """How far (m) each joint can leave its straight line while angles (m, n, 2) go linearly from low to high.

    A motion leaves the chord of its ends by at most an eighth of its largest acceleration, which is summed up
    along the arm from bounds of each link's angular speed and acceleration (docs/certificate.md).
    """
    for m in range(low.shape[0]):
        xx, xy, xz = 1.0, 0.0, 0.0
        yx, yy, yz = 0.0, 1.0, 0.0
        zx, zy, zz = 0.0, 0.0, 1.0
        spin_x, spin_y, spin_z = spins[m, 0], spins[m, 1], spins[m, 2]
        angular_acceleration, acceleration = 0.0, swings[m]
        angular_speed = math.sqrt(spin_x * spin_x + spin_y * spin_y + spin_z * spin_z)
        out[m, 0] = acceleration / 8.0
        for i in range(lengths.size):
            alpha, beta = low[m, i, 0], low[m, i, 1]
            a, b = high[m, i, 0] - alpha, high[m, i, 1] - beta
            # alpha turns about the old y axis, beta about the new x axis.
            spin_x, spin_y, spin_z = spin_x + a * yx, spin_y + a * yy, spin_z + a * yz
            xx, xy, xz, yx, yy, yz, zx, zy, zz = turned(xx, xy, xz, yx, yy, yz, zx, zy, zz, alpha, beta)
            spin_x, spin_y, spin_z = spin_x + b * xx, spin_y + b * xy, spin_z + b * xz
            angular_acceleration += angular_speed * math.sqrt(a * a + b * b) + abs(a * b)
            spin = math.sqrt(spin_x * spin_x + spin_y * spin_y + spin_z * spin_z)
            angular_speed = spin + angular_acceleration
            acceleration += lengths[i] * (angular_acceleration + angular_speed * angular_speed)
            out[m, i + 1] = acceleration / 8.0


class RigidLink:
    """Section i is the universal joint R_y(α_i) R_x(β_i) and a straight link along +z of its frame."""

    chords = 1

    def angles(self, joints: Array) -> Array:
        """See `SectionModel.angles`."""
        return angles_of(joints)

    def positions(self, angles: Array, feeds: Array, lengths: Array) -> tuple[Array, Array]:
        """See `SectionModel.positions`."""
        return positions_of(angles, feeds, lengths)

    def vertices(self, joints: Array, angles: Array | None = None) -> Array:
        """The joints themselves."""
        return joints

    def arcs(self, lengths: Array) -> Array:
        """See `SectionModel.arcs`."""
        return np.repeat(lengths / self.chords, self.chords)

    def smooth(self, lengths: Array) -> NDArray[np.bool_]:
        """Nowhere: every link begins with a joint."""
        return np.zeros(lengths.size * self.chords - 1, dtype=np.bool_)

    def sagitta(self, lengths: Array, limits: Array) -> Array:
        """None: links are straight."""
        return np.zeros(lengths.size)

    def sharpest(self, lengths: Array, limits: Array) -> Array:
        """See `SectionModel.sharpest`.

        Two chords a, b of a circle of curvature κ make an angle θ with each other where
        κ √(a² + b² + 2ab cos θ) = 2 sin θ, and of no curve of at most that curvature a larger one; α and β are no
        larger than θ. The first joint has the run behind it instead of a chord. Joints glide where the curvature times
        the chord is at most √2 (docs/following.md).
        """
        behind, bend = np.append(0.0, lengths[:-1]), limits.min(axis=1)
        bending = 2 * np.sin(bend) / np.sqrt(lengths**2 + behind**2 + 2 * lengths * behind * np.cos(bend))
        return np.minimum(bending, math.sqrt(2.0) / np.maximum(lengths, behind))

    def bulges(self, low: Array, high: Array, lengths: Array, spin: Array, swing: Array) -> Array:
        """See `SectionModel.bulges`."""
        out = np.empty((low.shape[0], lengths.size + 1))
        _bulges(low, high, lengths, spin, swing, out)
        return out


RIGID_LINK = RigidLink()


class Link:
    """One universal joint and one link, beside sections of other kinds; arms of links alone are a `RigidLink`."""

    name = "link"
    takes: frozenset[str] = frozenset()

    def fault(self, section: Geometry) -> str:
        """See `SectionKind.fault`."""
        if section.before + section.after >= section.pitch:
            return (
                f"half_lengths add up to {1e3 * (section.before + section.after):g} mm, which leaves nothing of "
                f"the pitch of {1e3 * section.pitch:g} mm for the link"
            )
        return ""

    def pieces(self, section: Geometry) -> tuple[Piece, ...]:
        """See `SectionKind.pieces`."""
        return (Piece(1.0, 1.0, section.pitch),)

    def cables(
        self, section: Geometry, angles: Array, radius: Array, cosine: Array, sine: Array, entering: Array
    ) -> Array:
        """See `SectionKind.cables`."""
        return lengths_through(angles, section.before, section.after, radius, cosine, sine, entering)

    def cable_law(self, section: Geometry) -> CableLaw:
        """See `SectionKind.cable_law`."""
        return CableLaw(section.before, section.after)


LINK = Link()
