"""The arrays of a robot, of its file: one value for each section or for each cable."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.robot.sections import Geometry, SectionKind
from hognose.robot.spec import RobotSpec, SectionSpec

Array = NDArray[np.float64]


def arrays_of(spec: RobotSpec) -> dict[str, Any]:
    """The attributes of a `Robot` besides its spec."""
    groups, within = groups_of(spec), [i for group in spec.section for i in range(group.count)]
    cable_owner = [i for i, group in enumerate(groups) for _ in group.cable_azimuths_deg]
    azimuths = [
        azimuth + shift * group.cable_azimuth_step_deg
        for group, shift in zip(groups, within, strict=True)
        for azimuth in group.cable_azimuths_deg
    ]
    lengths = np.array([group.pitch for group in groups])
    lengths[-1] += spec.tool_length
    return {
        "link_lengths": frozen(lengths),
        "joint_before": frozen([group.hole_planes[0] for group in groups]),
        "joint_after": frozen([group.hole_planes[1] for group in groups]),
        "body_radii": frozen([group.shape.radius for group in groups]),
        "bend_limits": frozen(np.radians([group.limits for group in groups])),
        "link_masses": frozen([group.link_mass for group in groups]),
        "centres_of_mass": frozen([_centre(group) for group in groups]),
        "cable_sections": frozen(cable_owner, np.int64),
        "cable_radii": frozen([groups[i].cable_radius for i in cable_owner]),
        "cable_azimuths": frozen(np.radians(azimuths)),
        "travel_per_count": frozen([groups[i].transmission.travel_per_count for i in cable_owner]),
    }


def circles_of(spec: RobotSpec) -> Array:
    """Radius (c, n + 1) m of the circle on which each cable runs on the mount and in each section, as far as it goes.

    In its own section that is its `cable_radius`, and in one that it passes that section's `passing_cable_radius`, if
    it has one. The holes of the mount are those of the first section.
    """
    groups = groups_of(spec)
    owners = np.repeat(np.arange(len(groups)), [len(group.cable_azimuths_deg) for group in groups])
    own = np.array([groups[i].cable_radius for i in owners])
    out = np.repeat(own[:, None], len(groups) + 1, axis=1)
    for i, group in enumerate(groups):
        if group.passing_cable_radius is not None:
            out[owners > i, i + 1] = group.passing_cable_radius
    out[:, 0] = out[:, 1]
    return frozen(out)


def laws_of(sections: Sequence[tuple[SectionKind, Geometry]]) -> Array:
    """How cables run through each section (n, 6): the `CableLaw` of its kind."""
    return frozen([kind.cable_law(section) for kind, section in sections])


def groups_of(spec: RobotSpec) -> list[SectionSpec]:
    """The group of every section."""
    return [group for group in spec.section for _ in range(group.count)]


def frozen(values: Any, dtype: Any = np.float64) -> NDArray[Any]:
    """An array of values that cannot be written to."""
    array = np.ascontiguousarray(values, dtype=dtype)
    array.flags.writeable = False
    return array


def _centre(group: SectionSpec) -> float:
    return group.pitch / 2 if group.centre_of_mass is None else group.centre_of_mass
