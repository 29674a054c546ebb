"""From what a person names, a task, plan, robot or space, to a page."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path as FilePath

from hognose.arguments import plain_name
from hognose.files import bundled_robots, bundled_tasks, describes_robot, load_robot, load_task
from hognose.planning import Plan, Task, TaskSpec
from hognose.robot import Robot
from hognose.scene import Mesh, Points, Scene
from hognose.scene.imports.formats import MESH_SUFFIXES, POINT_SUFFIXES, STEP_SUFFIXES, UNITLESS_SUFFIXES
from hognose.viewer.model.edits import take_route_of
from hognose.viewer.model.saving import digest
from hognose.viewer.model.workbench import Workbench
from hognose.viewer.page import Page


@contextmanager
def opened(source: str, host: str = "127.0.0.1", port: int = 8080) -> Iterator[Page]:
    """A page on a bundled name or a file, closed at the end.

    Parameters
    ----------
    source
        A task (name or .toml), a plan (.parquet), a robot (name or .toml) or a mesh, STEP or point file.
    host, port
        See `hognose.viewer.gate.open_server`.

    Raises
    ------
    InputError
        Whatever is wrong with the file, or an unknown name.
    MissingExtraError
        viser is not installed.
    """
    suffix = FilePath(source).suffix.lower()
    if suffix in (*MESH_SUFFIXES, *STEP_SUFFIXES, *POINT_SUFFIXES) and source not in bundled_tasks():
        remark = ", if its numbers, which have no unit, are mm" if suffix in UNITLESS_SUFFIXES else ""
        with closing(Page(None, space_of(source), remark, host, port)) as page:
            yield page
        return
    named = FilePath(source)
    seen = {named: digest(named)} if suffix == ".parquet" else {}  # before it is read: what comes later was not seen
    task, file = task_of(source)
    folder = FilePath() if source in (*bundled_tasks(), *bundled_robots()) else named.parent
    bench = Workbench(task, file, restore=True, folder=folder, seen=seen)
    with closing(Page(bench, host=host, port=port)) as page:
        yield page


def space_of(source: str) -> Scene:
    """The space in a mesh, STEP or point file; numbers without a unit are taken for mm, points for balls of 3 mm."""
    suffix = FilePath(plain_name(source)).suffix.lower()
    units = "mm" if suffix in UNITLESS_SUFFIXES else None
    if suffix in POINT_SUFFIXES and suffix not in MESH_SUFFIXES:
        return Scene.from_obstacles([Points(file=source, units=units, diameter=0.003)])
    return Scene.from_obstacles([Mesh(file=source, units=units)])


def task_of(source: str) -> tuple[Task, FilePath | None]:
    """The task to edit, and the file it came from; a plan's is one with the plan's way-points."""
    if source.endswith(".parquet"):
        return _along(Plan.load(source)), None
    if describes_robot(source):
        robot = load_robot(source)
        return Task(_bow(robot, source), robot), None
    bundled = bundled_tasks().get(source)
    return load_task(source), bundled or FilePath(source)


def _along(plan: Plan) -> Task:
    """The task of a plan; one that was searched, along the route that was found."""
    spec = plan.task.spec
    if spec.path.target is not None:
        spec = take_route_of(plan)(spec)
    return Task(spec, plan.robot)


def _bow(robot: Robot, source: str) -> TaskSpec:
    """An arm in free space, on a gentle bow."""
    reach = 0.9 * robot.reach
    places = [(0.0, 0.0, 0.0), (0.05 * reach, 0.0, 0.5 * reach), (0.2 * reach, 0.05 * reach, reach)]
    return TaskSpec.model_validate({"name": robot.name, "robot": source, "path": {"way_points": places}})
