"""What a plan is judged by: one object for each check."""

from __future__ import annotations

import inspect
import logging
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any

from hognose.errors import InputError
from hognose.plain_text import is_plain
from hognose.planning.checks.check import Check
from hognose.planning.checks.findings import failure
from hognose.planning.checks.shared import Shared
from hognose.planning.motion import Motion

#: What is told of progress while criteria of Hognose are judged.
KINEMATICS, CLEARANCE = "checking kinematics", "certifying clearance"

_KEY = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")


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
        SI unit of its values: m, rad, s, m/s, rad/s, rad/s², N, counts, or 1.
    judge
        Takes the motion and what criteria share of it, and returns the verdicts, normally one; none where the
        criterion does not apply to the motion. `most`, `least` and `not_judged` make them; key, name and unit are
        added. Its docstring says in a sentence what must hold.
    stage
        What is told of progress while it is judged.
    basis
        Whether everything rests on it: where it fails, criteria after it are not judged.

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

    def __post_init__(self) -> None:
        if not (isinstance(self.key, str) and _KEY.fullmatch(self.key)):
            raise InputError(f"key: expected lower-case words joined by _, as bend_limits, got {self.key!r:.60}")
        for field in ("name", "unit", "stage"):
            text = getattr(self, field)
            if not (isinstance(text, str) and text and is_plain(text)):
                raise InputError(f"{field} of the criterion {self.key}: expected a text, got {text!r:.60}")
        if not callable(self.judge):
            raise InputError(
                f"judge of the criterion {self.key}: expected a function of a motion and of what criteria share, "
                f"got {self.judge!r:.60}"
            )

    @property
    def says(self) -> str:
        """What must hold, in a sentence; empty if nobody wrote it."""
        said = inspect.getdoc(self.judge) if inspect.isroutine(self.judge) else None
        return " ".join((said or "").partition("\n\n")[0].split())

    def verdicts(self, motion: Motion, shared: Shared) -> tuple[Check, ...]:
        """The verdicts on a motion."""
        return tuple(self._named(_placed(found, motion)) for found in self.judge(motion, shared))

    def guarded(self, motion: Motion, shared: Shared) -> tuple[Check, ...]:
        """The verdicts on a motion; whatever goes wrong in making them is a verdict, too: a failure that says it."""
        try:
            return self.verdicts(motion, shared)
        except (Exception, SystemExit) as error:
            logging.getLogger(__name__).debug("the criterion %s cannot be judged", self.key, exc_info=True)
            said = " ".join(f"{type(error).__name__}: {error}".split())
            return (self._named(failure(f"it could not be judged: {said}")),)

    def _named(self, found: Check) -> Check:
        return replace(found, key=self.key, name=self.name, unit=self.unit)


def _placed(found: Any, motion: Motion) -> Check:
    """A verdict in plain types, with the section of its link or cable.

    Raises
    ------
    InputError
        It is no verdict, or its place is none of the motion's.
    """
    if not isinstance(found, Check):
        raise InputError(f"its judge gave a {type(found).__name__}, expected verdicts (hognose.Check)")
    sizes = {"section": motion.robot.sections, "link": motion.robot.sections, "cable": motion.robot.cables}
    place: dict[str, int | None] = {"step": _number("step", found.step, 0, len(motion.time) - 1)}
    place |= {name: _number(name, getattr(found, name), 1, most) for name, most in sizes.items()}
    section, cable = place["section"], place["cable"]
    if section is None:
        place["section"] = place["link"] if cable is None else int(motion.robot.cable_sections[cable - 1]) + 1
    ok = None if found.ok is None else bool(found.ok)
    return replace(found, ok=ok, value=float(found.value), limit=float(found.limit), detail=str(found.detail), **place)


def _number(name: str, given: Any, low: int, high: int) -> int | None:
    if given is None:
        return None
    if int(given) != given or not low <= given <= high:
        raise InputError(f"it names {name} {given}, expected {low} to {high}")
    return int(given)
