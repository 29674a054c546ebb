"""Plans, and the arms and spaces they are made for, in the formats of other programs: one file a format."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hognose.arguments import file_name
from hognose.errors import HognoseError, InputError
from hognose.extensions import added, words_of
from hognose.files.exports import axes, csv, json, mjcf, parquet, ros2, urdf
from hognose.files.exports.format import Content, Export
from hognose.planning import Task
from hognose.planning.plan import Plan
from hognose.robot import Robot
from hognose.write_whole import write_together

__all__ = ["Content", "Export", "Exported", "export", "export_format", "formats"]

#: The formats that Hognose has.
_BUNDLED = {
    "csv": csv.EXPORT,
    "json": json.EXPORT,
    "parquet": parquet.EXPORT,
    "mjcf": mjcf.EXPORT,
    "urdf": urdf.EXPORT,
    "ros2": ros2.EXPORT,
    "axes": axes.EXPORT,
}


@dataclass(frozen=True)
class Exported:
    """What was written.

    Attributes
    ----------
    plan
        As it was written, with its new verdict, good or not; None if there was no motion.
    beside
        The files beside it that it names.
    remarks
        What is not in it, or otherwise than one would think, in sentences.
    """

    plan: Plan | None
    beside: tuple[Path, ...] = ()
    remarks: tuple[str, ...] = ()


def named_formats() -> dict[str, Export]:
    """All formats by name: those of Hognose, and those that other packages add under `hognose.exports`.

    Raises
    ------
    InputError
        What a package adds is no `Export`, or has the name or the suffix of another.
    """
    found: dict[str, Export] = {}
    suffixes: dict[str, str] = {}
    for name, given in [*_BUNDLED.items(), *added("exports").items()]:
        if not isinstance(given, Export):
            raise InputError(
                f"hognose.exports: {name!r} is {type(given).__name__}, expected a "
                "hognose.files.exports.Export; mend or uninstall the package that adds it"
            )
        if given.suffix in suffixes:
            raise InputError(
                f"hognose.exports: {suffixes[given.suffix]!r} and {name!r} both write {given.suffix}; uninstall the "
                "package that adds one of them"
            )
        if name in found:
            raise InputError(f"hognose.exports: {name!r} is there twice; uninstall the package that adds one of them")
        found[name], suffixes[given.suffix] = given, name
    return found


def formats() -> dict[str, Export]:
    """All formats by suffix; errors as in `named_formats`."""
    return {given.suffix: given for given in named_formats().values()}


def export_format(name: str) -> Export:
    """The format of a name, as "mjcf"; an InputError lists the names there are."""
    known = named_formats()
    if name not in known:
        raise InputError(f"--to: unknown format {name!r:.60}; expected {', '.join(known)}")
    return known[name]


def export(source: Plan | Task | Robot, path: Path | str) -> Exported:
    """Write a plan, verified, in the format its suffix names; models of arms also of a task, or of a robot alone.

    Raises
    ------
    InputError
        Unknown suffix, a format that needs a plan, or one that fails, or the file cannot be written.
    """
    if not isinstance(source, Plan | Task | Robot):
        raise InputError(f"source: expected a hognose.Plan, Task or Robot, got {type(source).__name__}")
    path = file_name("path", path)
    known = formats()
    chosen = known.get(path.suffix.lower())
    if chosen is None:
        raise InputError(f"{path}: unknown format {path.suffix!r}; expected {', '.join(known)}")
    write = _writer(chosen, source)
    verified = source.verified() if isinstance(source, Plan) else source
    content = _written(chosen, write, verified)
    write_together(path, content.data, content.beside)
    beside = tuple(path.parent / name for name in content.beside)
    return Exported(verified if isinstance(verified, Plan) else None, beside, content.remarks)


def _writer(chosen: Export, source: Plan | Task | Robot) -> Callable[[Any], Any]:
    """What writes such a source in a format."""
    if isinstance(source, Plan):
        return chosen.write
    write, what = (chosen.of_task, "task") if isinstance(source, Task) else (chosen.of_robot, "robot")
    if write is None:
        able = [each.suffix for each in formats().values() if getattr(each, f"of_{what}") is not None]
        raise InputError(
            f"{source.name}: is a {what}, but {chosen.suffix} is written of a plan; plan first, or take one of "
            f"{', '.join(able)}"
        )
    return write


def _written(chosen: Export, write: Callable[[Any], Any], source: Plan | Task | Robot) -> Content:
    foreign = f"the format {chosen.suffix}, which another package adds,"
    try:
        content = write(source)
    except HognoseError:
        raise
    except (Exception, SystemExit) as error:
        if chosen in _BUNDLED.values():
            raise
        raise InputError(f"{foreign} fails: {words_of(error)}") from error
    if isinstance(content, bytes):
        return Content(content)
    if not isinstance(content, Content):
        raise InputError(f"{foreign} made {type(content).__name__}, expected bytes")
    return content
