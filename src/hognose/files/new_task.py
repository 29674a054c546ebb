"""A task file to start from: made of a space from CAD, an arm, an entrance and a target, and looked over."""

from __future__ import annotations

import math
import os
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hognose.arguments import plain_name
from hognose.errors import InputError
from hognose.files.inspection import in_every_unit, opened
from hognose.files.loading import bundled_robots, load_robot
from hognose.files.new_task_text import task_text
from hognose.files.toml_source import validate
from hognose.planning import Task, TaskSpec
from hognose.planning.motion_spec import MotionSpec
from hognose.planning.out_of_place import outside
from hognose.planning.room_at_ends import obstructed_start, room_at, room_needed, straight_way
from hognose.planning.task import LONGEST_NAME
from hognose.scene import Points
from hognose.scene.imports.formats import MESH_SUFFIXES, POINT_SUFFIXES, STEP_SUFFIXES, UNITLESS_SUFFIXES
from hognose.scene.imports.imported import Imported
from hognose.scene.imports.other_formats import foreign
from hognose.units import LARGEST_LENGTH, LENGTH_UNITS, LONGEST_DIRECTION, SHORTEST_DIRECTION
from hognose.wording import beside_limit, mm, point

Place = tuple[float, float, float]

#: A link is fed in so many steps at least.
STEPS_A_LINK = 25


@dataclass(frozen=True)
class Wanted:
    """What a new task is to hold; lengths are in its own unit.

    Attributes
    ----------
    file
        Where it will be; the other files are named from there.
    space
        A mesh, STEP or point file.
    robot
        A bundled robot, or a robot file.
    entrance, direction, target
        In the frame of the space: where the tip is at the start, where the arm points there, and where the tip goes.
    units
        Of the task file, and of all lengths here.
    margin
        Clearance required; None for the default.
    space_units
        Of the numbers in the space's file, if that does not say it.
    diameter
        Of the ball that each point of a point cloud becomes.
    solid
        Whether what is in the file has an inside.
    """

    file: Path
    space: Path
    robot: str
    entrance: Place
    direction: Place
    target: Place
    units: str = "mm"
    margin: float | None = None
    space_units: str | None = None
    diameter: float | None = None
    solid: bool = True


@dataclass(frozen=True, eq=False)
class NewTask:
    """A task file that is not written yet, and the task it describes.

    Attributes
    ----------
    text
    task
    space
        The obstacle as it is in its file, to be inspected.
    """

    text: str
    task: Task
    space: Imported


def new_task(wanted: Wanted) -> NewTask:
    """The text of a commented task file, after the arm was found to fit at both ends of the way.

    Raises
    ------
    InputError
        Something that is wanted makes no sense, a file cannot be read, the entrance or the target leaves the arm too
        little space, or the target is too far away: one sentence for each fault.
    """
    metres = LENGTH_UNITS[wanted.units]
    _refuse_senseless(wanted)
    robot = load_robot(wanted.robot)
    space = _space(wanted)
    names = [body.name for body in space.geometry.bodies if body.name] if space.kind == "mesh" else []
    text = task_text(
        name=wanted.file.stem[:LONGEST_NAME],
        file=wanted.file.name,
        units=wanted.units,
        robot=wanted.robot if wanted.robot in bundled_robots() else _beside(wanted.file, Path(wanted.robot)),
        margin=float(f"{0.005 / metres:.6g}") if wanted.margin is None else wanted.margin,
        entrance=wanted.entrance,
        direction=wanted.direction,
        target=wanted.target,
        step=_step(float(robot.link_lengths.min()), robot.spec.feed.speed) / metres,
        space=_beside(wanted.file, wanted.space),
        kind=space.kind,
        space_units=wanted.space_units,
        diameter=wanted.diameter,
        solid=wanted.solid,
        bodies=names,
    )
    spec = validate(tomllib.loads(text), TaskSpec, str(wanted.file))
    (obstacle,) = spec.obstacle
    assert isinstance(obstacle, Imported)
    spec = spec.model_copy(update={"obstacle": (obstacle.with_geometry(space.geometry),)})
    task = Task(spec, robot)
    faults = list(_faults(task, wanted.units))
    if faults:
        raise InputError("\n".join(faults))
    return NewTask(text, task, space)


def _refuse_senseless(wanted: Wanted) -> None:
    """Before files are read."""
    if wanted.file.suffix != ".toml":
        raise InputError(f"{wanted.file}: the name of a task file must end in .toml")
    for name in (str(wanted.file), str(wanted.space)):
        plain_name(name)
    for option in ("entrance", "target"):
        _refuse_distant(f"--{option}", getattr(wanted, option), wanted.units)
    if not SHORTEST_DIRECTION <= math.hypot(*wanted.direction) <= LONGEST_DIRECTION:  # of nan, too
        raise InputError(
            f"--direction: {_written(wanted.direction)} is no direction; expected three numbers, not all zero, such as "
            "0 0 1 for an arm that enters along +z of the file"
        )
    for option in ("margin", "diameter"):
        value = getattr(wanted, option)
        if value is not None and not (0 <= value < math.inf and (value > 0 or option == "margin")):
            least = "0 or more" if option == "margin" else "above 0"
            raise InputError(f"--{option}: expected a length in {wanted.units}, {least}, got {value:g}")
    if wanted.entrance == wanted.target:
        raise InputError(f"--target: {_written(wanted.target)} {wanted.units} is the entrance, too; give another place")


def _refuse_distant(option: str, place: Place, units: str) -> None:
    largest = LARGEST_LENGTH / LENGTH_UNITS[units]
    if not all(abs(coordinate) <= largest for coordinate in place):  # of nan, too
        raise InputError(
            f"{option}: expected three coordinates in {units}, none beyond {largest:,.0f}, got {_written(place)}; "
            "--units says another unit"
        )


def _space(wanted: Wanted) -> Imported:
    """The obstacle in the file of the space."""
    path, suffix = wanted.space, wanted.space.suffix.lower()
    if suffix not in (*MESH_SUFFIXES, *POINT_SUFFIXES):
        known = ", ".join(dict.fromkeys((*MESH_SUFFIXES, *POINT_SUFFIXES)))
        said = foreign(suffix) if suffix and path.exists() else "is no file of a space."
        raise InputError(f"--space: {path}: {said} Expected {known}.")
    if wanted.space_units is not None and suffix in STEP_SUFFIXES:
        raise InputError(f"--space-units: STEP files say their unit, {path} too; leave it out")
    space = opened(path, wanted.space_units)
    if suffix in UNITLESS_SUFFIXES and wanted.space_units is None:
        raise InputError(
            f"--space: {path} does not say the unit of its numbers; give --space-units. "
            f"Its longest side is {in_every_unit(space)}."
        )
    if isinstance(space, Points) != (wanted.diameter is not None):
        raise InputError(
            f"--diameter: {path} holds a mesh and no points; leave it out"
            if wanted.diameter is not None
            else f"--space: {path} holds points; give --diameter, of the ball that each becomes: more than the "
            "distance between neighbouring points, or the arm could pass between them"
        )
    if isinstance(space, Points) and not wanted.solid:
        raise InputError(f"--no-solid: {path} holds points, which have no inside; leave it out")
    return space


def _step(link: float, speed: float) -> float:
    """A step of the feed (m) that suits an arm: the default, or less where links are short or the slider is slow."""
    standard = MotionSpec()
    fitting = min(link / STEPS_A_LINK, speed * standard.period_s)
    if fitting >= standard.step:
        return standard.step
    digits = 10.0 ** (math.floor(math.log10(fitting)) - 1)
    return math.floor(fitting / digits) * digits


def _faults(task: Task, units: str) -> Iterator[str]:
    """Why no motion of the arm can begin or end where it is asked to, in sentences; numbers were given in `units`."""
    (entrance, target), robot = task.way_points[[0, -1]], task.robot
    misplaced = list(_out_of_place(task, units))
    if misplaced:  # all else follows from it
        yield from misplaced
        return
    way, farthest = straight_way(task), task.base.reach(robot)
    if way > farthest:
        far, reach = beside_limit(1e3 * way, 1e3 * farthest, lower_bound=False)
        yield (
            f"--target: {point(target, 'g')} is {far} mm from the entrance, and arm and slider of {robot.name} reach "
            f"{reach} mm; move one of the two, take a longer arm (`hognose robot` lists them), or, if the numbers are "
            f"not in {units}, give --units"
        )
    at_entrance, at_target = room_needed(task)
    at_the_ends = [_tight(task, "--entrance", entrance, at_entrance), _tight(task, "--target", target, at_target)]
    yield from filter(None, at_the_ends)
    if at_the_ends[0] is None:
        yield from _obstructed(task)


def _out_of_place(task: Task, units: str) -> Iterator[str]:
    """Ends of the way that are farther than an arm's length outside the file: their unit or frame is another one."""
    low, high = _box(task)
    away = outside(np.array([[low, high]]), task.way_points[[0, -1]])[0]
    for option, place, far in zip(("--entrance", "--target"), task.way_points[[0, -1]], away, strict=True):
        if far > task.robot.length:
            yield (
                f"{option}: {point(place, 'g')} is {mm(far, '.0f')} outside the space, more than the arm's length of "
                f"{mm(task.robot.length, 'g')}; {_extent(task)} Give it in the frame of that file and in {units}, "
                "another unit with --units, or the unit of the file with --space-units if it does not say one"
            )


def _tight(task: Task, option: str, place: NDArray[np.float64], needed: float) -> str | None:
    distance, name = room_at(task, place)
    if distance < 0:
        return (
            f"{option}: {point(place, 'g')} lies inside {name!r}, {mm(-distance, '.1f')} deep; {_extent(task)} Give a "
            "place in free space; or, if that is a surface without an inside, such as a duct, --no-solid"
        )
    if distance < needed:
        near, enough = beside_limit(1e3 * distance, 1e3 * needed, lower_bound=True)
        return (
            f"{option}: {point(place, 'g')} is {near} mm from {name!r}, and the arm needs {enough} mm there, its "
            f"radius and the margin{and_tolerances(task)}; {_extent(task)} Give a place farther away, or less --margin"
        )
    return None


def _obstructed(task: Task) -> Iterator[str]:
    """What the straight arm and the mount behind it hit, while the tip is at the entrance."""
    found = obstructed_start(task)
    if found is not None:
        left, margin = beside_limit(1e3 * max(found.room, 0.0), 1e3 * found.needed, lower_bound=True)
        yield (
            f"--direction: at the start the arm lies straight behind the entrance, from {point(found.begin)}, and "
            f"would be {left} mm from {found.obstacle!r} at {point(found.place)}; the margin"
            f"{and_tolerances(task)} is {margin} mm. Give the direction in which it enters, or an entrance farther out"
        )


def and_tolerances(task: Task) -> str:
    """Words that go on after the margin: nothing without tolerances."""
    return "" if task.budget is None else " with what the robot's tolerances take"


def _box(task: Task) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The lowest and the highest corner (3,) m of the space."""
    return task.scene.bounds[:, 0].min(axis=0), task.scene.bounds[:, 1].max(axis=0)


def _extent(task: Task) -> str:
    low, high = _box(task)
    return f"the file goes from {point(low, '.5g')} to {point(high, '.5g')}."


def _beside(file: Path, other: Path) -> str:
    """How a task file names another one."""
    folder = file.parent.resolve()
    return Path(os.path.relpath(other.parent.resolve() / other.name, folder)).as_posix()


def _written(place: Place) -> str:
    return " ".join(f"{coordinate:g}" for coordinate in place)
