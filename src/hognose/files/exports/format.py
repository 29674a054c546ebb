"""What a format of exports is."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from hognose.errors import InputError
from hognose.planning import Task
from hognose.planning.plan import Plan
from hognose.robot import Robot


@dataclass(frozen=True)
class Content:
    """A file that does not stand alone, or of which something must be said.

    Attributes
    ----------
    data
        The file itself.
    beside
        Files that it names, by their path from its folder, as in "meshes/wall.obj". A name goes with its content: what
        is there already under this name is the same, or older.
    remarks
        What is not in it, or otherwise than one would think, in sentences.
    """

    data: bytes
    beside: Mapping[str, bytes] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()


#: What the functions of a format return.
Written: TypeAlias = bytes | Content


@dataclass(frozen=True)
class Export:
    """A format that plans are exported in.

    Attributes
    ----------
    suffix
        Of its files, as in ".csv": small letters and digits after one dot.
    what
        What such a file holds, in a line without its end.
    write
        The content of a file, from a plan that was verified only just now.
    of_task, of_robot
        The content for a task without a motion, and for a robot alone; None where there must be a plan.
    """

    suffix: str
    what: str
    write: Callable[[Plan], Written]
    of_task: Callable[[Task], Written] | None = None
    of_robot: Callable[[Robot], Written] | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.suffix, str) or not re.fullmatch(r"\.[a-z0-9]{1,20}", self.suffix):
            raise InputError(f"suffix: expected a dot and small letters, as in '.csv', got {self.suffix!r:.60}")
        if not callable(self.write):
            raise InputError(f"write: expected a function from a plan to bytes, got {type(self.write).__name__}")
        for name in ("of_task", "of_robot"):
            given = getattr(self, name)
            if given is not None and not callable(given):
                raise InputError(f"{name}: expected a function or None, got {type(given).__name__}")
