"""Keyframes that followers of one arm on one path share: what one has found, the next need not find again.

A plan makes several followers of the same path: to find its end, to follow it, to check it. What they find at a
keyframe depends on the path, the arm and its base alone, so they find the same.
"""

from __future__ import annotations

import hashlib
import threading
from collections import OrderedDict
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hognose.path import Path

Array = NDArray[np.float64]

#: So many sets of keyframes are kept, those last asked for.
_MOST = 8
#: A straight end goes on along the path before it if its direction differs by no more than this.
_ALIKE = 1e-12


@dataclass
class Keyframes:
    """What is known of them.

    Attributes
    ----------
    found
        The first of them, in rows, and how many; both are replaced together, and the rows are never changed.
    freedom : (m,)
        How free lengths are at each, of arms that extend; empty until it is found, which `found` is of.
    """

    found: tuple[Array, int]
    freedom: Array


_kept: OrderedDict[bytes, Keyframes] = OrderedDict()
_lock = threading.Lock()


def keyframes_of(columns: int, *values: Array) -> Keyframes:
    """Those that belong to some values, the same object for the same values; blank ones of so many columns if new."""
    digest = hashlib.sha256()
    for value in values:
        digest.update(str(value.shape).encode() + b"\0" + np.ascontiguousarray(value).tobytes())
    key = digest.digest()
    with _lock:
        found = _kept.pop(key, None) or Keyframes((np.empty((0, columns)), 0), np.empty(0))
        _kept[key] = found
        while len(_kept) > _MOST:
            _kept.popitem(last=False)
    return found


def without_straight_end(path: Path) -> tuple[Path, float]:
    """A path without the straight way behind it, and how long (m) that is: however long it is, poses are the same."""
    count, straight = len(path.coefficients), 0.0
    while count > 1:
        way = path.coefficients[count - 1]
        rest = Path(path.breaks[:count], path.coefficients[: count - 1])
        if way[2:].any() or np.abs(way[1] - rest.tangent(rest.length)).max() > _ALIKE:
            break
        straight += float(path.breaks[count] - path.breaks[count - 1])
        count -= 1
    return (Path(path.breaks[: count + 1], path.coefficients[:count]) if straight else path), straight
