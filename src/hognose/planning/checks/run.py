"""All criteria there are, and the verdicts on a motion."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hognose.arguments import several
from hognose.errors import InputError
from hognose.extensions import added
from hognose.extensions import home as package_of
from hognose.planning.checks import actuation, base, clearance, geometry, mechanics, motion
from hognose.planning.checks.check import Check
from hognose.planning.checks.criterion import Criterion
from hognose.planning.checks.shared import Shared
from hognose.planning.motion import Motion

Progress = Callable[[str], None]

#: The criteria of Hognose itself, in the order in which they are judged.
OWN = (
    *geometry.CRITERIA,
    *motion.CRITERIA,
    *base.CRITERIA,
    *actuation.CRITERIA,
    *mechanics.CRITERIA,
    *clearance.CRITERIA,
)
#: What every plan is judged by. What is appended here counts for whatever is planned, read or shown afterwards.
ALL: list[Criterion] = list(OWN)

_EXPECTED = "a hognose.planning.checks.Criterion"


def run_checks(
    plan: Motion,
    progress: Progress = lambda stage: None,
    measured: NDArray[np.float64] | None = None,
    more: Iterable[Criterion] = (),
) -> tuple[Check, ...]:
    """Every check of a plan, from its angles, feeds and joints; nothing stored is believed.

    A criterion that is not of Hognose itself and that cannot be judged, whatever goes wrong, fails and says why.

    Parameters
    ----------
    plan
        With or without checks of its own.
    progress
        Called with the name of each stage.
    measured : (T, n) m, optional
        The clearance at `plan.body`, if it was only just measured.
    more
        Criteria besides those of `ALL` and of installed packages.

    Raises
    ------
    InputError
        A task that contradicts itself; arrays of the wrong shape; what is no criterion among the criteria, or two of
        the same key.
    """
    plan.refuse_misshapen()
    shared, checks, stage = Shared(plan, measured), [], ""
    for criterion, home in _with_homes(more):
        if criterion.stage != stage:
            stage = criterion.stage
            progress(stage)
        with np.errstate(all="ignore"):  # times and limits may be anything; what is infinite or no number fails
            own = criterion in OWN
            found = criterion.verdicts(plan, shared) if own else criterion.guarded(plan, shared, home)
        checks += found
        # One of ours that is not judged leaves nothing to judge by; one of others lacks only what it asks for.
        if criterion.basis and any(check.failed or (own and not check.judged) for check in found):
            break
    return tuple(checks)


def criteria(more: Iterable[Criterion] = ()) -> tuple[Criterion, ...]:
    """All criteria: those of `ALL`, those of installed packages, and more, in this order.

    Raises
    ------
    InputError
        What is no criterion, or two of the same key; says where each is from.
    """
    return tuple(criterion for criterion, _ in _with_homes(more))


def _with_homes(more: Iterable[Criterion]) -> list[tuple[Criterion, str]]:
    """As `criteria`, each with where it comes from, in words."""
    homes: dict[str, str] = {}
    found: list[tuple[Criterion, str]] = []
    for home, given in _groups(more):
        for each in several(home, given, Criterion, _EXPECTED):
            if each.key in homes:
                raise InputError(
                    f"{home}: the key {each.key!r} is that of another check, from {homes[each.key]}; expected a key of "
                    "its own"
                )
            homes[each.key] = home
            found.append((each, home))
    return found


def _groups(more: Any) -> Iterator[tuple[str, Any]]:
    """Criteria by where they are from."""
    yield "hognose.planning.checks.ALL", ALL
    for name, given in added("checks").items():
        home = f"the entry {name!r} of hognose.checks in the package {package_of('checks', name)}"
        if not isinstance(given, Criterion | list | tuple):  # what can be gone through once would be judged once
            raise InputError(f"{home}: expected {_EXPECTED}, or a list of them, got {type(given).__name__}")
        yield home, [given] if isinstance(given, Criterion) else given
    yield "more", more
