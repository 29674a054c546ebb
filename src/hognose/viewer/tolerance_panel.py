"""The budget of tolerances: for each link what they take, which of them takes most, and what they leave."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hognose.errors import HognoseError
from hognose.planning import Plan, Tolerances, tolerances
from hognose.report.page import table
from hognose.report.tolerance_section import CAPTION, has_tolerances
from hognose.ties import first_largest
from hognose.viewer.model.freshness import Standing
from hognose.viewer.model.workbench import Verdict
from hognose.viewer.verdict_panel import BEFORE, plain

if TYPE_CHECKING:
    import viser

#: Above the columns of what takes most of a link's clearance, and of how much.
LARGEST = ("largest part", "takes")
#: The look of the table within a panel that is narrow: words are
#: wrapped, so that it fits whatever the font is; numbers are not.
LOOK = """<style>
.hognose-links { padding: 0 .25rem .5rem .75rem; font-size: 11px; line-height: 1.55; }
.hognose-links .wide { overflow-x: auto; }
.hognose-links table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
.hognose-links th, .hognose-links td { text-align: left; padding: 0 .5em 0 0; }
.hognose-links :is(th, td):last-child { padding-right: 0; }
.hognose-links tbody th { font-weight: 400; }
.hognose-links td.number { text-align: right; white-space: nowrap; }
.hognose-links th.number { text-align: right; }
</style>"""


def links_table(found: Tolerances) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """The headings and rows of the table of links, with the largest part of each alone instead of all parts."""
    link, *parts, together, step, leaves = found.headings
    rows = []
    for budget, (number, *each, taken, at, left) in zip(found.links, found.rows, strict=True):
        (largest,) = first_largest(np.array(list(budget.parts.values())))
        rows.append((number, parts[largest], each[largest], taken, at, left))
    return (link, *LARGEST, together, step, leaves), rows


class TolerancePanel:
    """A folder that is closed at first, and not there where there are no tolerances; only the page's thread may show.

    The budget and the drawn arms take as long as planning does, so they are made only of a verdict that has settled:
    nothing is done while somebody drags.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        self._of: Verdict | None = None
        self._folder = gui.add_folder("tolerances", expand_by_default=False, visible=False)
        with self._folder:
            self._before = gui.add_markdown(BEFORE, visible=False)
            self._words = gui.add_markdown("")
            self._table = gui.add_html("")
            self._sums = gui.add_markdown("")

    def show(self, standing: Standing, steered: bool) -> None:
        """Show the budget of the newest motion, once it is settled; until then the one before."""
        verdict = standing.verdict
        plan = None if verdict is None or steered else verdict.plan
        if plan is None or not has_tolerances(plan.task):
            self._folder.visible = False
            return
        if standing.settled and verdict is not self._of:
            self._of = verdict
            self._fill(plan)
        self._before.visible = verdict is not self._of or not standing.settled
        self._folder.visible = self._of is not None

    def _fill(self, plan: Plan) -> None:
        try:
            found = tolerances(plan)
        except HognoseError as error:
            self._words.content = plain(str(error))
            self._table.visible = self._sums.visible = False
            return
        words = [plain(text) for text in found.sentences if text != found.headline]  # which the verdict says
        if found.links:
            words.append(f"*{plain(CAPTION)}*")
            self._table.content, self._sums.content = links_html(found), f"*{plain(found.sums)}*"
        self._words.content = "\n\n".join(words)
        self._table.visible = self._sums.visible = bool(found.links)


def links_html(found: Tolerances) -> str:
    """The table of links as HTML; every text is escaped."""
    headings, rows = links_table(found)
    body = table(headings, rows, numbers=[column for column in range(len(headings)) if column != 1])
    return f'<div class="hognose-links">{LOOK}{body}</div>'
