"""How often and how soon routes are found for arms of arcs and of stacks of joints.

    python -m benchmarks.section_routes --spaces 10

Spaces of all families in turn are wrapped round a random motion of each arm, as its method follows it, which is proven
first; spaces whose planted motion is not proven are passed over. The search sees obstacles, entrance and target, and
must certify half of the planted clearance. Seconds are the processor's, of all threads together.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import numpy as np

import hognose
from benchmarks.arms import searched
from benchmarks.planted_arms import planted_clearance
from benchmarks.planted_spaces import FAMILIES, space
from benchmarks.routes import say
from benchmarks.rows import aside, heading, row
from benchmarks.sections import arc_arm
from hognose.errors import InfeasibleError
from hognose.robot import Robot, RobotSpec

#: Routes that must be found (%), and the time (s) of a search.
FOUND, SECONDS = 90.0, 10.0


def four_arcs() -> Robot:
    """Four arcs of 250 mm that bend by 60 degrees a side, in a body of 40 mm."""
    section = {
        "count": 4,
        "kind": "arc",
        "pitch": 0.25,
        "body_diameter": 0.04,
        "bend_limit_deg": 60.0,
        "link_mass": 0.1,
        "cable_radius": 0.017,
        "cable_azimuths_deg": (50.0, -70.0, -190.0),
        "transmission": {"screw_lead": 0.004, "gear_ratio": 4.8, "counts_per_turn": 2000},
    }
    speeds = {"joint_speed_deg_s": 60.0, "joint_acceleration_deg_s2": 2000.0}
    spec = {
        "schema": 1,
        "name": "4 arcs of 250 mm",
        "feed": {"min": 0.0, "max": 1.01, "speed": 0.05},
        "limits": {**speeds, "cable_speed": 0.5, "cable_travel": (-0.5, 0.5)},
        "section": [section],
    }
    return Robot.from_spec(RobotSpec.model_validate(spec))


#: What makes each arm, and how it follows.
ARMS: dict[str, tuple[Callable[[], Robot], str]] = {
    "12 arcs": (arc_arm, "aim"),
    "4 arcs": (four_arcs, "fitted"),
    "on-wing stacks": (lambda: hognose.load_robot("on-wing-taper"), "aim"),
}


def main() -> None:
    """Measure, and print a row an arm."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.section_routes", description="Routes of curved arms.")
    parser.add_argument("--spaces", type=int, default=10, help="spaces an arm (default: %(default)s)")
    parser.add_argument("--arm", action="append", choices=list(ARMS), help="only this one; may be repeated")
    given = parser.parse_args()
    found = {name: routes(name, given.spaces) for name in given.arm or ARMS}
    heading(f"routes found in {SECONDS:g} s of the processor, {given.spaces} planted spaces an arm")
    for name, seconds in found.items():
        times = np.array([each for each in seconds if each is not None])
        row(f"{name}: found", 100.0 * len(times) / len(seconds), FOUND, "%", at_least=True)
        if len(times):
            aside(f"{name}: first route, median", float(np.median(times)), "s")
            aside(f"{name}: first route, worst", float(times.max()), "s")


def routes(name: str, spaces: int) -> list[float | None]:
    """Seconds to the first route in each of so many spaces; None where none was found in time."""
    make, method = ARMS[name]
    robot, seconds, seed = make(), list[float | None](), 0
    planted = planted_clearance(robot)
    # So that nothing is compiled while the clock runs.
    searched(space(robot, "boards", 1000, planted, 0.5 * planted, method).task, 3.0 * SECONDS, 0)
    while len(seconds) < spaces:
        made = space(robot, FAMILIES[seed % len(FAMILIES)], seed, planted, 0.5 * planted, method)
        seed += 1
        try:
            made.proof()
        except InfeasibleError:
            say(f"{name}: {made.family} {made.seed} is passed over, what was planted is not proven")
            continue
        assert made.task.scene is not None  # it is built before the clock runs
        search = searched(made.task, SECONDS, made.seed)
        seconds.append(search.found[0].seconds if search.found else None)
        say(f"{name}: {made.family} {made.seed} | {seconds[-1]} s, {search.passages} passages")
    return seconds


if __name__ == "__main__":
    main()
