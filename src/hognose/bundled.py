"""The names and files of the robots and tasks that come with Hognose, found without loading anything else."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).parent

#: The files of Hognose's own robots, by name; first those of the paper, which messages and help name as examples.
OWN_ROBOTS = {
    file.stem: file
    for file in sorted(
        (_PACKAGE / "robot" / "bundled").glob("*.toml"), key=lambda file: (not file.stem.startswith("sjtu"), file.stem)
    )
}


def bundled_tasks() -> dict[str, Path]:
    """The bundled tasks: name without its number, and file."""
    # Installed, the examples lie in the package; in a checkout, beside it.
    folder = _PACKAGE / "examples"
    if not folder.is_dir():
        folder = _PACKAGE.parents[1] / "examples"
    return {file.stem.split("_", 1)[1].replace("_", "-"): file for file in sorted(folder.glob("[0-9]*_*.toml"))}


def robot_names() -> tuple[str, ...]:
    """Names of the bundled robots, those of other packages behind ours; what they name is not loaded."""
    from importlib.metadata import entry_points

    return tuple(dict.fromkeys((*OWN_ROBOTS, *(entry.name for entry in entry_points(group="hognose.robots")))))
