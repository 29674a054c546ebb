"""What a plan is judged by: one object for each check."""

from __future__ import annotations

import inspect
import logging
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from hognose.errors import InputError
from hognose.extensions import words_of
from hognose.plain_text import is_plain, plain
from hognose.planning.checks.check import Check
from hognose.planning.checks.findings import failure
from hognose.planning.checks.returned import plain_verdict, refuse_contradiction
from hognose.planning.checks.shared import Shared
from hognose.planning.motion import Motion

#: What is told of progress while criteria of Hognose are judged.
KINEMATICS, CLEARANCE = "checking kinematics", "certifying clearance"

_KEY = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")
_FACTOR = "(1|m|rad|s|kg|A|K|N|Pa|J|W|V|Hz|counts)[²³]?"
_UNIT = re.compile(rf"{_FACTOR}([·/ ]{_FACTOR})*")


@dataclass(frozen=True)
class Criterion:
    """One thing that must hold of every plan.

    Attributes
    ----------
    key
        By which programs find its verdict: lower-case words joined by `_`. It never changes.
    name
        As people read it.
    unit
        SI unit of its values: m, rad, s, m/s, rad/s, rad/s², N, counts, 1, or another made of SI units without prefix
        (kg is one), as N·m, 1/m or m².
    judge
        Takes the motion and what criteria share of it, and returns the verdicts, normally one; none where the
        criterion does not apply to the motion. `most`, `least` and `not_judged` make them; key, name and unit are
        added. Its docstring says in a sentence what must hold.
    stage
        What is told of progress while it is judged.
    basis
        Whether everything rests on it: where it fails, criteria after it are not judged.
    mendable
        Whether another route may pass where one fails. Where none may, as with a fault of the robot, a search for a
        route ends at the first one that fails.

    Raises
    ------
    InputError
        A key, name or unit that is none, or a judge that cannot be called.
    """

    key: str
    name: str
    unit: str
    judge: Callable[[Motion, Shared], Iterable[Check]]
    stage: str = "making more checks"
    basis: bool = False
    mendable: bool = True

    def __post_init__(self) -> None:
        if not (isinstance(self.key, str) and _KEY.fullmatch(self.key)):
            raise InputError(f"key: expected lower-case words joined by _, such as bend_limits, got {self.key!r:.60}")
        for field in ("name", "unit", "stage"):
            text = getattr(self, field)
            if not (isinstance(text, str) and text and is_plain(text)):
                raise InputError(f"{field} of the criterion {self.key}: expected a line of text, got {text!r:.60}")
        if not _UNIT.fullmatch(self.unit):
            raise InputError(
                f"unit of the criterion {self.key}: {self.unit!r:.60} is no SI unit; expected one such as m, rad, s, "
                "m/s, rad/s², N, N·m, counts, or 1 for a number without one; values in mm or degrees must be converted"
            )
        if not callable(self.judge):
            raise InputError(
                f"judge of the criterion {self.key}: expected a function that takes a motion and a Shared, "
                f"got {self.judge!r:.60}"
            )

    @property
    def says(self) -> str:
        """What must hold, in a sentence; empty if nobody wrote it."""
        said = inspect.getdoc(self.judge) if inspect.isroutine(self.judge) else None
        return " ".join((said or "").partition("\n\n")[0].split())

    def verdicts(self, motion: Motion, shared: Shared) -> tuple[Check, ...]:
        """The verdicts on a motion."""
        return tuple(self._named(plain_verdict(found, motion)) for found in self.judge(motion, shared))

    def guarded(self, motion: Motion, shared: Shared, home: str) -> tuple[Check, ...]:
        """The verdicts on a motion; whatever goes wrong in making them is a verdict, too: a failure that says it.

        Parameters
        ----------
        motion
        shared
        home
            Where the criterion comes from, for that failure.
        """
        try:
            checks = self.verdicts(motion, shared)
            for check in checks:
                refuse_contradiction(check)
        except (Exception, SystemExit) as error:
            logging.getLogger(__name__).debug("the criterion %s cannot be judged", self.key, exc_info=True)
            why = str(error) if isinstance(error, InputError) else words_of(error)
            said = f"it could not be judged: {plain(why)}; the check {self.key} comes from {home}"
            return (self._named(failure(said)),)
        return checks

    def _named(self, found: Check) -> Check:
        return replace(found, key=self.key, name=self.name, unit=self.unit)
