"""A snake arm on a slider: its geometry as arrays, and what follows from joint angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.arguments import coordinates, floats, instance
from hognose.cached import cached_property
from hognose.errors import InputError
from hognose.robot import cable_angles, cables, mixed_cables
from hognose.robot.arrays import arrays_of, frozen, groups_of
from hognose.robot.bends import opened
from hognose.robot.courses import CableCourses
from hognose.robot.extension import as_long, bounds_of
from hognose.robot.fingerprint import fingerprint_of
from hognose.robot.outline import Outline, outline_of
from hognose.robot.sections import MixedSections
from hognose.robot.spec import RobotSpec

Array = NDArray[np.float64]

#: Whole numbers up to this are exact when they are computed from lengths.
MOST_COUNTS = 2**53


@dataclass(frozen=True, eq=False)
class Robot(CableCourses):
    """An arm of n sections on a slider; all lengths in m, all angles in rad.

    Section i is a universal joint and the link behind it, or of another kind: see `model`. The tool is rigid with the
    last section and belongs to its length, so the last joint position is the nose of the arm. Cables are numbered
    section by section.

    Attributes
    ----------
    spec
        The robot file this was made from.
    link_lengths : (n,)
        Distance from each joint to the next; the last one reaches to the tip. Of sections that extend, at rest.
    joint_before, joint_after : (n,)
        h₁ and h₂: distance of the hole planes before and after each joint centre.
    body_radii : (n,)
        Radius of each link's body; of the round one that contains it, if it is flat: see `outline`.
    bend_limits : (n, 2)
        Largest |α| and |β|; `bend_bounds` has both sides.
    link_masses : (n,)
        In kg, without the tool load.
    centres_of_mass : (n,)
        Distance of each link's centre of mass from its joint, along the link.
    cable_sections : (c,) int
        The section (0-based) at whose far disk each cable is fixed.
    cable_radii, cable_azimuths : (c,)
        Polar position of each cable's holes.
    travel_per_count : (c,)
        Cable travel of one motor count.
    """

    spec: RobotSpec
    link_lengths: Array
    joint_before: Array
    joint_after: Array
    body_radii: Array
    bend_limits: Array
    link_masses: Array
    centres_of_mass: Array
    cable_sections: NDArray[np.int64]
    cable_radii: Array
    cable_azimuths: Array
    travel_per_count: Array

    @classmethod
    def from_spec(cls, spec: RobotSpec) -> Robot:
        """The robot that a validated robot file describes."""
        instance("spec", spec, RobotSpec, "a RobotSpec; `hognose.load_robot` reads one from a file")
        return cls(spec=spec, **arrays_of(spec))

    @property
    def name(self) -> str:
        """The robot's name."""
        return self.spec.name

    @property
    def assumed(self) -> tuple[str, ...]:
        """Keys of the robot file whose values nobody published."""
        return self.spec.assumed

    @property
    def tool_mass(self) -> float:
        """Mass (kg) of the load at the tip."""
        return self.spec.tool_mass

    @property
    def straight_links(self) -> bool:
        """Whether every section is one straight chord."""
        return not isinstance(self.model, MixedSections) and bool(np.all(np.equal(self.model.chords, 1)))

    @cached_property
    def chord_sections(self) -> NDArray[np.int64]:
        """The section (0-based) of every chord (p,) of the body's centre line, from the base to the tip."""
        return frozen(np.repeat(np.arange(self.sections), self.model.chords), np.int64)

    @cached_property
    def chord_radii(self) -> Array:
        """How thick (p,) m the body is round every chord: its section's radius, and what the chord leaves out."""
        return frozen(self.body_radii[self.chord_sections] + self.model.sagitta(self.link_lengths, self.bend_limits))

    @cached_property
    def outline(self) -> Outline:
        """The capsules that contain the body: those of the chords, and closer ones where it is flat."""
        shapes = [group.shape for group in self.spec.section for _ in range(group.count)]
        return outline_of(shapes, self.model, self.link_lengths, self.chord_sections, self.chord_radii)

    @property
    def sections(self) -> int:
        """Number of sections n."""
        return self.link_lengths.size

    @cached_property
    def extends(self) -> bool:
        """Whether any section can change its length."""
        return bool(self.extending.any())

    @cached_property
    def length_bounds(self) -> Array:
        """How short and how long (n, 2) m every section gets; twice its link length if it does not extend."""
        return frozen(bounds_of([section for _, section in self.section_kinds], self.link_lengths))

    @property
    def length(self) -> float:
        """Length (m) from the first joint to the tip."""
        return float(self.link_lengths.sum())

    @property
    def reach(self) -> float:
        """How far (m) arm and slider reach along a path."""
        return min(self.length, self.spec.feed.max)

    @cached_property
    def fingerprint(self) -> str:
        """A short digest of every value of the robot: two robots with the same one move alike."""
        return fingerprint_of(self.spec)

    @cached_property
    def straight_cable_lengths(self) -> Array:
        """Cable lengths (c,) m of the straight arm: the zero of the motor counts."""
        return frozen(self.cable_lengths(np.zeros((self.sections, 2))))

    @cached_property
    def bend_bounds(self) -> Array:
        """Lowest and highest α and β (n, 2, 2); a side that is closed is open by `hognose.robot.bends.CLOSED`."""
        return frozen(opened(np.radians([group.bend_ranges for group in groups_of(self.spec)])))

    def angles(self, joints: ArrayLike) -> Array:
        """Joint angles from joint positions: the inverse resolution (eqs. 14–16), quadrant-safe.

        Parameters
        ----------
        joints : (..., n+1, 3) m
            Positions of the joints and the tip. The slider points along +z.

        Returns
        -------
        (..., n, 2) rad
            α and β of every section; α in (-π, π], β in [-π/2, π/2].

        Raises
        ------
        InputError
            Wrong shape, or values that are not finite.
        """
        array = coordinates("joints", joints, f"(..., {self.sections + 1}, 3)")
        return self.model.angles(_flat(array)).reshape(*array.shape[:-2], self.sections, 2)

    def section_lengths(self, joints: ArrayLike) -> Array:
        """Lengths of all sections from joint positions: the link lengths, but of sections that extend.

        Of those that is how long an arc is that begins in the direction in which the one before it ends.

        Parameters
        ----------
        joints : (..., n+1, 3) m
            As in `angles`, errors, too.

        Returns
        -------
        (..., n) m
        """
        array = coordinates("joints", joints, f"(..., {self.sections + 1}, 3)")
        found = np.array(np.broadcast_to(self.link_lengths, (*array.shape[:-2], self.sections)))
        if self.extends and isinstance(self.model, MixedSections):
            lengths = self.model.lengths(_flat(array), self.model.angles(_flat(array)))
            np.copyto(found, lengths.reshape(found.shape), where=self.model.extends)
        return found

    def joint_positions(self, angles: ArrayLike, feed: ArrayLike = 0.0, lengths: ArrayLike | None = None) -> Array:
        """Positions of all joints and the tip (eq. 13) in the slider's frame.

        Parameters
        ----------
        angles : (..., n, 2) rad
        feed : (...) m
            Position of the first joint along z; broadcast against the leading axes of `angles`.
        lengths : (..., n) m, optional
            Of the sections; as at rest unless given, and never else of sections that do not extend.

        Returns
        -------
        (..., n+1, 3) m

        Raises
        ------
        InputError
            Wrong shapes, or values that are not finite.
        """
        return self._forward(angles, feed, lengths)[0]

    def tip_pose(self, angles: ArrayLike, feed: ArrayLike = 0.0, lengths: ArrayLike | None = None) -> Array:
        """T_slider_tip, the pose (..., 4, 4) of the nose (eq. 13); arguments as in `joint_positions`."""
        joints, frames = self._forward(angles, feed, lengths)
        pose = np.zeros((*frames.shape[:-2], 4, 4))
        pose[..., :3, :3] = frames
        pose[..., :3, 3], pose[..., 3, 3] = joints[..., -1, :], 1.0
        return pose

    def cable_lengths(self, angles: ArrayLike, lengths: ArrayLike | None = None) -> Array:
        """Exact length of every cable, from the hole plane before joint 1 to the disk it is fixed to.

        Parameters
        ----------
        angles : (..., n, 2) rad
        lengths : (..., n) m, optional
            Of the sections, as in `joint_positions`.

        Returns
        -------
        (..., c) m
            In the robot's cable order. The run behind the first joint does not change and is not counted.

        Raises
        ------
        InputError
            Wrong shape, or values that are not finite.
        """
        array = floats("angles", angles, f"(..., {self.sections}, 2)", "rad")
        if self.plain_cables:
            self._as_long(lengths, array.shape[:-2])
            joints = (self.joint_before, self.joint_after, self.first_cables[:-1])
            found = cables.lengths_of(_flat(array), *joints, self.cable_radii, self.cable_azimuths, self.cable_runs)
        else:
            extended = self._as_long(lengths, array.shape[:-2])
            found = mixed_cables.lengths_of(_flat(array), *self.courses, extended)
        return found.reshape(*array.shape[:-2], self.cables)

    def angles_from_cables(self, cable_lengths: ArrayLike, near: ArrayLike) -> Array:
        """Joint angles that belong to cable lengths: least squares over each section's own cables, from the base on.

        Parameters
        ----------
        cable_lengths : (T, c) m
        near : (T, n, 2) rad
            Where to begin: the search is Newton's.

        Returns
        -------
        (T, n, 2) rad
            From the first section for which none were found they are NaN. Errors as of `cable_lengths`.
        """
        lengths = coordinates("cable_lengths", cable_lengths, f"(T, {self.cables})")
        begin = floats("near", near, f"({len(lengths)}, {self.sections}, 2)", "rad")
        if not self.plain_cables:
            return mixed_cables.angles_of(lengths, begin, *self.courses)[0]
        joints = (self.joint_before, self.joint_after, self.first_cables)
        return cable_angles.angles_of(lengths, begin, *joints, self.cable_radii, self.cable_azimuths, self.cable_runs)

    def lengths_from_cables(self, cable_lengths: ArrayLike, near: ArrayLike) -> Array:
        """Section lengths (T, n) m that belong to cable lengths, as `angles_from_cables` has the angles.

        The link lengths, but of sections that extend: cables determine both, least squares where there are more.
        """
        lengths = coordinates("cable_lengths", cable_lengths, f"(T, {self.cables})")
        begin = floats("near", near, f"({len(lengths)}, {self.sections}, 2)", "rad")
        found = np.repeat(self.link_lengths[None], len(lengths), axis=0)
        if self.extends and isinstance(self.model, MixedSections):
            own = mixed_cables.angles_of(lengths, begin, *self.courses)[1]
            np.copyto(found, own, where=self.model.extends)
        return found

    def lengths_of_counts(self, counts: ArrayLike) -> Array:
        """Cable lengths (..., c) m at motor counts (..., c): undoes `motor_counts`, but for its rounding.

        Raises
        ------
        InputError
            Wrong shape, or counts beyond what a number holds exactly.
        """
        array = floats("counts", counts, f"(..., {self.cables})", "counts", MOST_COUNTS)
        return self.straight_cable_lengths + array * self.travel_per_count

    def motor_counts(self, cable_lengths: ArrayLike) -> NDArray[np.int64]:
        """Motor counts (..., c) for cable lengths (..., c) m: zero at the straight arm, positive pays out.

        Raises
        ------
        InputError
            Wrong shape, values that are not finite, or lengths whose counts are beyond what a number holds exactly.
        """
        array = coordinates("cable_lengths", cable_lengths, f"(..., {self.cables})")
        counts = np.rint((array - self.straight_cable_lengths) / self.travel_per_count)
        if not (np.abs(counts) <= MOST_COUNTS).all():
            worst = np.unravel_index(int(np.argmax(np.abs(counts))), counts.shape)
            raise InputError(
                f"cable_lengths: {array[worst]:.4g} m of cable {worst[-1] + 1} are {abs(counts[worst]):.3g} counts "
                f"of its motor; only {MOST_COUNTS:,} are exact. Are the lengths in m, and the transmission right?"
            )
        return counts.astype(np.int64)

    def _as_long(self, lengths: ArrayLike | None, leading: tuple[int, ...]) -> Array | None:
        """Lengths (T, n) m of sections for so many poses; None for those at rest."""
        return None if lengths is None else as_long(self.name, lengths, leading, self.link_lengths, self.length_bounds)

    def _forward(self, angles: ArrayLike, feed: ArrayLike, lengths: ArrayLike | None) -> tuple[Array, Array]:
        array = floats("angles", angles, f"(..., {self.sections}, 2)", "rad")
        leading, given = array.shape[:-2], coordinates("feed", feed, "(...)")
        try:
            feeds = np.array(np.broadcast_to(given, leading), order="C")
        except ValueError:
            raise InputError(f"feed: shape {np.shape(feed)} does not fit the steps {leading} of angles") from None
        own = self._as_long(lengths, leading)
        own = self.link_lengths if own is None else own
        joints, frames = self.model.positions(_flat(array), feeds.reshape(-1), own)
        return joints.reshape(*leading, self.sections + 1, 3), frames.reshape(*leading, 3, 3)


def _flat(array: Array) -> Array:
    return array.reshape(-1, *array.shape[-2:])
