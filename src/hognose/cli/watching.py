"""Three ways to show a run that is followed: redrawn in place, in lines, and as JSON."""

from __future__ import annotations

import json
import shutil
import sys
import time
from typing import TYPE_CHECKING, Any, Protocol

from hognose.plain_text import plain

if TYPE_CHECKING:
    from hognose.drive.live.seen import Most, Seen
    from hognose.drive.record.messages import CycleRow, Event

#: It is redrawn at most so often (s), with so many events.
_REDRAWN, _EVENTS = 0.1, 6
_BAR = 30
KEYS = "p: pause   space or s: stop at once   r: retract   q: leave, the run goes on"


class Shown(Protocol):
    """A way to show a run."""

    def see(self, seen: Seen, came: CycleRow | Event | None) -> None:
        """Show what came, and what is seen with it."""
        ...

    def rest(self, seen: Seen) -> None:
        """Nothing more came for now."""
        ...

    def end(self, seen: Seen, words: str, lost: bool) -> None:
        """Show how it ended, in words, and whether the program that ran it is gone."""
        ...


class JsonLines:
    """A JSON object a line: the run, cycles so far apart (s), events, the end."""

    def __init__(self, seen: Seen, every: float) -> None:
        run = {key: value for key, value in seen.run.items() if key not in ("topics", "kind", "token")}
        self._every = Every(every)
        _line({"kind": "run", **run})

    def see(self, seen: Seen, came: CycleRow | Event | None) -> None:
        """See `Shown`."""
        from hognose.drive.record.messages import Event

        if isinstance(came, Event):
            _line({"kind": "event", "time_s": came.time, "event": came.kind, "text": came.text, "node": came.node,
                   "step": came.step})  # fmt: skip
        elif came is not None and self._every.is_due(came.time):
            _line({"kind": "cycle", **seen.cycle_json()})

    def rest(self, seen: Seen) -> None:
        """See `Shown`."""

    def end(self, seen: Seen, words: str, lost: bool) -> None:
        """See `Shown`."""
        _line({"kind": "end", "good": seen.good, "verdict": seen.verdict, "lost": lost, "words": words})


class Lines:
    """Lines for people: cycles so far apart (s), events, the end."""

    def __init__(self, seen: Seen, every: float) -> None:
        self._every = Every(every)
        _say(title(seen))

    def see(self, seen: Seen, came: CycleRow | Event | None) -> None:
        """See `Shown`."""
        from hognose.drive.record.messages import Event

        if isinstance(came, Event):
            _say(came.words)
        elif came is not None and self._every.is_due(came.time):
            _say(f"{came.time:9.3f} s  " + "; ".join(figures(seen)))

    def rest(self, seen: Seen) -> None:
        """See `Shown`."""

    def end(self, seen: Seen, words: str, lost: bool) -> None:
        """See `Shown`."""
        _say(words)


class Screen:
    """Redrawn in place, by the codes that every terminal knows."""

    def __init__(self, has_keys: bool) -> None:
        self._keys, self._drawn, self._last = KEYS if has_keys else "", 0, -_REDRAWN

    def see(self, seen: Seen, came: CycleRow | Event | None) -> None:
        """See `Shown`."""

    def rest(self, seen: Seen) -> None:
        """See `Shown`."""
        if time.monotonic() - self._last >= _REDRAWN:
            self._last = time.monotonic()
            self._draw([*screen(seen), "", self._keys, seen.answer])

    def end(self, seen: Seen, words: str, lost: bool) -> None:
        """See `Shown`."""
        self._draw([*screen(seen), ""])
        _say(words)

    def _draw(self, lines: list[str]) -> None:
        width = shutil.get_terminal_size().columns
        up = f"\x1b[{self._drawn}A" if self._drawn else ""
        text = "".join(f"\r\x1b[K{plain(line)[: width - 1]}\n" for line in lines)
        sys.stdout.write(f"{up}{text}\x1b[J")
        sys.stdout.flush()
        self._drawn = len(lines)


class Every:
    """Says what is due of what has times, so far apart (s) at least."""

    def __init__(self, every: float) -> None:
        self._every, self._last = every, float("-inf")

    def is_due(self, now: float) -> bool:
        """Whether it is, at a time (s)."""
        if now - self._last < self._every - 1e-9:
            return False
        self._last = now
        return True


def title(seen: Seen) -> str:
    """Whose run it is."""
    return f"{seen.run['task']}, {seen.run['robot']}: {seen.run['record']}"


def figures(seen: Seen) -> list[str]:
    """The last cycle, in a few words each."""
    row = seen.cycle
    if row is None:
        return ["no cycle yet"]
    speed = "" if seen.speed is None else f" at {100 * seen.speed:.0f} % of the plan's speed"
    found = [f"{row.state}, step {row.progress:.1f} of {seen.run['steps']}{speed}"]
    band = f", band ±{seen.run['tension_band_N']:g} N around the plan's"
    found.append(f"tensions {_figure(seen.least_tension, 'N')} to {_figure(seen.largest_tension, 'N')}{band}")
    following = seen.following
    node = "" if following is None else f", node {seen.node(following.cable)}"
    found.append(f"largest following error {_figure(following, 'counts')}{node}")
    if row.slider_commanded == row.slider_commanded:  # there is a slider
        found.append(f"slider {1e3 * row.slider_commanded:.2f} mm, measured {1e3 * row.slider_measured:.2f} mm")
    left_out = f", {seen.left_out} cycles were not seen here" if seen.left_out else ""
    found.append(f"{1e3 * row.lateness:.2f} ms late{left_out}")
    if seen.pictures:
        found.append(f"{seen.pictures} pictures of the tip camera")
    return found


def screen(seen: Seen) -> list[str]:
    """The lines of the screen but for its foot."""
    row = seen.cycle
    share = 0.0 if row is None else min(max(row.progress / max(int(seen.run["steps"]), 1), 0.0), 1.0)
    full = round(share * _BAR) if share == share else 0
    elapsed = 0.0 if row is None else row.time
    bar = f"[{'#' * full}{'.' * (_BAR - full)}] {elapsed:.1f} s"
    events = [event.words for event in list(seen.events)[-_EVENTS:]]
    return [title(seen), bar, *figures(seen), "", *events]


def _figure(most: Most | None, unit: str) -> str:
    return "unknown" if most is None else f"{most.value:.4g} {unit} (cable {most.cable + 1})"


def _say(text: str) -> None:
    sys.stdout.write(plain(text) + "\n")
    sys.stdout.flush()


def _line(said: dict[str, Any]) -> None:
    sys.stdout.write(json.dumps(said) + "\n")
    sys.stdout.flush()
