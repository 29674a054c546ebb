"""The circle on which the holes of a section's cables lie, and what is wrong with cables on it."""

from __future__ import annotations

from itertools import pairwise

from hognose.robot.body_shape import BodyShape

#: Cables pull a section every way only while no two neighbours are this far apart (deg).
WIDEST_GAP_DEG = 180.0 - 1e-6


def fault_of_cables(
    shape: BodyShape, radius: float, azimuths_deg: tuple[float, ...], step_deg: float, count: int
) -> str:
    """What is wrong with the cables of `count` sections, for a message; empty if nothing is.

    They lie at a radius (m), those of each further section turned by another step.
    """
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


def azimuths_of_all(azimuths_deg: tuple[float, ...], step_deg: float, count: int) -> list[float]:
    """Azimuths (deg) of the cables of `count` sections, those of each further one turned by another step."""
    turns = dict.fromkeys(number * step_deg % 360 for number in range(count))
    return [azimuth + turn for turn in turns for azimuth in azimuths_deg]


def _widest_gap(azimuths_deg: tuple[float, ...]) -> tuple[float, float, float]:
    """The widest angle between neighbours on the circle, and its ends, deg."""
    around = sorted(azimuth % 360 for azimuth in azimuths_deg)
    return max((after - before, before, after % 360) for before, after in pairwise([*around, around[0] + 360]))
