"""Writing a task back to its file, or to a new one; never over something nobody has seen."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path as FilePath

from hognose.errors import InputError
from hognose.files import bundled_robots, bundled_tasks, load_robot
from hognose.files.task_toml import revised, written
from hognose.planning import Plan, TaskSpec
from hognose.scene.imports.imported import Imported
from hognose.write_whole import write_whole

#: File systems allow names of so many bytes, and paths of at least so many.
_LONGEST_NAME, _LONGEST_PATH = 255, 1000
#: Leaves room for what is added to a name (bytes).
_LONGEST_STEM = 200


@dataclass(frozen=True)
class Original:
    """A task file as it was when it was read or last written."""

    file: FilePath
    data: bytes

    @classmethod
    def of(cls, file: FilePath | None) -> Original | None:
        """The file as it is now; None if there is none."""
        try:
            return cls(file, file.read_bytes()) if file is not None and file.is_file() else None
        except OSError:
            return None


def digest(file: FilePath) -> bytes | None:
    """What tells a file's content from another; None if there is none that can be read."""
    try:
        if not file.is_file():  # a pipe would have us wait
            return None
        with file.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").digest()
    except OSError:
        return None


def file_stem(name: str) -> str:
    """A task's name as the beginning of a file's."""
    stem = "".join(c if c.isalnum() else "-" for c in name.lower()).strip("-")
    return stem.encode()[:_LONGEST_STEM].decode(errors="ignore") or "task"


def below(folder: FilePath, name: str, suffix: str | None = None) -> FilePath:
    """The file, links followed, that a name given in a browser means below a folder; with another suffix if asked.

    Raises
    ------
    InputError
        It names no file, is not a name, or leads out of the folder.
    """
    name = name.strip()
    parts = name.replace("\\", "/").split("/")
    if parts[-1] in ("", ".", ".."):
        raise InputError(f"{_shown(name)} does not name a file; give a name that ends in .toml")
    if not name.isprintable():
        raise InputError(f"{_shown(name)}: a file name must not contain control characters")
    if max(len(part.encode()) for part in parts) > _LONGEST_NAME or len(name.encode()) > _LONGEST_PATH:
        raise InputError(f"{_shown(name)}: is longer than {_LONGEST_NAME} bytes, too long for a file name")
    here = f"within {folder.resolve()}, the folder that was opened"
    if FilePath(name).anchor or ".." in parts:
        raise InputError(f"{_shown(name)}: files are written {here}; give a name relative to it, without '..'")
    file = FilePath(os.path.realpath(folder / (FilePath(name).with_suffix(suffix) if suffix else name)))
    if not file.is_relative_to(folder.resolve()) or file.is_symlink():  # a link still: links in a circle
        raise InputError(f"{_shown(name)}: leads to {file}, but files are written {here}. Give another name.")
    return file


def _shown(name: str) -> str:
    """A name in a message: it may be long, and hold anything."""
    return repr(name if len(name) <= 80 else f"{name[:77]}...")


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
        raise InputError(f"{original and original.file}: is no longer text in UTF-8; nothing was written") from None
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
        raise InputError(f"{file}: the name of a task file must end in .toml; try {file.with_suffix('.toml')}")
    if file.resolve() in {bundled.resolve() for bundled in bundled_tasks().values()}:
        raise InputError(
            f"{file}: is a bundled example that is never changed; save to the current folder instead: {file.name}"
        )


def _refuse_unseen(file: FilePath, original: Original | None) -> None:
    """Whatever is on disk must be what the task was read from."""
    now = Original.of(file)
    if now is None:
        return
    if original is None or original.file.resolve() != file.resolve():
        raise InputError(f"{file}: the file exists already; choose another name, or allow overwriting")
    if now.data != original.data:
        raise InputError(
            f"{file}: has changed on disk since it was opened; save under another name, or allow overwriting, "
            "which discards those changes"
        )


def save_plan(plan: Plan, file: FilePath, seen: bytes | None, force: bool = False) -> bytes | None:
    """Write a plan file.

    Parameters
    ----------
    plan
    file
    seen
        The `digest` of the file when it was read or last written; None if it never was.
    force
        Write over a file that has changed since, or was never seen.

    Returns
    -------
    bytes
        The digest of the file as it was written.

    Raises
    ------
    InputError
        There is such a file, or it cannot be written. Nothing was written then.
    """
    if not force and file.exists() and (seen is None or digest(file) != seen):
        what = "the file exists already" if seen is None else "has changed on disk since it was opened or saved"
        raise InputError(f"{file}: {what}; save under another name, or allow overwriting")
    plan.save(file)
    return digest(file)


def _refuse_missing_files(spec: TaskSpec, file: FilePath) -> None:
    """The task must be as complete when it is read from its new place."""
    try:
        load_robot(spec.robot, file.parent)
    except InputError as error:
        raise InputError(f"{file}: was not written, because its robot file would not be found there: {error}") from None
    for item in spec.obstacle:
        if isinstance(item, Imported) and not (file.parent / item.file).exists():
            raise InputError(
                f"{file}: was not written, because the obstacle file {item.file!r} is not there; a plan file contains "
                "the geometry, a task file only the name. Put the file there."
            )
