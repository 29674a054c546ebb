"""Of which kinds the sections of a robot are, and how its cables run through them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.cached import cached_property
from hognose.robot import mixed_cables
from hognose.robot.arrays import circles_of, frozen, groups_of, laws_of
from hognose.robot.sections import RIGID_LINK, Geometry, SectionKind, SectionModel, model_of
from hognose.robot.spec import RobotSpec

Array = NDArray[np.float64]


class CableCourses:
    """What of a `Robot` says how its sections bend and its cables run; all lengths in m."""

    spec: RobotSpec
    joint_before: Array
    joint_after: Array
    cable_sections: NDArray[np.int64]
    cable_radii: Array
    cable_azimuths: Array
    link_lengths: Array

    @cached_property
    def model(self) -> SectionModel:
        """How its sections bend."""
        return model_of(self.section_kinds, self.spec.tool_length)

    @cached_property
    def section_kinds(self) -> tuple[tuple[SectionKind, Geometry], ...]:
        """The kind of each section, and what its model is told of it."""
        return tuple((group.model, group.geometry) for group in groups_of(self.spec))

    @cached_property
    def extending(self) -> NDArray[np.bool_]:
        """Which sections (n,) can change their length."""
        return frozen([section.length_range is not None for _, section in self.section_kinds], np.bool_)

    @property
    def cables(self) -> int:
        """Number of cables c."""
        return self.cable_sections.size

    @cached_property
    def pitches(self) -> Array:
        """Length (n,) m of every link without the tool."""
        tool = np.append(np.zeros(len(self.link_lengths) - 1), self.spec.tool_length)
        return frozen(self.link_lengths - tool)

    @cached_property
    def disk_before_end(self) -> Array:
        """How far (n,) m before the end of each pitch the far disk is, where cables are fixed: h₁ of the next joint."""
        return frozen(np.append(self.joint_before[1:], self.joint_before[-1]))

    @cached_property
    def first_cables(self) -> NDArray[np.int64]:
        """Where each section's own cables begin (n + 1,): those of section i are first_cables[i:i + 2], 0-based."""
        return frozen(np.searchsorted(self.cable_sections, np.arange(len(self.link_lengths) + 1)), np.int64)

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

    @property
    def courses(self) -> mixed_cables.Courses:
        """All of it that lengths of cables through sections of any kinds follow from."""
        return self.section_kinds, self.first_cables, self.cable_holes, self.cable_circles, self.cable_runs
