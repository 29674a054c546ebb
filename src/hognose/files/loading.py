"""Loading robots and tasks, bundled ones by name and others from files."""

from __future__ import annotations

import difflib
import os
import tomllib
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from hognose.arguments import file_name, instance
from hognose.bundled import OWN_ROBOTS, bundled_tasks
from hognose.errors import InputError
from hognose.extensions import Table, home, words_of
from hognose.files.toml_source import LARGEST_FILE, read_model
from hognose.following import known_method
from hognose.planning import Plan, Task, TaskSpec
from hognose.read_whole import read_whole
from hognose.robot import Robot, RobotSpec


def _is_file(given: Any) -> bool:
    return isinstance(given, str | os.PathLike | Traversable)


def _fault(name: str, given: Any) -> str | None:
    del name
    kinds = "the path of a robot file, a traversable, or a function that returns one"
    return None if _is_file(given) or callable(given) else f"is not {kinds}"


#: The files of bundled robots by name, or functions that return them; those of other packages behind ours.
_ROBOTS: Table[Any] = Table("robots", OWN_ROBOTS, _fault)


def bundled_robots() -> tuple[str, ...]:
    """Names of the bundled robots, those of other packages behind ours.

    Raises
    ------
    InputError
        A package that adds a robot cannot be used; says which and why.
    """
    return tuple(_ROBOTS)


def load_robot(source: str | Path, relative_to: Path | None = None) -> Robot:
    """A bundled robot by name, or one from a TOML file.

    Parameters
    ----------
    source
        A name in `bundled_robots()`, or a path ending in `.toml`.
    relative_to
        Folder that a relative path starts from; default is the current one.

    Raises
    ------
    InputError
        Unknown name, or a file with faults: says file, line, key and what was expected.
    """
    file_name("source", source)
    folder = Path() if relative_to is None else file_name("relative_to", relative_to)
    if str(source) in _ROBOTS:
        return _bundled_robot(str(source))
    path = folder / source
    _refuse_unknown_name(source, path, "robot", bundled_robots())
    return Robot.from_spec(read_model(path, RobotSpec))


def _bundled_robot(name: str) -> Robot:
    """A robot of the table.

    Raises
    ------
    InputError
        Names the package that adds it.
    """
    with _file_of(name) as file:
        return Robot.from_spec(read_model(file, RobotSpec))


@contextmanager
def _file_of(name: str) -> Iterator[Path]:
    """The file of a robot of the table; what is wrong with it is said of the package that adds it."""
    found = _ROBOTS[name]
    try:
        if not _is_file(found):
            found = _returned(found)
        if isinstance(found, Traversable) and not isinstance(found, Path):
            with resources.as_file(found) as file:
                yield file
        else:
            yield Path(found)
    except InputError as error:
        raise InputError(f"robot {name!r} of {home('robots', name)}: {error}") from error.__cause__


def robot_text(name: str) -> bytes:
    """The file of a bundled robot as it is, comments and all, to start another one from.

    Raises
    ------
    InputError
        Unknown name, one of a file, or a file with faults.
    """
    load_robot(name)
    if name not in _ROBOTS:
        raise InputError(f"{name}: is a file, expected a bundled robot: {', '.join(bundled_robots())}. Copy the file.")
    with _file_of(name) as file:
        return read_whole(file, LARGEST_FILE)


def _returned(function: Callable[[], Any]) -> Any:
    """The file that a package's function returns."""
    try:
        found = function()
    except (Exception, SystemExit) as error:
        raise InputError(f"its function failed: {words_of(error)}") from error
    if not _is_file(found):
        raise InputError(f"its function returns no path of a robot file, but {found!r}")
    return found


def load_task(source: str | Path) -> Task:
    """A bundled task by name, or one from a TOML file, with its robot.

    Parameters
    ----------
    source
        A name in `bundled_tasks()`, or a path ending in `.toml`. A robot file that the task names is looked for
        beside the task file.

    Raises
    ------
    InputError
        Unknown name, or a file with faults: says file, line, key and what was expected.
    """
    file_name("source", source)
    bundled = bundled_tasks()
    path = bundled.get(str(source), Path(source))
    _refuse_unknown_name(source, path, "task", bundled)
    spec = read_model(path, TaskSpec)
    try:
        robot = load_robot(spec.robot, path.parent)
    except InputError as error:
        raise InputError(f"{path}: robot: {error}") from None
    return Task(spec, robot)


def with_method(task: Task, method: str) -> Task:
    """The same task with another following method.

    Raises
    ------
    InputError
        Unknown method.
    """
    instance("task", task, Task, "a hognose.Task")
    motion = task.spec.motion.model_copy(update={"method": known_method(method)})
    return Task(task.spec.model_copy(update={"motion": motion}), task.robot)


def describes_robot(source: str) -> bool:
    """Whether a name is a bundled robot's, or a file a robot's and not a task's."""
    if source in bundled_robots():
        return True
    file = Path(source)
    try:
        return (
            file.suffix == ".toml"
            and file.is_file()
            and "section" in tomllib.loads(read_whole(file, LARGEST_FILE).decode())
        )
    except (tomllib.TOMLDecodeError, ValueError, OSError, InputError):
        return False  # reading it as a task says what is wrong


def load_task_or_plan(source: str | Path, progress: Callable[[str], None] = lambda stage: None) -> Task | Plan:
    """A plan, verified, if the file's name ends in `.parquet`, else a task; errors as in `Plan.load` and `load_task`.

    `progress` is called with the name of each stage of verifying.
    """
    return Plan.load(source, progress) if str(source).endswith(".parquet") else load_task(source)


def _refuse_unknown_name(source: str | Path, path: Path, what: str, names: Iterable[str]) -> None:
    with suppress(OSError, ValueError):  # a name that no file can have is no file
        if path.suffix == ".toml" or path.exists():
            return
    near = difflib.get_close_matches(str(source), list(names), 1)
    hint = f" Did you mean {near[0]!r}?" if near else ""
    raise InputError(f"{source}: no such file, and no bundled {what} of that name.{hint} Bundled: {', '.join(names)}")
