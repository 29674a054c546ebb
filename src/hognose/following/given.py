"""What followers of sections of any kinds are given besides the path: the base's axes, and lengths beside a model."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from hognose.arguments import floats
from hognose.errors import InputError
from hognose.following.follower import Array
from hognose.robot.sections import MixedSections

#: Lengths of sections may differ so much (m) from the model's: rounding.
_ROUNDING = 1e-9
#: Unit vectors that differ by less point the same way.
_ALONG = 1e-6


def axes_of_base(axes: ArrayLike) -> Array:
    """Axes of a base, as they are given: (3, 3), in columns; an InputError if they are not a right-handed frame."""
    found = floats("axes", axes, "(3, 3)", "", 2.0)
    if np.abs(found.T @ found - np.eye(3)).max() > 1e-6 or np.linalg.det(found) < 0.0:
        raise InputError(
            "axes: expected three unit vectors in columns, perpendicular to each other and right-handed; a task's are "
            "`task.base.R_task_base`"
        )
    return found


def check_along(third: Array, tangent: Array) -> None:
    """Raise an InputError unless the third axis (3,) of a base is the direction (3,) in which a path begins."""
    if np.linalg.norm(third - tangent) > _ALONG:
        raise InputError(
            f"axes: the third one is {_written(third)}, and the path begins along {_written(tangent)}; expected the "
            "same direction, in which the straight arm lies. Leave axes out to have those that turn least"
        )


def _written(direction: Array) -> str:
    return f"({', '.join(f'{part + 0.0:.4g}' for part in direction.tolist())})"


def check_lengths(lengths: Array, model: MixedSections) -> None:
    """Raise an InputError if lengths (n,) m are not those of a model's sections."""
    own = np.add.reduceat(model.table[:, 2], model.first[:-1])
    if lengths.size != own.size or np.abs(lengths - own).max() > _ROUNDING:
        raise InputError(
            f"link_lengths: expected those of the model's {own.size} sections, {', '.join(f'{x:g}' for x in own)} m: "
            "give a robot's link_lengths together with its model"
        )
