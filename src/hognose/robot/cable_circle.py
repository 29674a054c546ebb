"""The circle on which the holes of a section's cables lie, and what is wrong with cables on it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import count, pairwise

from hognose.robot.body_shape import BodyShape
from hognose.robot.sections.kind import Geometry

#: Cables pull a section every way only while no two neighbours are this far apart (deg).
WIDEST_GAP_DEG = 180.0 - 1e-6


def fault_of_cables(
    shape: BodyShape,
    radius: float,
    passing: float | None,
    azimuths_deg: tuple[float, ...],
    step_deg: float,
    sections: int,
) -> str:
    """What is wrong with the cables of so many sections, for a message; empty if nothing is.

    They lie at a radius (m), those of each further section turned by another step; those that pass, at another radius.
    """
    if passing is not None and passing >= shape.radius:
        return f"passing_cable_radius {1e3 * passing:g} mm lies outside the body of {shape.words}"
    circles = {"cable_radius": radius}
    if passing is not None and sections > 1:  # cables of the group's later sections pass its earlier ones
        circles["passing_cable_radius"] = passing
    for azimuth in azimuths_of_all(azimuths_deg, step_deg, sections):
        for key, circle in circles.items():
            if not shape.holds_cable(circle, azimuth):
                where = "" if shape.sides is None else f" at the azimuth {azimuth % 360:g}°"
                return f"{key} {1e3 * circle:g} mm lies outside the body of {shape.words}{where}"
    if len({round(azimuth % 360, 6) for azimuth in azimuths_deg}) < len(azimuths_deg):
        return "cable_azimuths_deg holds the same azimuth twice"
    gap, before, after = _widest_gap(azimuths_deg)
    if gap >= WIDEST_GAP_DEG:
        return (
            f"cable_azimuths_deg leaves {gap:g}° without a cable, from {before:g}° to {after:g}°: cables only "
            "pull, so no two neighbours may be half a turn or more apart"
        )
    return ""


def fault_of_passing(
    shapes: Sequence[BodyShape], circles: Sequence[tuple[float | None, float]], azimuths_deg: Sequence[list[float]]
) -> str:
    """What is wrong with cables where they pass the groups of sections before theirs; empty if nothing is.

    Groups are from the base on: their shapes, the radii (m) for cables that pass, if there are any, and of their own
    cables, and the azimuths of these.
    """
    passed: dict[tuple[BodyShape, float | None], int] = {}
    groups = enumerate(zip(shapes, circles, azimuths_deg, strict=True), 1)
    for number, (own_shape, (own_passing, own), azimuths) in groups:
        for (shape, passing), where in passed.items():
            radius = own if passing is None else passing
            if all(shape.holds_cable(radius, azimuth) for azimuth in azimuths):
                continue
            begin = f"section: the cables of group {number} run through group {where}, too, but "
            end = f" of {1e3 * radius:g} mm lies outside its body of {shape.words}"
            if passing is not None:
                return f"{begin}its passing_cable_radius{end}"
            return (
                f"{begin}their cable_radius{end}; if they run on another circle there, group {where} needs a "
                "passing_cable_radius"
            )
        passed.setdefault((own_shape, own_passing), number)
    return ""


def fault_between_disks(groups: Sequence[Geometry], circles: Sequence[tuple[float | None, float]]) -> str:
    """What is wrong with cables that run straight between the disks of arcs; empty if they stay within the body.

    Groups are from the base on, with radii as in `fault_of_passing`.
    """
    for k, (section, (passing, own)) in enumerate(zip(groups, circles, strict=True)):
        radius = max([own, passing] if passing is not None else [each for _, each in circles[k:]])
        if section.disks is None or (beside := _beside_disks(section, section.disks, radius)) <= section.body_radius:
            continue
        enough = next(n for n in count(section.disks) if _beside_disks(section, n, radius) <= section.body_radius)
        return (
            f"section: between disks = {section.disks} of an arc, cables at {1e3 * radius:g} mm run straight, up to "
            f"{1e3 * beside:.3g} mm from the centre line where it bends most, outside the body of "
            f"{2e3 * section.body_radius:g} mm diameter: take disks = {enough} or more, or lower bend_limit_deg"
        )
    return ""


def _beside_disks(section: Geometry, disks: int, radius: float) -> float:
    """How far (m) from the centre line a cable on the inner side gets, in the middle between two disks."""
    half = math.hypot(*section.bend_limits) / (2 * disks)
    curved = section.lengths[1] / (2 * disks * half)
    return curved - (curved - radius) * math.cos(half)


def azimuths_of_all(azimuths_deg: tuple[float, ...], step_deg: float, sections: int) -> list[float]:
    """Azimuths (deg) of the cables of so many sections, those of each further one turned by another step."""
    turns = dict.fromkeys(number * step_deg % 360 for number in range(sections))
    return [azimuth + turn for turn in turns for azimuth in azimuths_deg]


def _widest_gap(azimuths_deg: tuple[float, ...]) -> tuple[float, float, float]:
    """The widest angle between neighbours on the circle, and its ends, deg."""
    around = sorted(azimuth % 360 for azimuth in azimuths_deg)
    return max((after - before, before, after % 360) for before, after in pairwise([*around, around[0] + 360]))
