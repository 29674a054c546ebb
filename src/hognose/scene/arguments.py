"""Checks of the arrays a scene is given."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.errors import InputError


def floats(what: str, given: ArrayLike, shape: str) -> NDArray[np.float64]:
    """Return a new contiguous array, so that the kernels are compiled for one type only.

    Raises
    ------
    InputError
        If `given` has not the `shape` (named or numbered axes, as in "(q, 3)") or an entry is not finite.
    """
    try:
        array = np.array(given, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} cannot be read as an array of numbers; expected shape {shape}") from error
    wanted = shape.strip("(),").replace(" ", "").split(",")
    fits = len(wanted) == array.ndim and all(
        not want.isdigit() or int(want) == have for want, have in zip(wanted, array.shape, strict=True)
    )
    if not fits:
        raise InputError(f"{what} has shape {array.shape}; expected {shape}")
    if not np.isfinite(array).all():
        raise InputError(f"{what} has entries that are not finite; expected numbers in metres")
    return array


def pair(
    first: str, starts: ArrayLike, second: str, ends: ArrayLike, shape: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return two arrays of the same shape; raise an InputError if they are not."""
    a, b = floats(first, starts, shape), floats(second, ends, shape)
    if a.shape != b.shape:
        raise InputError(f"{first} has shape {a.shape} but {second} {b.shape}; expected the same {shape}")
    return a, b


def limit(what: str, length: float) -> float:
    """Return a length that may be infinite; raise an InputError if it is negative or not a number."""
    if not length >= 0:
        raise InputError(f"{what} is {length}; expected zero, a length in metres, or infinity")
    return float(length)
