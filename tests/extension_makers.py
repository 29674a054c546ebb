"""Packages that add to Hognose, put into a folder as an installer would: sources and, beside them, entry points."""

from __future__ import annotations

import shutil
import tomllib
from pathlib import Path


class Silent(Exception):  # noqa: N818
    """An error whose text cannot be made."""

    def __str__(self) -> str:
        raise RuntimeError


def installed(project: Path, to: Path) -> Path:
    """Install a project with sources in `src` into a folder; returns the folder."""
    shutil.copytree(project / "src", to, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__"))
    said = tomllib.loads((project / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return described(to, said["name"], said["version"], said["entry-points"])


def described(to: Path, name: str, version: str, entries: dict[str, dict[str, str]]) -> Path:
    """Write what an installer writes beside the sources of a package; returns the folder."""
    folder = to / f"{name.replace('-', '_')}-{version}.dist-info"
    folder.mkdir(parents=True)
    (folder / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
    lines = [
        line for group, each in entries.items() for line in (f"[{group}]", *(f"{n} = {v}" for n, v in each.items()))
    ]
    (folder / "entry_points.txt").write_text("\n".join(lines) + "\n")
    return to
