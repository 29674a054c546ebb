"""Checks of what public functions are given: a wrong argument is an `InputError` that names it."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping
from numbers import Integral, Real
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hognose.errors import InputError
from hognose.plain_text import is_plain
from hognose.units import LARGEST_LENGTH

Kind = TypeVar("Kind")


def floats(
    what: str, given: ArrayLike, shape: str, unit: str = "m", largest: float = math.inf, finite: bool = True
) -> NDArray[np.float64]:
    """A new contiguous array, so that kernels are compiled for one type only.

    Parameters
    ----------
    what
        The argument's name.
    given
        Numbers: no texts, no truth values, nothing complex.
    shape
        Named or numbered axes, as in "(q, 3)"; "..." in front stands for any number of axes.
    unit
        Of the numbers, for the message.
    finite
        Whether entries that are not finite are refused here.
    largest
        Greatest magnitude that makes sense; squares of what is far beyond it overflow.

    Raises
    ------
    InputError
        If `given` has not the shape, or an entry is no finite number or too large.
    """
    expected = f"expected numbers{f' in {unit}' if unit else ''} of shape {shape}"
    try:
        array = np.asarray(given)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{what}: {expected}, got {_short(given)} that is no array") from None
    if array.dtype.kind not in "fiu":
        raise InputError(f"{what}: {expected}, got {_called(array)}")
    array = np.array(array, dtype=np.float64, order="C")
    if not _fits(array.shape, shape):
        raise InputError(f"{what}: {expected}, got shape {array.shape}")
    if finite and not np.isfinite(array).all():
        raise InputError(f"{what}: {expected}, but {np.count_nonzero(~np.isfinite(array))} values are not finite")
    if array.size and largest < math.inf and (worst := float(np.abs(array).max())) > largest:
        raise InputError(f"{what}: {expected}, none beyond {largest:,.0f} {unit}, got {worst:.4g} {unit}")
    return array


def coordinates(what: str, given: ArrayLike, shape: str) -> NDArray[np.float64]:
    """As `floats`, for places in m: none farther away than any space for a snake arm."""
    return floats(what, given, shape, "m", LARGEST_LENGTH)


def pair(
    first: str, starts: ArrayLike, second: str, ends: ArrayLike, shape: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Two arrays of places of the same shape; an InputError if they are not."""
    a, b = coordinates(first, starts, shape), coordinates(second, ends, shape)
    if a.shape != b.shape:
        raise InputError(f"{first} has shape {a.shape} but {second} {b.shape}; expected the same {shape}")
    return a, b


def real(what: str, given: Any, expected: str, suits: Callable[[float], bool]) -> float:
    """One number that suits, or an InputError that says what is expected."""
    if isinstance(given, np.ndarray) and given.shape == ():
        given = given[()]
    if isinstance(given, Real) and not isinstance(given, bool):
        try:
            value = float(given)
        except OverflowError:
            value = math.nan
        if suits(value):
            return value
    raise InputError(f"{what}: expected {expected}, got {_short(given)}")


def positive(what: str, given: Any, unit: str = "m") -> float:
    """One finite number above 0."""
    return real(what, given, f"a number above 0 {unit}", lambda value: 0 < value < math.inf)


def limit(what: str, given: Any) -> float:
    """A length (m) of 0 or more that may be infinite."""
    return real(what, given, "zero, a length in m, or infinity", lambda value: value >= 0)


def whole(what: str, given: Any, low: int, high: int | None = None) -> int:
    """One whole number from `low` to `high`."""
    if isinstance(given, Integral) and not isinstance(given, bool):
        number = int(given)
        if low <= number and (high is None or number <= high):
            return number
    span = f"from {low} on" if high is None else f"from {low} to {high}"
    raise InputError(f"{what}: expected a whole number {span}, got {_short(given)}")


def several(what: str, given: Any, kind: type[Kind], expected: str) -> list[Kind]:
    """The items of a list or another collection, all of a class."""
    if (
        not isinstance(given, Iterable)
        or isinstance(given, str | bytes | Mapping)
        or getattr(given, "shape", None) == ()
    ):
        raise InputError(f"{what}: expected a list of which each is {expected}, got {_short(given)}")
    return [instance(f"{what}: item {k}", item, kind, expected) for k, item in enumerate(given, 1)]


def instance(what: str, given: Any, kind: type[Kind], expected: str) -> Kind:
    """A value of a class, or an InputError that says where such values come from."""
    if not isinstance(given, kind):
        raise InputError(f"{what}: expected {expected}, got {_short(given)}")
    return given


def file_name(what: str, given: Any) -> Path:
    """The name of a file, as text or a path."""
    if isinstance(given, str | os.PathLike):
        name = os.fspath(given)
        if isinstance(name, str) and name:
            return Path(name)
    raise InputError(f"{what}: expected the name of a file, got {_short(given)}")


def plain_name(file: str) -> str:
    """The name of a file that is to be named in a task, where no control characters may be."""
    if not is_plain(file):
        raise InputError(f"{file}: the file's name holds a control character; rename it")
    return file


def _fits(shape: tuple[int, ...], wanted: str) -> bool:
    axes = [axis for axis in wanted.strip("()").replace(" ", "").split(",") if axis]
    if axes[:1] == ["..."]:
        axes = axes[1:]
        shape = shape[max(0, len(shape) - len(axes)) :]
    return len(axes) == len(shape) and all(
        not want.isdigit() or int(want) == have for want, have in zip(axes, shape, strict=True)
    )


def _called(array: NDArray[Any]) -> str:
    kinds = {"b": "truth values", "c": "complex numbers", "U": "text", "S": "bytes", "O": "something else"}
    return kinds.get(array.dtype.kind, f"values of type {array.dtype}")


def _short(given: Any) -> str:
    """A value in a message: its own words if they are few, else its type."""
    if given is None or isinstance(given, str | bytes | float | complex | bool | Path):
        text = repr(given)
    elif isinstance(given, int):
        text = str(given) if abs(given) < 10**30 else "a number of more than 30 digits"
    elif isinstance(given, Real):  # of NumPy
        text = str(given)
    else:
        text = ""
    return text if 0 < len(text) <= 60 else f"a value of type {type(given).__name__}"
