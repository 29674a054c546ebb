"""Limits of bends that may differ from side to side."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: A side that is closed is open so far (rad), so that rounding does not bend a straight joint beyond it.
CLOSED = 1e-9


def both_sides(limits: Array) -> Array:
    """Bounds (..., 2), low and high, of limits (...) that hold to both sides."""
    return np.stack([-limits, limits], axis=-1)


def opened(bounds: Array) -> Array:
    """Bounds (..., 2) rad whose closed sides are open by `CLOSED`."""
    return np.stack([np.minimum(bounds[..., 0], -CLOSED), np.maximum(bounds[..., 1], CLOSED)], axis=-1)


def used(angles: Array, bounds: Array) -> Array:
    """How much of the limit on its side each angle (..., n, 2) uses, with bounds (n, 2, 2) of `opened`: 1 is all."""
    return np.maximum(angles / bounds[..., 1], angles / bounds[..., 0])


def beyond(angles: Array, bounds: Array, part: float = 1.0) -> Array:
    """How far each angle (..., n, 2) is beyond a part of its bounds (n, 2, 2); below 0 within them."""
    return np.maximum(angles - part * bounds[..., 1], part * bounds[..., 0] - angles)


def on_side(angles: Array, bounds: Array) -> Array:
    """The limit (..., n, 2), above 0, on the side to which each angle bends, with bounds (n, 2, 2)."""
    return np.where(angles < 0, -bounds[..., 0], bounds[..., 1])
