"""What a follower has seen of a run so far, in figures."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hognose.drive.live.frames import Message
from hognose.drive.live.outbox import CYCLE, EVENTS, PICTURES
from hognose.drive.record import messages
from hognose.drive.record.messages import CycleRow, Event
from hognose.drive.record.writer import VERDICT

#: Verdicts of good runs begin so.
_GOOD = "GOOD"
#: The speed is a mean over so much time (s).
_OVER = 0.5


class Most(NamedTuple):
    """The largest or smallest figure of the cables: its value, and the cable (from 0)."""

    value: float
    cable: int


class Seen:
    """Takes what comes of a run.

    Parameters
    ----------
    run
        What it says of itself at first.

    Attributes
    ----------
    run
    cycle
        The last one; None before the first.
    events
        The last of them, in order.
    pictures
        How many came.
    left_out
        Cycles that were not sent, as this follower was slow.
    verdict
        How the run ended, in a sentence; None as long as it has not said so.
    answer
        What came of what was asked for last, in words; empty if nothing was.
    """

    def __init__(self, run: Mapping[str, Any]) -> None:
        self.run = run
        self.cycle: CycleRow | None = None
        self.events: deque[Event] = deque(maxlen=100)
        self.pictures = self.left_out = 0
        self.verdict: str | None = None
        self.answer = ""
        self._places: deque[tuple[float, float]] = deque()

    def add(self, came: Message | Mapping[str, Any]) -> CycleRow | Event | None:
        """Take a message or a word; the cycle or the event in it, if it is one.

        Raises
        ------
        ValueError
            It is none of a run.
        """
        if not isinstance(came, Message):
            self._hear(came)
        elif came.topic == CYCLE:
            return self._see(messages.cycle_row(came.data))
        elif came.topic == EVENTS:
            event = messages.event(came.data)
            self.events.append(event)
            self.verdict = event.text if event.kind == VERDICT else self.verdict
            return event
        elif came.topic == PICTURES:
            self.pictures += 1
        return None

    @property
    def good(self) -> bool:
        """Whether the run has ended well."""
        return self.verdict is not None and self.verdict.startswith(_GOOD)

    @property
    def speed(self) -> float | None:
        """As a share of the plan's own, below 0 on the way back; None where it is not known."""
        if len(self._places) < 2:
            return None
        (before, start), (now, place) = self._places[0], self._places[-1]
        return (place - start) / (now - before) * float(self.run["step_s"]) if now > before else None

    @property
    def least_tension(self) -> Most | None:
        """In N."""
        return None if self.cycle is None else _most(self.cycle.tensions, -1.0)

    @property
    def largest_tension(self) -> Most | None:
        """In N."""
        return None if self.cycle is None else _most(self.cycle.tensions, 1.0)

    @property
    def following(self) -> Most | None:
        """The following error in counts that is farthest from 0."""
        if self.cycle is None:
            return None
        errors = self.cycle.following
        most = _most(np.abs(errors), 1.0)
        return None if most is None else Most(float(errors[most.cable]), most.cable)

    def node(self, cable: int) -> int:
        """The node of the drive of a cable."""
        return int(self.run["nodes"][cable])

    def cycle_json(self) -> dict[str, Any]:
        """The last cycle in a few figures for machines, in SI units; cables count from 1."""
        row = self.cycle
        if row is None:
            return {}
        following = self.following
        return {
            "time_s": row.time,
            "state": row.state,
            "step": _known(row.progress),
            "steps": self.run["steps"],
            "speed": self.speed,
            "least_tension_N": _json(self.least_tension),
            "largest_tension_N": _json(self.largest_tension),
            "largest_following_error_counts": None
            if following is None
            else {**(_json(following) or {}), "node": self.node(following.cable)},
            "slider_commanded_m": _known(row.slider_commanded),
            "slider_measured_m": _known(row.slider_measured),
            "lateness_s": _known(row.lateness),
            "pictures": self.pictures,
            "left_out": self.left_out,
        }

    def _see(self, row: CycleRow) -> CycleRow:
        self.cycle = row
        self._places.append((row.time, row.progress))
        while row.time - self._places[0][0] > _OVER:
            self._places.popleft()
        return row

    def _hear(self, said: Mapping[str, Any]) -> None:
        kind = said.get("kind")
        if kind == "left out":
            self.left_out += int(said.get("cycles", 0))
        elif kind == "accepted":
            confirmed = said.get("confirmed_at_terminal")
            self.answer = f"{said.get('want')}: asked for" + (
                "; it has to be confirmed at the terminal of the run" if confirmed else ""
            )
        elif kind == "not accepted":
            self.answer = str(said.get("words"))


def _most(values: NDArray[np.float64], sign: float) -> Most | None:
    known = np.isfinite(values)
    if not known.any():
        return None
    cable = int(np.argmax(np.where(known, sign * values, -np.inf)))
    return Most(float(values[cable]), cable)


def _json(most: Most | None) -> dict[str, Any] | None:
    return None if most is None else {"value": most.value, "cable": most.cable + 1}


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
