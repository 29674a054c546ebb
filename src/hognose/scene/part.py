"""One part of an obstacle: a mesh with a name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Part:
    """A mesh with a name.

    Attributes
    ----------
    name
        Empty for an obstacle that has one part only.
    triangles : (m, 3, 3)
        Corners, m, anticlockwise seen from outside; m > 0.
    growth
        How far the triangles are thickened on all sides, m.
    shell
        Parts with the same number of 0 or more are open, and together may enclose what none of them does: sides of one
        body that meet only to rounding.
    solid
        Whether there is an inside; if not, it is a surface, and only the distance to it counts.
    """

    name: str
    triangles: NDArray[np.float64]
    growth: float = 0.0
    solid: bool = True
    shell: int = -1
