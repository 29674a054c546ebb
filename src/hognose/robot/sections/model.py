"""The protocol of all section models."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class SectionModel(Protocol):
    """How the sections of an arm bend, and what follows from their configuration.

    A section begins at a joint and ends at the next one; its configuration is a pair of angles (α, β). Robots
    and the certificate of interpolated joints ask the model. For a section that bends along its length, `chords` is
    above 1, and `vertices` has points between the joints; such are refused by the certificate so far.

    Attributes
    ----------
    chords
        Straight pieces that stand for the centre line of one section.
    """

    @property
    def chords(self) -> int:
        """Straight pieces that stand for the centre line of one section."""
        ...

    def angles(self, joints: Array) -> Array:
        """Inverse resolution: configurations (T, n, 2) rad of joints (T, n+1, 3) m; the base points along +z.

        Raises
        ------
        InputError
            A section whose two ends are the same point.
        """
        ...

    def positions(self, angles: Array, feeds: Array, lengths: Array) -> tuple[Array, Array]:
        """Joints (T, n+1, 3) m and frames of the tip (T, 3, 3) of configurations (T, n, 2) rad and feeds (T,) m."""
        ...

    def vertices(self, joints: Array) -> Array:
        """Ends (T, p+1, 3) m of the p chords of the whole centre line, for joints (T, n+1, 3) m."""
        ...

    def bulges(self, low: Array, high: Array, lengths: Array) -> Array:
        """How far (m, p+1) m vertices leave their straight lines while configurations go linearly from low to high.

        Parameters
        ----------
        low, high : (m, n, 2) rad
        lengths : (n,) m
        """
        ...
