"""Where the largest of values is, if rounding may have decided between equal ones.

Two processors round differently, and so may two versions of a library on one. Of values that differ by rounding only
the first is taken, on every machine: a symmetric space gives everybody the same detour and the same worst place.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Values closer than this, relative to the largest magnitude among them, count as equal.
ROUNDING = 1e-9


def first_largest(values: NDArray[Any]) -> tuple[int, ...]:
    """Index of the first value that is the largest but for rounding, in as many parts as `values` has axes.

    NaN is larger than any value.
    """
    largest = values.max()
    if np.isfinite(largest):
        smallest = values.min()
        if not np.isfinite(smallest):
            smallest = values[np.isfinite(values)].min()
        first = int(np.argmax(values >= largest - ROUNDING * max(abs(largest), abs(smallest))))
    else:
        first = int(np.argmax(values))
    return tuple(int(i) for i in np.unravel_index(first, values.shape))


def first_smallest(values: NDArray[Any]) -> tuple[int, ...]:
    """Index of the first value that is the smallest but for rounding; see `first_largest`."""
    return first_largest(-values)
