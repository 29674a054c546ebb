"""Arms over the range that the search is made for: 5 to 60 links of 20 to 300 mm that bend 10 to 60 degrees a joint."""

from __future__ import annotations

from hognose.robot import Robot, RobotSpec

#: Links, their length (mm), the limit of their joints (deg) and the diameter of their body (mm): the corners of the
#: range, long links that bend little, and others that fill the range evenly (a low-discrepancy sequence, logarithmic).
ARMS: tuple[tuple[int, float, float, float], ...] = (
    (5, 20, 10, 5),
    (5, 300, 60, 75),
    (6, 135, 20, 47),
    (6, 195, 41, 27),
    (6, 280, 14, 51),
    (8, 27, 13, 9.5),
    (8, 39, 27, 18),
    (8, 275, 39, 73),
    (12, 38, 13, 29),
    (12, 55, 26, 16.5),
    (12, 80, 53, 32),
    (12, 200, 20, 45),
    (17, 110, 50, 90),
    (17, 165, 17, 178),
    (24, 22, 33, 19),
    (25, 230, 16, 159),
    (34, 65, 22, 61),
    (35, 32, 32, 52),
    (35, 46, 11, 34),
    (49, 135, 43, 166),
    (50, 65, 10, 99),
    (50, 95, 21, 190),
    (60, 20, 60, 18),
    (60, 300, 10, 450),
)


def arm(links: int, length_mm: float, bend_limit_deg: float, diameter_mm: float) -> Robot:
    """An arm of equal links, as fast for its size as the bundled one, with cables that reach as far as its joints."""
    length, radius = 1e-3 * length_mm, 0.5e-3 * diameter_mm
    whole = links * length
    # The bundled arm: 1.092 m, 12 joints of 28.6 deg that turn at 7 deg/s while it is fed at 23 mm/s.
    size, turns = whole / 1.092, links * bend_limit_deg / 343.8
    travel = 2.0 * links * radius * bend_limit_deg / 57.0
    section = {
        "count": links,
        "pitch": length,
        "half_lengths": (0.1 * length, 0.1 * length),
        "body_diameter": 2.0 * radius,
        "bend_limit_deg": bend_limit_deg,
        "link_mass": 0.062,
        "cable_radius": 0.85 * radius,
        "cable_azimuths_deg": (50.0, -70.0, -190.0),
        "transmission": {"screw_lead": 0.004, "gear_ratio": 4.8, "counts_per_turn": 2000},
    }
    return Robot.from_spec(
        RobotSpec.model_validate(
            {
                "schema": 1,
                "name": f"{links} x {length_mm:g} mm, {bend_limit_deg:g} deg, body {diameter_mm:g} mm",
                "feed": {"min": 0.0, "max": 1.01 * whole, "speed": 0.05 * size},
                "limits": {
                    "joint_speed_deg_s": 7.0 * turns,
                    "joint_acceleration_deg_s2": 60.0 * turns * max(1.0, links / 12),
                    "cable_speed": travel,
                    "cable_travel": (-travel, travel),
                },
                "section": [section],
            }
        )
    )


def planted_clearance(robot: Robot) -> float:
    """Clearance (m) of motions that spaces are wrapped round: in proportion to the body, 10 mm for a body of 45 mm."""
    return float(robot.body_radii.min()) * 4 / 9
