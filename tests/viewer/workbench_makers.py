"""Workbenches and tasks for the viewer's tests."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable

import hognose
from hognose.planning import Task, TaskSpec
from hognose.viewer.model import edits

#: How long (s) a state is waited for; a machine that is slower still sets the variable to 2 or 10.
LONG = 180.0 * float(os.environ.get("HOGNOSE_TEST_PATIENCE", "1"))
ROBOT = hognose.load_robot("sjtu-25dof")


def small() -> Task:
    """A task that is planned at once."""
    spec = {
        "name": "small",
        "robot": "sjtu-25dof",
        "path": {"way_points": [(0, 0, 0), (0.02, 0.01, 0.2), (0.03, 0.04, 0.4)]},
        "motion": {"step": 0.02, "period_s": 1.0},
        "obstacle": [{"kind": "sphere", "name": "ball", "center": (0.1, 0, 0.2), "diameter": 0.05}],
    }
    return Task(TaskSpec.model_validate(spec), ROBOT)


def eventually(holds: Callable[[], object], what: str = "it did not come to hold") -> None:
    """Wait until something holds."""
    end = time.monotonic() + LONG
    while not holds():
        assert time.monotonic() < end, what
        time.sleep(0.01)


def move(index: int, *place: float) -> edits.Change:
    """Put a way-point at x, y, z."""
    return edits.move_way_point(index, place)


def ours() -> list[str]:
    """Names of the threads of workbenches that are there."""
    return [thread.name for thread in threading.enumerate() if thread.name.startswith("hognose-")]
