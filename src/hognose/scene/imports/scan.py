"""What is done to a scan after it is read: returns that are none dropped, and points put together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.errors import InputError

Floats = NDArray[np.float64]


def without_invalid(points: Floats, drop: bool) -> tuple[Floats, tuple[str, ...]]:
    """Return the points (p, 3) that a sensor saw, and what is to be said of it.

    Sensors write 0 0 0 or NaN for a ray without a return. The first is left as a point unless asked otherwise.

    Raises
    ------
    InputError
        A coordinate is not finite, and `drop` is false; or no point is left.
    """
    bad = ~np.isfinite(points).all(axis=1)
    if not drop:
        if bad.any():
            raise InputError(
                f"{int(bad.sum()):,} of {len(points):,} corners or points have coordinates that are not finite numbers "
                "(NaN or infinity); remove them, or say `drop_invalid = true`"
            )
        return points, ()
    bad |= ~points.any(axis=1)
    if bad.all():
        raise InputError(f"all {len(points):,} points are invalid returns (0 0 0, NaN or infinity)")
    dropped = int(bad.sum())
    return points[~bad], (
        f"{dropped:,} points that are invalid returns (0 0 0, NaN or infinity) dropped",
    ) if dropped else ()


def thinned(points: Floats, distance: float) -> Floats:
    """Return fewer points (p, 3), so that each of the given ones lies within `distance` of one of them.

    Space is cut into cubes whose diagonal is twice the distance, and the points in each are replaced by the middle of
    their bounding box, from which none of them is farther than half a diagonal.
    """
    pitch = 2 * distance / np.sqrt(3) * (1 - 1e-6)  # less than could be, for what is rounded off
    low = points.min(axis=0)
    with np.errstate(over="ignore", invalid="ignore"):
        cells = (points - low) / pitch
    if not (cells < 2.0**52).all():
        return points  # the cubes are finer than the numbers are
    cells = np.floor(cells).astype(np.int64)
    order = np.lexsort(cells.T)
    cells = cells[order]
    begins = np.flatnonzero(np.append(True, (cells[1:] != cells[:-1]).any(axis=1)))
    inside = points[order]
    lowest, highest = np.minimum.reduceat(inside, begins), np.maximum.reduceat(inside, begins)
    return lowest + (highest - lowest) / 2
