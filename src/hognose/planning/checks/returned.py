"""What judges return, in plain types: what is no verdict is refused in a sentence."""

from __future__ import annotations

from dataclasses import fields
from numbers import Real
from typing import Any

import numpy as np

from hognose.arguments import real
from hognose.errors import InputError
from hognose.plain_text import plain
from hognose.planning.checks.check import Check
from hognose.planning.motion import Motion


def plain_verdict(found: Any, motion: Motion) -> Check:
    """A verdict in plain types, with the section of its link or cable.

    NumPy's numbers, truth values and texts become Python's, so that the verdict can be written to a file.

    Raises
    ------
    InputError
        It is no verdict, a field of it is of another type, or its place is none of the motion's.
    """
    if not isinstance(found, Check):
        raise InputError(f"its judge gave a {type(found).__name__}, expected verdicts, each a hognose.Check")
    said: dict[str, Any] = {each.name: getattr(found, each.name) for each in fields(Check)}
    said["ok"] = None if found.ok is None else _truth("ok", found.ok, "True, False, or None if it was not judged")
    for name in ("at_least", "is_bound"):
        said[name] = _truth(name, said[name], "True or False")
    for name in ("value", "limit"):
        said[name] = _figure(name, said[name])
    for name in ("key", "name", "unit", "detail"):
        said[name] = _text(name, said[name], "a text")
    if found.obstacle is not None:
        said["obstacle"] = _text("obstacle", found.obstacle, "the name of an obstacle, or None")
    said.update(_place(found, motion))
    return Check(**said)


def refuse_contradiction(found: Check) -> None:
    """Raise an InputError if a verdict says that its check passed, but its figures say that it did not."""
    if found.ok and not found.figures_agree:
        expected = "at least" if found.at_least else "at most"
        raise InputError(
            f"its judge says that it passed, but its value is {found.value:.12g} and its limit {found.limit:.12g}; "
            f"expected a value that is {expected} the limit, or NaN for both if there are no figures"
        )


def _place(found: Check, motion: Motion) -> dict[str, int | None]:
    sections, cables = motion.robot.sections, motion.robot.cables
    place = {
        "step": _number("step", found.step, 0, len(motion.time) - 1),
        "section": _number("section", found.section, 1, sections),
        "link": _number("link", found.link, 1, sections),
        "cable": _number("cable", found.cable, 1, cables),
    }
    cable = place["cable"]
    if place["section"] is None:
        place["section"] = place["link"] if cable is None else int(motion.robot.cable_sections[cable - 1]) + 1
    return place


def _truth(name: str, given: Any, expected: str) -> bool:
    if not isinstance(given, bool | np.bool_):
        raise InputError(f"its judge gave {name} = {given!r:.60}, expected {expected}")
    return bool(given)


def _figure(name: str, given: Any) -> float:
    try:
        return real(name, given, "a number", lambda number: True)
    except InputError:
        raise InputError(f"its judge gave {name} = {given!r:.60}, expected a number") from None


def _text(name: str, given: Any, expected: str) -> str:
    if not isinstance(given, str):
        raise InputError(f"its judge gave {name} = {given!r:.60}, expected {expected}")
    return plain(str(given))


def _number(name: str, given: Any, low: int, high: int) -> int | None:
    if given is None:
        return None
    number = isinstance(given, Real) and not isinstance(given, bool)
    place = next((each for each in range(low, high + 1) if number and each == given), None)
    if place is None:
        raise InputError(f"its judge names {name} {given!s:.60}, expected a whole number from {low} to {high}")
    return place
