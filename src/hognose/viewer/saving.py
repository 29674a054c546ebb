"""Writing a task back to its file, or to a new one; never over something nobody has seen."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path as FilePath

from hognose.errors import InputError
from hognose.files import bundled_robots, bundled_tasks, load_robot
from hognose.planning import TaskSpec
from hognose.planning.storage import write_whole
from hognose.scene.imports.imported import Imported
from hognose.viewer.revising import revised, written


@dataclass(frozen=True)
class Original:
    """A task file as it was when it was read or last written."""

    file: FilePath
    data: bytes

    @classmethod
    def of(cls, file: FilePath | None) -> Original | None:
        """The file as it is now; None if there is none."""
        try:
            return None if file is None else cls(file, file.read_bytes())
        except OSError:
            return None


def file_stem(name: str) -> str:
    """A task's name as the beginning of a file's."""
    return "".join(c if c.isalnum() else "-" for c in name.lower()).strip("-") or "task"


def save_task(
    spec: TaskSpec, file: FilePath, original: Original | None, folder: FilePath, force: bool = False
) -> Original:
    """Write a task file.

    Parameters
    ----------
    spec
    file
        Where to.
    original
        The file the task was read from: its comments, order, unit and layout are kept. None for a complete new file.
    folder
        What relative paths of robots and meshes in `spec` start from; in the file they start from its own folder.
    force
        Write over a file that has changed since it was read, or another one.

    Returns
    -------
    Original
        The file as it was written.

    Raises
    ------
    InputError
        The file is a bundled example, has changed, or is another one; a robot or mesh would not be found from there; or
        it cannot be written. Nothing was written then.
    """
    file = FilePath(file)
    _refuse_bundled(file)
    if not force:
        _refuse_unseen(file, original)
    rebased = moved(spec, folder, file.parent)
    _refuse_missing_files(rebased, file)
    try:
        text = written(rebased) if original is None else revised(original.data.decode("utf-8"), rebased)
    except UnicodeDecodeError:
        raise InputError(f"{original and original.file}: is no text in UTF-8 any more; nothing was written") from None
    write_whole(file, text.encode())
    return Original(file, text.encode())


def moved(spec: TaskSpec, folder: FilePath, to: FilePath) -> TaskSpec:
    """The same spec with paths that start from another folder."""
    if folder.resolve() == to.resolve():
        return spec

    def path(name: str) -> str:
        target = folder.resolve() / name
        if FilePath(name).is_absolute():
            return name
        try:
            return FilePath(os.path.relpath(target, to.resolve())).as_posix()
        except ValueError:  # another drive
            return str(target)

    robot = spec.robot if spec.robot in bundled_robots() else path(spec.robot)
    obstacles = tuple(
        item.model_copy(update={"file": path(item.file)}) if isinstance(item, Imported) else item
        for item in spec.obstacle
    )
    return spec.model_copy(update={"robot": robot, "obstacle": obstacles})


def _refuse_bundled(file: FilePath) -> None:
    if file.suffix != ".toml":
        raise InputError(f"{file}: a task file's name ends in .toml; try {file.with_suffix('.toml')}")
    if file.resolve() in {bundled.resolve() for bundled in bundled_tasks().values()}:
        raise InputError(
            f"{file}: is a bundled example and stays as it is; save to the current folder instead: {file.name}"
        )


def _refuse_unseen(file: FilePath, original: Original | None) -> None:
    """Whatever is on disk must be what the task was read from."""
    now = Original.of(file)
    if now is None:
        return
    if original is None or original.file.resolve() != file.resolve():
        raise InputError(f"{file}: there is such a file already; choose another name, or allow writing over it")
    if now.data != original.data:
        raise InputError(
            f"{file}: has changed on disk since it was opened; save under another name, or allow writing over it, "
            "which throws those changes away"
        )


def _refuse_missing_files(spec: TaskSpec, file: FilePath) -> None:
    """The task must be as complete when it is read from its new place."""
    try:
        load_robot(spec.robot, file.parent)
    except InputError as error:
        raise InputError(f"{file}: was not written, because its robot would not be found from there: {error}") from None
    for item in spec.obstacle:
        if isinstance(item, Imported) and not (file.parent / item.file).exists():
            raise InputError(
                f"{file}: was not written, because {item.file!r}, from which an obstacle comes, is not there; a plan "
                "file holds its content, a task file only its name. Put the file there."
            )
