"""The circle on which the holes of a section's cables lie, and what is wrong with cables on it."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

from hognose.robot.body_shape import BodyShape

#: Cables pull a section every way only while no two neighbours are this far apart (deg).
WIDEST_GAP_DEG = 180.0 - 1e-6


def fault_of_cables(
    shape: BodyShape,
    radius: float,
    passing: float | None,
    azimuths_deg: tuple[float, ...],
    step_deg: float,
    count: int,
) -> str:
    """What is wrong with the cables of `count` sections, for a message; empty if nothing is.

    They lie at a radius (m), those of each further section turned by another step; those that pass, at another radius.
    """
    if passing is not None and passing >= shape.radius:
        return f"passing_cable_radius {1e3 * passing:g} mm lies outside the body of {shape.words}"
    for azimuth in azimuths_of_all(azimuths_deg, step_deg, count):
        if not shape.holds_cable(radius, azimuth):
            where = "" if shape.sides is None else f" at the azimuth {azimuth % 360:g}°"
            return f"cable_radius {1e3 * radius:g} mm lies outside the body of {shape.words}{where}"
    if len({round(azimuth % 360, 6) for azimuth in azimuths_deg}) < len(azimuths_deg):
        return "cable_azimuths_deg holds the same azimuth twice"
    gap, before, after = _widest_gap(azimuths_deg)
    if gap >= WIDEST_GAP_DEG:
        return (
            f"cable_azimuths_deg leaves {gap:g}° without a cable, from {before:g}° to {after:g}°: cables only "
            "pull, so no two neighbours may be half a turn or more apart"
        )
    return ""


def fault_of_passing(groups: Iterable[tuple[BodyShape, float | None, float, list[float]]]) -> str:
    """What is wrong with cables where they pass the groups of sections before theirs; empty if nothing is.

    Groups are from the base on: the shape, the radius (m) for those that pass if there is one, the cables' own radius
    (m) and their azimuths (deg).
    """
    passed: dict[tuple[BodyShape, float | None], int] = {}
    for number, (own_shape, own_passing, own, azimuths) in enumerate(groups, 1):
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


def azimuths_of_all(azimuths_deg: tuple[float, ...], step_deg: float, count: int) -> list[float]:
    """Azimuths (deg) of the cables of `count` sections, those of each further one turned by another step."""
    turns = dict.fromkeys(number * step_deg % 360 for number in range(count))
    return [azimuth + turn for turn in turns for azimuth in azimuths_deg]


def _widest_gap(azimuths_deg: tuple[float, ...]) -> tuple[float, float, float]:
    """The widest angle between neighbours on the circle, and its ends, deg."""
    around = sorted(azimuth % 360 for azimuth in azimuths_deg)
    return max((after - before, before, after % 360) for before, after in pairwise([*around, around[0] + 360]))
