"""The places that a path has to pass, and what they are called where one of them is wrong."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from hognose.planning.task import Task


class Place(NamedTuple):
    """A place that a path has to pass.

    Attributes
    ----------
    key
        Of the task file, which says where it is.
    words
        What it is called: places are counted as they are in the file.
    at : (3,) m
    """

    key: str
    words: str
    at: NDArray[np.float64]


def places(task: Task) -> list[Place]:
    """The places of `Task.way_points`, each with its key and its name."""
    searched, stops = task.spec.path.target is not None, len(task.spec.path.stops)
    named = [] if task.nose is None else [("base.position", "the nose of the straight arm")]
    for number in range(stops):
        if number == 0:
            key, words = "entrance", "the entrance"
        elif number == stops - 1:
            key, words = "target", "the target"
        else:
            key, words = "via", f"the place via {number}" if searched else f"way-point {number + 1}"
        named.append((f"path.{key if searched else 'way_points'}", words))
    return [Place(*names, at) for names, at in zip(named, task.way_points, strict=True)]
