"""Whether what the page shows is about the task as it is now."""

from __future__ import annotations

from hognose.viewer.model.workbench import Verdict, Workbench

#: Edits must have rested so long (s) before a verdict is shown as the task's, and planning may take so long (s) before
#: what is seen of the version before turns grey: verdicts come many times a second while somebody drags, and nothing
#: shall flicker.
CALM = 0.2


class Standing:
    """The newest verdict, and whether it still counts. Only the page's thread may look.

    Attributes
    ----------
    verdict
        The newest one when last looked; None before the first.
    settled
        Whether it is on the task as it is now, and nobody is just editing: only then it is the task's verdict.
    outdated
        Whether the motion that is drawn is not the task's: there is none, or it is still being planned.
    """

    def __init__(self, bench: Workbench) -> None:
        self._bench = bench
        self._number = bench.number
        self._rested, self._waited = CALM, 0.0
        self.verdict: Verdict | None = None
        self.settled = self.outdated = False

    def look(self, seconds: float) -> bool:
        """Look again, some time later; whether there is another verdict."""
        before, self.verdict = self.verdict, self._bench.verdict  # the verdict first: it may only seem older than it is
        number, verdict = self._bench.number, self.verdict
        current = verdict is not None and self._bench.is_current(verdict.number)
        self._rested = self._rested + seconds if number == self._number else 0.0
        self._waited = 0.0 if current or verdict is not before else self._waited + seconds
        self._number = number
        self.settled = current and self._rested >= CALM
        self.outdated = self._waited >= CALM or (verdict is not None and verdict.plan is None)
        return verdict is not before
