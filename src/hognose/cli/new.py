"""`hognose new`."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from hognose.cli.completers import robots
from hognose.cli.options import Flag, Unit

if TYPE_CHECKING:
    from hognose.files.new_task import NewTask, Wanted

Place = tuple[float, float, float]


def new(
    file: Path,
    /,
    *,
    space: Path,
    robot: Annotated[str, Parameter(completer=robots)],
    entrance: Place,
    target: Place,
    direction: Place = (0.0, 0.0, 1.0),
    units: Unit = "mm",
    margin: float | None = None,
    space_units: Unit | None = None,
    diameter: float | None = None,
    solid: bool = True,
    force: Flag = False,
    json: Flag = False,
) -> int:
    """Write a commented task file for a space from CAD, ready to be planned.

    Parameters
    ----------
    file
        The task file to write; its name ends in .toml.
    space
        A mesh, STEP or point file, as for `hognose scene`.
    robot
        A bundled robot, or a robot file.
    entrance
        X Y Z of the tip at the start, in the frame of the file; the arm lies straight behind it.
    target
        X Y Z of the place to reach.
    direction
        X Y Z of the direction in which the arm enters; its length does not matter.
    units
        Unit of the lengths given here, and of the task file.
    margin
        Clearance that the whole motion must keep; 5 mm unless given.
    space_units
        Unit of the numbers in the file of the space, for formats that do not state it.
    diameter
        Diameter of the ball that each point of a point cloud becomes.
    solid
        With --no-solid the file holds surfaces without an inside, such as a duct.
    force
        Replace the file if it is there.
    json
        Print the result as JSON, in SI units.
    """
    from hognose.files.new_task import Wanted

    wanted = Wanted(file, space, robot, entrance, direction, target, units, margin, space_units, diameter, solid)
    return _begun(wanted, force, json)


def _begun(wanted: Wanted, force: bool, json: bool) -> int:
    from hognose.cli.console import new_file, say, say_json
    from hognose.cli.scene import say_inspection, to_json
    from hognose.files.inspection import of_obstacle
    from hognose.files.new_task import new_task
    from hognose.write_whole import write_whole

    target_file = new_file(wanted.file, force)
    made = new_task(wanted)
    found = of_obstacle(made.space, wanted.space_units)
    write_whole(target_file, made.text.encode())
    file = str(wanted.file)
    follow_up = [f"hognose {command} {shlex.quote(file)}" for command in ("plan", "view")]
    if json:
        say_json({"good": True, "file": file, "next": follow_up, **_figures(made), "space": to_json(found)})
        return 0
    say_inspection(found)
    say("\n".join(["", *_ends(made), *_then(file, *follow_up)]))
    return 0


def _then(file: str, plan: str, view: str) -> list[str]:
    return [f"written to {file}; next:", f"  {plan}   searches the route and certifies it", f"  {view}   shows it"]


def _figures(made: NewTask) -> dict[str, Any]:
    """What the arm has at both ends, in m."""
    from hognose.planning.room_at_ends import room_at, room_needed, straight_way

    entrance, target = made.task.way_points[[0, -1]]
    (at_entrance, by_entrance), (at_target, by_target) = room_at(made.task, entrance), room_at(made.task, target)
    need_at_entrance, need_at_target = room_needed(made.task)
    return {
        "entrance_needed_m": need_at_entrance,
        "target_needed_m": need_at_target,
        "entrance_distance_m": at_entrance,
        "entrance_closest_to": by_entrance,
        "target_distance_m": at_target,
        "target_closest_to": by_target,
        "straight_m": straight_way(made.task),
        "reach_m": made.task.base.reach(made.task.robot),
    }


def _ends(made: NewTask) -> list[str]:
    from hognose.files.new_task import and_tolerances
    from hognose.wording import beside_limit

    figures, robot, lines = _figures(made), made.task.robot.name, []
    for end in ("entrance", "target"):
        distance, least, closest = (figures[f"{end}_{what}"] for what in ("distance_m", "needed_m", "closest_to"))
        room, needed = beside_limit(1e3 * distance, 1e3 * least, lower_bound=True)
        said = f"its radius and the margin{and_tolerances(made.task)}"
        lines.append(f"{end}: {room} mm from {closest}; the arm needs {needed} mm, {said}")
    straight, reach = beside_limit(1e3 * figures["straight_m"], 1e3 * figures["reach_m"], lower_bound=False)
    return [*lines, f"way: {straight} mm in a straight line; {robot} reaches {reach} mm"]
