"""A case of the suite: an arm, a path and the feeds to follow it with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.cached import cached_property
from hognose.evaluation.reference import first_crossings
from hognose.path import Path
from hognose.robot.sections import MixedSections

Array = NDArray[np.float64]

#: The paper's arm: 12 links of 91 mm, joints to 0.5 rad, 3.5 mm a step.
LINKS, PITCH, LIMIT, STEP = 12, 0.091, 0.5, 0.0035
SPACING = 0.0005


@dataclass(frozen=True, eq=False)
class Case:
    """An arm, a path and the feeds to follow it with.

    Attributes
    ----------
    family, name : str
    path : Path
        Starts with a straight run along z, as long as the arm.
    link_lengths : (n,) m
    feeds : (T,) m
    bend_limit : float, rad
        Of each of the two angles of every joint.
    spacing : float, m
        Distance sd of the points, for the methods that use them.
    model
        How the sections bend, if they are no rigid links; the limit is of their whole angles.
    """

    family: str
    name: str
    path: Path
    link_lengths: Array
    feeds: Array
    bend_limit: float = LIMIT
    spacing: float = SPACING
    model: MixedSections | None = None

    @cached_property
    def reference(self) -> tuple[Array, Array]:
        """Where the joints of rigid links belong: positions (T, n+1, 3) m and arc lengths (T, n+1) m."""
        return first_crossings(self.path, self.link_lengths, self.feeds)


def feeds_to(last: float, step: float) -> Array:
    """Feeds (T,) m from 0 to the last one, a step (m) apart but for the last step."""
    return np.append(np.arange(0.0, last - 0.5 * step, step), last)
