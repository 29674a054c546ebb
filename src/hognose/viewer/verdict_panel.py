"""The verdict, always on top of the panel: good or not, why, and a way to where it fails."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

from hognose.viewer.workbench import Verdict, Workbench

if TYPE_CHECKING:
    import viser

#: So many sentences are shown of what is wrong.
MOST_PROBLEMS = 4
STEERED = "### Steered by hand\n\n*the plan waits meanwhile*"


def plain(text: str) -> str:
    """Text that Markdown shows as it is: names in a file of somebody's must not become pictures, links or code."""
    return re.sub(r"([\\`*_{}\[\]<>#|!&~])", r"\\\1", text)


class VerdictPanel:
    """Words and a button; only the page's thread may show.

    Parameters
    ----------
    gui, bench
    go
        Called with the step of the motion that is to be looked at.
    """

    def __init__(self, gui: viser.GuiApi, bench: Workbench, go: Callable[[int], None]) -> None:
        self._bench = bench
        self._restored = bench.number if bench.dirty else -1
        self._step: int | None = None
        self._words = gui.add_markdown("planning …")
        self._show = gui.add_button("Show where", visible=False, hint="the step at which it fails by most")

        @self._show.on_click
        def _(event: viser.GuiEvent) -> None:
            del event
            if self._step is not None:
                go(self._step)

    def show(self, verdict: Verdict | None, steered: bool, motion: bool) -> None:
        """Show a verdict, or that there is none yet; `motion` says whether an arm is shown at all."""
        self._step = None if verdict is None or steered else verdict.step
        self._show.visible = self._step is not None
        if steered:
            self._words.content = STEERED
        elif verdict is None:
            self._words.content = "planning …"
        else:
            self._words.content = "\n\n".join(filter(None, self._lines(verdict, motion)))

    def _lines(self, verdict: Verdict, motion: bool) -> list[str]:
        if verdict.good:
            proven, _, closest = verdict.headline.partition(", ")
            lines = [f"### {proven}", plain(closest)]
        else:
            shown = [f"- {plain(problem)}" for problem in verdict.problems[:MOST_PROBLEMS]]
            more = len(verdict.problems) - len(shown)
            lines = [
                f"### {'NO MOTION' if verdict.plan is None else 'NOT GOOD'}",
                "\n".join([*shown, *([f"- and {more} more"] if more else [])]),
                "*drag the way-points, find a route, or undo (Ctrl+Z)*",
            ]
        if verdict.plan is None and motion:
            lines.append("*the arm shows the last motion that could be made*")
        return [*lines, plain(self._bench.draft_fault), f"*{self._state(verdict)}*"]

    def _state(self, verdict: Verdict) -> str:
        """How long it took, and what is to be known of the edits."""
        words = [f"planned and checked in {1e3 * verdict.seconds:.0f} ms"]
        if verdict.number != self._bench.number:
            words.append("planning …")
        if self._bench.number == self._restored:
            words.append("edits of last time, not saved; undo takes them back")
        elif self._bench.dirty:
            words.append("not saved")
        return " · ".join(words)
