"""What a scene answers when asked for distances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.ties import first_smallest


@dataclass(frozen=True, eq=False)
class Clearance:
    """Clearances of moving links, from `Scene.clearance`.

    Attributes
    ----------
    value : (T, n)
        Distance from the link's axis to the closest triangle minus the link's radius, m. Negative if the
        link cuts a surface, down to minus its radius. **A value at the horizon is a lower bound.**
    triangle : (T, n) int32
        The closest triangle of the scene, or -1 at the horizon.
    horizon : float
        Clearances from here on were not looked for, m.
    """

    value: NDArray[np.float64]
    triangle: NDArray[np.int32]
    horizon: float

    def smallest(self) -> tuple[float, int, int]:
        """Return the smallest clearance (m), and the step and the link that have it."""
        step, link = first_smallest(self.value)
        return float(self.value.min()), step, link


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of independent segments, from `Scene.distance`; q segments.

    Attributes
    ----------
    value : (q,)
        Distance from the segment to the closest triangle, m; `upper` if nothing is closer than that.
    on_segment, on_mesh : (q, 3)
        The closest points, m; NaN if nothing is closer than `upper`.
    triangle : (q,) int32
        The closest triangle, or -1 if nothing is closer than `upper`.
    """

    value: NDArray[np.float64]
    on_segment: NDArray[np.float64]
    on_mesh: NDArray[np.float64]
    triangle: NDArray[np.int32]


@dataclass(frozen=True)
class Witness:
    """Where a segment and the scene come closest.

    Attributes
    ----------
    obstacle
        The obstacle's name, or None if the scene is empty.
    distance
        Distance of the two points, m; infinite if the scene is empty.
    on_segment, on_mesh
        The two points (x, y, z), m; NaN if the scene is empty.
    """

    obstacle: str | None
    distance: float
    on_segment: tuple[float, float, float]
    on_mesh: tuple[float, float, float]
