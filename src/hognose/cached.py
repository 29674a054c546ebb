"""Values that are computed once and kept: properties without a lock, and arrays that nobody can alter."""

from __future__ import annotations

import functools
from collections.abc import Callable
from contextlib import nullcontext
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Value = TypeVar("Value")
Number = TypeVar("Number", bound=np.generic)


class cached_property(functools.cached_property[Value]):  # noqa: N801
    """As in `functools`, where before Python 3.12 all objects of a class share a lock.

    With it, threads that plan different tasks wait for each other, and in a process that was forked while one of them
    held it nobody ever lets go of it. Two threads that ask the same object at the same time compute the value twice.
    """

    def __init__(self, func: Callable[[Any], Value]) -> None:
        super().__init__(func)
        self.lock = nullcontext()


def read_only(array: NDArray[Number]) -> NDArray[Number]:
    """The same numbers in an array that cannot be written to: a copy where the given one can be."""
    if _is_settled(array):
        return array
    copy = array.copy()
    copy.flags.writeable = False
    return copy


def _is_settled(array: NDArray[Any]) -> bool:
    """Whether nobody can write to the memory of an array by way of it, or of what it is a view of."""
    seen: Any = array
    while isinstance(seen, np.ndarray):
        if seen.flags.writeable:
            return False
        seen = seen.base
    return seen is None


class cached_array(cached_property[NDArray[Any]]):  # noqa: N801
    """As `cached_property`, for an array: whoever asks for it gets the same one, and cannot write to it."""

    def __init__(self, func: Callable[[Any], NDArray[Any]]) -> None:
        super().__init__(lambda owner: read_only(func(owner)))
        self.__doc__ = func.__doc__
