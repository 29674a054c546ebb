"""A continuous motion between set-points, as certificates see it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hognose.planning.certificate.bound import Array, Pieces


@dataclass(frozen=True, eq=False)
class Moving:
    """A motion between T set-points.

    Attributes
    ----------
    parameters : (T, k)
        At the set-points.
    place
        Makes parameters and ends of the chords of given parameters: in the middle of intervals.
    travel
        Makes of pieces how far (m, p+1) the ends of the chords move, and how far they bulge.
    straight
        Whether ends of chords move along straight lines at a steady speed but for their bulge, so that the motions of
        two chords may be subtracted; else only how far each goes is known.
    """

    parameters: Array
    place: Callable[[Array], tuple[Array, Array]]
    travel: Callable[[Pieces], tuple[Array, Array]]
    straight: bool
