"""What a shell may complete that is not known before: bundled names, and files that a command reads."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from hognose.bundled import bundled_tasks, robot_names

if TYPE_CHECKING:
    from cyclopts.completion import CompletionContext

#: Folders with nothing in them but one folder that are looked through, so that the way goes on by itself.
_DEEPEST = 20


def tasks(context: CompletionContext) -> list[str]:
    """Bundled tasks, and task files."""
    return [*bundled_tasks(), *files(context.incomplete, (".toml",))]


def tasks_and_plans(context: CompletionContext) -> list[str]:
    """Bundled tasks, task files and plan files."""
    return [*bundled_tasks(), *files(context.incomplete, (".toml", ".parquet"))]


def tasks_and_spaces(context: CompletionContext) -> list[str]:
    """Bundled tasks, task files, and files of a space."""
    from hognose.scene.imports.formats import BY_SUFFIX

    return [*bundled_tasks(), *files(context.incomplete, (".toml", *BY_SUFFIX))]


def shown(context: CompletionContext) -> list[str]:
    """Whatever has a page: tasks, robots, plans, spaces."""
    from hognose.scene.imports.formats import BY_SUFFIX

    return [*bundled_tasks(), *robot_names(), *files(context.incomplete, (".toml", ".parquet", *BY_SUFFIX))]


def exported(context: CompletionContext) -> list[str]:
    """What other programs can have: tasks, robots, plans."""
    return [*bundled_tasks(), *robot_names(), *files(context.incomplete, (".toml", ".parquet"))]


def tasks_and_robots(context: CompletionContext) -> list[str]:
    """Bundled tasks and robots, task files and robot files."""
    return [*bundled_tasks(), *robots(context)]


def robots(context: CompletionContext) -> list[str]:
    """Bundled robots, and robot files."""
    return [*robot_names(), *files(context.incomplete, (".toml",))]


def records(context: CompletionContext) -> list[str]:
    """Records of runs."""
    return files(context.incomplete, (".mcap",))


def runs(context: CompletionContext) -> list[str]:
    """Runs that can be followed, by the files that say where."""
    return files(context.incomplete, (".mcap.live.json",))


def files(begun: str, suffixes: tuple[str, ...]) -> list[str]:
    """Files and folders whose path begins so.

    A shell sets a space behind the only completion there is. So a folder that is the only one is looked into, until
    there are several, or a file.
    """
    for _ in range(_DEEPEST):
        found = _in_folder(begun, suffixes)
        if len(found) != 1 or not found[0].endswith("/"):
            return found
        (begun,) = found
    return []


def _in_folder(begun: str, suffixes: tuple[str, ...]) -> list[str]:
    folder, name = os.path.split(begun)
    try:
        entries = sorted(os.scandir(folder or "."), key=lambda entry: entry.name)
    except OSError:
        return []
    shown = [each for each in entries if each.name.startswith(name) and (name or not each.name.startswith("."))]
    folders = [f"{os.path.join(folder, each.name)}/" for each in shown if each.is_dir()]
    return folders + [
        os.path.join(folder, each.name) for each in shown if each.name.lower().endswith(suffixes) and not each.is_dir()
    ]
