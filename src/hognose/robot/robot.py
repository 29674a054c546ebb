"""A snake arm on a slider: its geometry as arrays, and what follows from joint angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.arguments import coordinates, floats, instance
from hognose.cached import cached_property
from hognose.errors import InputError
from hognose.robot import cable_angles, cables, mixed_cables
from hognose.robot.arrays import arrays_of, circles_of, frozen, groups_of, laws_of
from hognose.robot.bends import opened
from hognose.robot.fingerprint import fingerprint_of
from hognose.robot.outline import Outline, outline_of
from hognose.robot.sections import RIGID_LINK, Geometry, MixedSections, SectionKind, SectionModel, model_of
from hognose.robot.spec import RobotSpec

Array = NDArray[np.float64]

#: Whole numbers up to this are exact when they are computed from lengths.
MOST_COUNTS = 2**53


@dataclass(frozen=True, eq=False)
class Robot:
    """An arm of n sections on a slider; all lengths in m, all angles in rad.

    Section i is a universal joint and the link behind it, or of another kind: see `model`. The tool is rigid with the
    last section and belongs to its length, so the last joint position is the nose of the arm. Cables are numbered
    section by section.

    Attributes
    ----------
    spec
        The robot file this was made from.
    link_lengths : (n,)
        Distance from each joint to the next; the last one reaches to the tip.
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

    @cached_property
    def model(self) -> SectionModel:
        """How its sections bend."""
        return model_of(self.section_kinds, self.spec.tool_length)

    @cached_property
    def section_kinds(self) -> tuple[tuple[SectionKind, Geometry], ...]:
        """The kind of each section, and what its model is told of it."""
        return tuple((group.model, group.geometry) for group in groups_of(self.spec))

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
    def pitches(self) -> Array:
        """Length (n,) m of every link without the tool."""
        tool = np.append(np.zeros(self.sections - 1), self.spec.tool_length)
        return frozen(self.link_lengths - tool)

    @cached_property
    def disk_before_end(self) -> Array:
        """How far (n,) m before the end of each pitch the far disk is, where cables are fixed: h₁ of the next joint."""
        return frozen(np.append(self.joint_before[1:], self.joint_before[-1]))

    @property
    def cables(self) -> int:
        """Number of cables c."""
        return self.cable_sections.size

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

    @cached_property
    def first_cables(self) -> NDArray[np.int64]:
        """Where each section's own cables begin (n + 1,): those of section i are first_cables[i:i + 2], 0-based."""
        return frozen(np.searchsorted(self.cable_sections, np.arange(self.sections + 1)), np.int64)

    @cached_property
    def hole_planes(self) -> Array:
        """h₁ and h₂ (n, 2) m: how far the hole planes before and after every joint are from it."""
        return frozen(np.column_stack([self.joint_before, self.joint_after]))

    @cached_property
    def cable_holes(self) -> Array:
        """Radius (m), cosine and sine of the azimuth (c, 3) of every cable's holes."""
        return frozen(np.column_stack([self.cable_radii, np.cos(self.cable_azimuths), np.sin(self.cable_azimuths)]))

    @cached_property
    def cable_circles(self) -> Array:
        """Radius (c, n + 1) m of the circle on which each cable runs on the mount and in each section it comes to."""
        return circles_of(self.spec)

    @cached_property
    def cable_laws(self) -> Array:
        """How cables run through every section (n, 6): the `CableLaw` of its kind."""
        return laws_of(self.section_kinds)

    @cached_property
    def keeps_circles(self) -> bool:
        """Whether every cable runs on one circle all along."""
        return bool((self.cable_circles == self.cable_radii[:, None]).all())

    @property
    def plain_cables(self) -> bool:
        """Whether all sections are links, and every cable keeps its circle."""
        return self.model is RIGID_LINK and self.keeps_circles

    @cached_property
    def cable_runs(self) -> Array:
        """What (c,) m of every cable lies along links, between the hole planes: the same however the arm bends."""
        return frozen(np.cumsum(self.pitches - self.joint_after - self.disk_before_end)[self.cable_sections])

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

    def joint_positions(self, angles: ArrayLike, feed: ArrayLike = 0.0) -> Array:
        """Positions of all joints and the tip (eq. 13) in the slider's frame.

        Parameters
        ----------
        angles : (..., n, 2) rad
        feed : (...) m
            Position of the first joint along z; broadcast against the leading axes of `angles`.

        Returns
        -------
        (..., n+1, 3) m

        Raises
        ------
        InputError
            Wrong shapes, or values that are not finite.
        """
        return self._forward(angles, feed)[0]

    def tip_pose(self, angles: ArrayLike, feed: ArrayLike = 0.0) -> Array:
        """T_slider_tip, the pose (..., 4, 4) of the nose (eq. 13); arguments as in `joint_positions`."""
        joints, frames = self._forward(angles, feed)
        pose = np.zeros((*frames.shape[:-2], 4, 4))
        pose[..., :3, :3] = frames
        pose[..., :3, 3], pose[..., 3, 3] = joints[..., -1, :], 1.0
        return pose

    def cable_lengths(self, angles: ArrayLike) -> Array:
        """Exact length of every cable, from the hole plane before joint 1 to the disk it is fixed to.

        Parameters
        ----------
        angles : (..., n, 2) rad

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
            joints = (self.joint_before, self.joint_after, self.first_cables[:-1])
            lengths = cables.lengths_of(_flat(array), *joints, self.cable_radii, self.cable_azimuths, self.cable_runs)
        else:
            lengths = mixed_cables.lengths_of(_flat(array), *self._courses)
        return lengths.reshape(*array.shape[:-2], self.cables)

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
            return mixed_cables.angles_of(lengths, begin, *self._courses)
        joints = (self.joint_before, self.joint_after, self.first_cables)
        return cable_angles.angles_of(lengths, begin, *joints, self.cable_radii, self.cable_azimuths, self.cable_runs)

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

    @property
    def _courses(self) -> mixed_cables.Courses:
        return self.section_kinds, self.first_cables, self.cable_holes, self.cable_circles, self.cable_runs

    def _forward(self, angles: ArrayLike, feed: ArrayLike) -> tuple[Array, Array]:
        array = floats("angles", angles, f"(..., {self.sections}, 2)", "rad")
        leading, given = array.shape[:-2], coordinates("feed", feed, "(...)")
        try:
            feeds = np.array(np.broadcast_to(given, leading), order="C")
        except ValueError:
            raise InputError(f"feed: shape {np.shape(feed)} does not fit the steps {leading} of angles") from None
        joints, frames = self.model.positions(_flat(array), feeds.reshape(-1), self.link_lengths)
        return joints.reshape(*leading, self.sections + 1, 3), frames.reshape(*leading, 3, 3)


def _flat(array: Array) -> Array:
    return array.reshape(-1, *array.shape[-2:])
