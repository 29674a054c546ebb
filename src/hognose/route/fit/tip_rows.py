"""Residuals of where the nose points at the target."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.route.fit.motion import Motion

Array = NDArray[np.float64]


def tip_rows(
    motion: Motion, tip: Array, wished: Array | None, cone: float, unit: float, basis: Array
) -> tuple[Array, Array]:
    """Residuals (r,) and their derivatives (r, 3 f): the nose points along `tip` (3,), wished is another way.

    It is taken to turn as the last chord does.

    Parameters
    ----------
    motion, tip
    wished : (3,), optional
        Unit vector; None if any will do.
    cone, unit : rad
        By how much it may differ, and what counts as one.
    basis : (T, p+1, f)
        How much ends of chords move with each way-point.
    """
    if wished is None or np.arccos(np.clip(tip @ wished, -1, 1)) <= 0.9 * cone:
        return np.empty(0), np.empty((0, 3 * basis.shape[-1]))
    length = np.linalg.norm(motion.line[-1, -1] - motion.line[-1, -2])
    turned = (basis[-1, -1] - basis[-1, -2]) / length
    rows = turned[None, :, None] * np.eye(3)[:, None, :]
    return (tip - wished) / unit, rows.reshape(3, -1) / unit
