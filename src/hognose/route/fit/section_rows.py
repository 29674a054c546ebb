"""How angles of sections that bend along their length change with a path: as its directions at their ends.

A section bends by what the path turns between its ends. That is so where the body is on the path and its directions do
not ring; else it is a guess of the way down, and the steps are judged by where they lead.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hognose.rotations import rotations_of_vectors

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def section_frames(angles: Array, axes: Array) -> Array:
    """Frames (T, n+1, 3, 3) at the ends of sections, in columns: each turns by exp(α e_y + β e_x), from axes (T, 3, 3).

    So does an arc. A stack of joints is twisted a little besides.
    """
    steps, sections = angles.shape[:2]
    out = np.empty((steps, sections + 1, 3, 3))
    out[:, 0] = axes
    vectors = np.stack([angles[..., 1], angles[..., 0], np.zeros(angles.shape[:2])], axis=-1)
    turns = rotations_of_vectors(vectors.reshape(-1, 3)).reshape(steps, sections, 3, 3)
    for i in range(sections):
        out[:, i + 1] = out[:, i] @ turns[:, i]
    return out


def section_rows(turned: Array, frame: Array, step: Index, section: Index, axis: Index) -> Array:
    """Derivatives (q, f, 3) of chosen angles by the coordinates of f way-points.

    Parameters
    ----------
    turned : (T, n+1, f)
        How much the path's direction at the ends of sections turns with each way-point.
    frame : (T, n+1, 3, 3)
        As of `section_frames`.
    step, section, axis : (q,)
        Which angles; axis 0 is α.
    """
    sign = np.where(axis == 0, 1.0, -1.0)[:, None]
    behind, before = sign * frame[step, section + 1, :, axis], sign * frame[step, section, :, axis]
    after, here = turned[step, section + 1], turned[step, section]
    return after[:, :, None] * behind[:, None, :] - here[:, :, None] * before[:, None, :]
