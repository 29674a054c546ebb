"""The protocol of all section models."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class SectionModel(Protocol):
    """How the sections of an arm bend, and what follows from their configuration.

    A section begins at a joint and ends at the next one; its configuration is a pair of angles (α, β). Robots,
    clearances, certificates and steering ask the model. A section that bends along its length has several chords:
    `vertices` has points between its joints, and the body is thicker by what the centre line leaves the chords.

    Attributes
    ----------
    chords
        Straight pieces that stand for the centre line of each section: one number for all, or one each (n,).
    """

    @property
    def chords(self) -> int | NDArray[np.int64]:
        """Straight pieces that stand for the centre line of each section."""
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
        """Joints (T, n+1, 3) m and frames of the tip (T, 3, 3) of configurations (T, n, 2) rad and feeds (T,) m.

        Lengths are (n,) m, or (T, n) m of sections that extend.
        """
        ...

    def vertices(self, joints: Array, angles: Array | None = None) -> Array:
        """Ends (..., p+1, 3) m of the p chords of the whole centre line, for joints (..., n+1, 3) m as in `angles`.

        Their angles (..., n, 2) rad need not be found where they are known.
        """
        ...

    def arcs(self, lengths: Array) -> Array:
        """Length (p,) m of the centre line that each chord stands for, of sections (n,) m."""
        ...

    def smooth(self, lengths: Array) -> NDArray[np.bool_]:
        """At which inner ends (p-1,) of the chords the body goes on without a joint, for sections (n,) m."""
        ...

    def sagitta(self, lengths: Array, limits: Array) -> Array:
        """How far (p,) m the centre line leaves each chord at most, for sections (n,) m and limits (n, 2) rad."""
        ...

    def sharpest(self, lengths: Array, limits: Array) -> Array:
        """Curvature (n,) 1/m up to which each section follows every path, arguments as of `sagitta`."""
        ...

    def bulges(self, low: Array, high: Array, lengths: Array, spin: Array, swing: Array) -> Array:
        """How far (m, p+1) m vertices leave their straight lines while configurations go linearly from low to high.

        Parameters
        ----------
        low, high : (m, n, 2) rad
        lengths : (n,) or (2, m, n) m
            Of sections that extend, those between which they go linearly, too.
        spin : (m, 3) rad
            Angular velocity of the base meanwhile, in the arm's own axes at first, the whole way taking unit time.
        swing : (m,) m
            Largest acceleration of the first joint meanwhile.
        """
        ...
