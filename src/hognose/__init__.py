"""Hognose plans how a snake-arm robot slides into a confined space, and proves that its body stays clear.

The public names are loaded when they are first used, so that importing the package costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module

from hognose.version import __version__

TYPE_CHECKING = False  # without `typing`, which would take longer than all of this
if TYPE_CHECKING:
    from typing import Any

    from hognose.errors import HognoseError, InfeasibleError, InputError, MissingExtraError
    from hognose.files import load_robot, load_task
    from hognose.following import METHODS, follow, follower
    from hognose.path import Path
    from hognose.planning import Check, Plan, Task
    from hognose.robot import Robot
    from hognose.route import plan
    from hognose.scene import Scene
    from hognose.steering import SteeredPath

_HOMES = {
    "HognoseError": "errors",
    "InfeasibleError": "errors",
    "InputError": "errors",
    "MissingExtraError": "errors",
    "load_robot": "files",
    "load_task": "files",
    "METHODS": "following",
    "follow": "following",
    "follower": "following",
    "Path": "path",
    "Check": "planning",
    "Plan": "planning",
    "SteeredPath": "steering",
    "Task": "planning",
    "plan": "route",
    "Robot": "robot",
    "Scene": "scene",
}

__all__ = [
    "METHODS",
    "Check",
    "HognoseError",
    "InfeasibleError",
    "InputError",
    "MissingExtraError",
    "Path",
    "Plan",
    "Robot",
    "Scene",
    "SteeredPath",
    "Task",
    "__version__",
    "follow",
    "follower",
    "load_robot",
    "load_task",
    "plan",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'hognose' has no attribute {name!r}")
    return getattr(import_module(f"hognose.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
