"""What a following method of another package must keep to, and the errors if it does not."""

from __future__ import annotations

import logging
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.arguments import real
from hognose.errors import InfeasibleError, InputError
from hognose.extensions import home, words_of

Array = NDArray[np.float64]

#: Lengths of links may be off by so much (m) whatever the tolerance: rounding.
_ROUNDING = 1e-11
#: Of an exception's text, at most so many characters are repeated.
_LONGEST = 300


def is_own(method: type) -> bool:
    """Whether a method is one of Hognose."""
    return method.__module__.partition(".")[0] == "hognose"


@contextmanager
def faults_named(method: type) -> Iterator[None]:
    """Turn exceptions into InputErrors that name the method and its package; not for Hognose's own methods.

    An InfeasibleError is passed on: it is not a fault that a link cannot be placed.
    """
    if is_own(method):
        yield
        return
    try:
        yield
    except InfeasibleError:
        raise
    except InputError as error:
        raise InputError(f"{_called(method)}: {error}") from error.__cause__
    except (Exception, SystemExit) as error:
        logging.getLogger(__name__).debug("%s failed", _called(method), exc_info=True)
        said = textwrap.shorten(words_of(error), _LONGEST, placeholder=" …")
        raise InputError(f"{_called(method)} failed: {said}; mend it, or take another method") from error


def checked_tolerance(given: Any, lengths: Array) -> float:
    """A method's tolerance (m); an InputError if it is so large, or no number, that checks with it could not fail."""
    shortest = float(lengths.min())
    expected = f"a length of at least 0 m and less than that of the shortest link, {shortest:g} m"
    return real("its tolerance", given, expected, lambda value: 0.0 <= value < shortest)


def checked_outcome(outcome: Any, feeds: Array, joints: Array, lengths: Array, tolerance: float) -> tuple[int, int]:
    """What `_advance` returned, after a check of it and of the joints.

    Parameters
    ----------
    outcome
        As returned.
    feeds : (T,) m
    joints : (T, n+1, 3) m
        NaN before they were filled.
    lengths : (n,) m
    tolerance : m
        By how much a link's length may be off.

    Raises
    ------
    InputError
        No pair of a step and a link; a joint that is not finite; a link of a wrong length.
    """
    step, link = _pair(outcome, *joints.shape[:2])
    solved, places = joints, joints.reshape(-1, 3)
    if step >= 0:  # up to the joint before the link that found no place
        solved, places = joints[:step], places[: step * joints.shape[1] + link + 1]
    lost = np.flatnonzero(~np.isfinite(places).all(axis=1))
    if lost.size:
        at, joint = divmod(int(lost[0]), joints.shape[1])
        raise InputError(
            f"{_step(at, feeds)}: it leaves joint {joint + 1} without a place, {places[lost[0]].tolist()}; expected "
            "finite coordinates in m"
        )
    with np.errstate(over="ignore"):
        found = np.linalg.norm(np.diff(solved, axis=1), axis=2)
    off = np.abs(found - lengths)
    if off.size and off.max() > max(tolerance, _ROUNDING):
        at, worst = map(int, np.unravel_index(off.argmax(), off.shape))
        raise InputError(
            f"{_step(at, feeds)}: its joints make link {worst + 1} {1e3 * found[at, worst]:.9g} mm long; expected "
            f"{1e3 * lengths[worst]:.9g} mm to its tolerance of {1e3 * tolerance:.3g} mm"
        )
    return step, link


def _pair(outcome: Any, steps: int, joints: int) -> tuple[int, int]:
    whole = isinstance(outcome, tuple | list) and len(outcome) == 2 and all(isinstance(k, Integral) for k in outcome)
    if whole:
        step, link = map(int, outcome)
        if (step, link) == (-1, -1) or (0 <= step < steps and 0 <= link < joints - 1):
            return step, link
    said = textwrap.shorten(repr(outcome), 60, placeholder=" …")
    raise InputError(
        f"its `_advance` returned {said}; expected SOLVED, (-1, -1), or the step, 0 to {steps - 1}, and the link, 0 to "
        f"{joints - 2}, that could not be placed, with the joints filled in where they were asked for"
    )


def _step(step: int, feeds: Array) -> str:
    return f"step {step}, feed {1e3 * float(feeds[step]):.2f} mm"


def _called(method: type) -> str:
    """A method and its package: `method 'secant' of my-package`."""
    name = getattr(method, "name", method.__qualname__)
    package = home("methods", name)
    return f"method {name!r} of {package if package != 'hognose' else f'the module {method.__module__}'}"
