"""The verdict, always on top of the panel: good or not, why, and a way to where it fails."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TYPE_CHECKING

from hognose.planning.base_words import base_words, profile_figures, profile_words
from hognose.planning.link_budgets import at_the_tip
from hognose.planning.loads import in_a_line
from hognose.viewer.model.freshness import Standing
from hognose.viewer.model.workbench import Verdict, Workbench

if TYPE_CHECKING:
    import viser

#: So many sentences are shown of what is wrong.
MOST_PROBLEMS = 4
PLANNING = "### planning …"
#: Above what is shown of the task before the last edit.
BEFORE = "*before: not of the current task*"
STEERED = "### Steered by hand\n\n*the plan is shown again when steering ends*"


def plain(text: str) -> str:
    """Text that Markdown shows as it is: names in a file of somebody's must not become pictures, links or code."""
    return re.sub(r"([\\`*_{}\[\]<>#|!&~])", r"\\\1", text)


def _duration(seconds: float) -> str:
    """A duration in ms, or in s from a second on."""
    return f"{seconds:.1f} s" if seconds >= 1.0 else f"{1e3 * seconds:.0f} ms"


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
        self._said: tuple[Verdict, bool, list[str]] | None = None  # the lines last made, and of what
        self._words = gui.add_markdown("planning …")
        self._show = gui.add_button("Show where", visible=False, hint="the step at which it fails by most")

        @self._show.on_click
        def _(event: viser.GuiEvent) -> None:
            del event
            if self._step is not None:
                go(self._step)

    def show(self, standing: Standing, steered: bool, motion: bool) -> None:
        """Show the task's verdict, or that it is planned; `motion` says whether an arm is shown at all."""
        verdict = standing.verdict
        settled = standing.settled and not steered
        self._step = verdict.step if verdict is not None and settled else None
        self._show.visible = self._step is not None
        if steered:
            self._words.content = STEERED
        elif verdict is None:
            self._words.content = PLANNING
        else:
            lines = self._once(verdict, motion) if settled else [PLANNING, f"*before: {plain(verdict.headline)}*"]
            made = f"planned and checked in {_duration(verdict.seconds)}" if settled else ""
            state = " · ".join(filter(None, (made, self._kept())))
            lines = [*lines, plain(self._bench.draft_fault), f"*{state}*" if state else ""]
            self._words.content = "\n\n".join(filter(None, lines))

    def _once(self, verdict: Verdict, motion: bool) -> list[str]:
        """The lines of a verdict, made once: what tolerances take at the tip costs some ms, 30 times a second."""
        if self._said is None or self._said[0] is not verdict or self._said[1] != motion:
            self._said = (verdict, motion, self._lines(verdict, motion))
        return self._said[2]

    def _lines(self, verdict: Verdict, motion: bool) -> list[str]:
        if verdict.good:
            proven, _, closest = verdict.headline.partition(", ")
            lines = [f"### {proven}", plain(closest)]
            if verdict.plan is not None and verdict.plan.task.budget is not None:
                lines.append(f"*{plain(at_the_tip(verdict.plan))}*")
            if verdict.plan is not None and verdict.plan.held is not None:
                lines.append(f"*{plain(in_a_line(verdict.plan))}*")
        else:
            shown = [f"- {plain(problem)}" for problem in verdict.problems[:MOST_PROBLEMS]]
            more = len(verdict.problems) - len(shown)
            lines = [
                f"### {'NO MOTION' if verdict.plan is None else 'NOT GOOD'}",
                "\n".join([*shown, *([f"- and {more} more"] if more else [])]),
                "*drag the way-points, find a route, or undo (Ctrl+Z)*",
            ]
        lines += [f"*{plain(check.sentence)}*" for check in verdict.checks if not check.judged]
        lines.append(f"*{plain(base_words(verdict.task))}*")
        if verdict.plan is not None and profile_figures(verdict.plan)["kind"] != "constant":
            lines.append(f"*{plain(profile_words(verdict.plan))}*")
        if verdict.plan is None and motion:
            lines.append("*the grey arm shows the previous motion; it does not belong to this task*")
        return lines

    def _kept(self) -> str:
        """What is to be known of edits that were not saved."""
        if self._bench.is_current(self._restored):
            return "unsaved edits of the last session; undo reverts them"
        return "not saved" if self._bench.dirty else ""
